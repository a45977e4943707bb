#include "evenstep/remap/filters.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstring>
#include <glm/vec3.hpp>
#include <limits>

#include "catch.h"

using namespace evenstep;

namespace {

using Complex = std::complex<long double>;
constexpr long double kPi = 3.14159265358979323846264338327950288L;
constexpr Rate kForceRate{1000, 1};
constexpr long double kRate_Hz = 1000;

/// Transfer functions in z^-1 as textbooks write them. That of OneEuro is the one of its first-order filter at min_cutoff.
Complex transfer(const MovingAverageSpec& spec, Complex z1) {
  Complex sum = 0, power = 1;
  for (int i = 0; i < spec.samples; ++i, power *= z1) sum += power;
  return sum / static_cast<long double>(spec.samples);
}
Complex transfer(const ButterworthSpec& spec, Complex z1) {
  const long double g = std::tan(kPi * spec.cutoff_Hz / kRate_Hz);
  const Complex s = (1.0L - z1) / (g * (1.0L + z1));
  return 1.0L / (s * s + std::sqrt(2.0L) * s + 1.0L);
}
Complex transfer(const OneEuroSpec& spec, Complex z1) {
  const long double tau_s = 1 / (2 * kPi * spec.min_cutoff_Hz), a = 1 / (1 + tau_s * kRate_Hz);
  return a / (1.0L - (1 - a) * z1);
}
Complex transfer(const FilterSpec& spec, long double frequency_Hz) {
  const Complex z1 = std::polar(1.0L, -2 * kPi * frequency_Hz / kRate_Hz);
  return std::visit([&](const auto& kind) { return transfer(kind, z1); }, spec);
}

/// Lag behind a ramp, in samples: the group delay at 0 Hz.
long double delay_samples(const MovingAverageSpec& spec) { return (spec.samples - 1) / 2.0L; }
long double delay_samples(const ButterworthSpec& spec) {
  return 1 / (std::sqrt(2.0L) * std::tan(kPi * spec.cutoff_Hz / kRate_Hz));
}
long double delay_samples(const OneEuroSpec& spec) { return kRate_Hz / (2 * kPi * spec.min_cutoff_Hz); }

long double delay_samples(const FilterSpec& spec) {
  return std::visit([](const auto& kind) { return delay_samples(kind); }, spec);
}

/// beta = 0: OneEuro is linear.
const std::vector<FilterSpec> kLinear{MovingAverageSpec{1},   MovingAverageSpec{2},  MovingAverageSpec{15},
                                      MovingAverageSpec{333}, ButterworthSpec{0.5},  ButterworthSpec{5},
                                      ButterworthSpec{30},    ButterworthSpec{250},  ButterworthSpec{499},
                                      OneEuroSpec{0.5, 0, 1}, OneEuroSpec{20, 0, 1}, OneEuroSpec{600, 0, 10}};

/// The number of samples after which only exp(-60) is left of what came before.
int settling_samples(const FilterSpec& spec) {
  if (const auto* average = std::get_if<MovingAverageSpec>(&spec)) return average->samples;
  const auto* butterworth = std::get_if<ButterworthSpec>(&spec);
  if (butterworth == nullptr) {
    const double w = 2 * 3.14159 * std::get<OneEuroSpec>(spec).min_cutoff_Hz / 1000;
    return static_cast<int>(60 / std::log(1 + w)) + 2;  // y keeps 1 - a = 1 / (1 + w) of its distance
  }
  const double g = std::tan(3.14159 * butterworth->cutoff_Hz / 1000), root = std::sqrt(2.0);
  const double radius_squared = std::abs((1 - root * g + g * g) / (1 + root * g + g * g));  // product of the poles
  return static_cast<int>(-120 / std::log(radius_squared)) + 2;
}

/// In [-1, 1), the same on every machine.
double noise(int n) {
  std::uint64_t h = static_cast<std::uint64_t>(n + 1) * 0x9e3779b97f4a7c15u;
  h ^= h >> 31;
  h *= 0xbf58476d1ce4e5b9u;
  return static_cast<double>(static_cast<std::int64_t>(h)) * 0x1p-63;
}

bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

}  // namespace

TEST_CASE("a filtered sine has the gain and phase of the transfer function at every frequency") {
  for (const FilterSpec& spec : kLinear) {
    for (const int hertz : {1, 3, 5, 30, 67, 125, 250, 333, 499}) {
      Filter<double> filter = make_filter<double>(spec, kForceRate);
      const Complex response = transfer(spec, hertz);
      const int settled = settling_samples(spec);
      long double worst = 0;
      for (int n = 0; n < settled + 1000; ++n) {
        // Turns are computed in integers, so that the angle stays exact in a long run.
        const Complex turning = std::polar(1.0L, 2 * kPi * (static_cast<std::int64_t>(n) * hertz % 1000) / 1000);
        const double y = filter.next(static_cast<double>(turning.imag()));
        if (n >= settled) worst = std::max(worst, std::abs(y - (response * turning).imag()));
      }
      INFO("kind " << spec.index() << ", delay " << delay_samples(spec) << ", " << hertz << " Hz");
      // A second is a whole number of turns, so if every sample is right, gain and phase are right. Each sample rounds by a
      // few 2^-53. A rounding error stays for about as many samples as the delay (450 at most): 1e-13 if all have one sign.
      CHECK(worst < 2e-13L);
    }
  }
}

TEST_CASE("a butterworth filter is at -3 dB at its cutoff and falls from 1 to 0 without a ripple") {
  for (const double cutoff_Hz : {0.01, 1.0, 30.0, 100.0, 250.0, 400.0, 499.0}) {
    const ButterworthSpec spec{cutoff_Hz};
    CHECK(std::norm(transfer(FilterSpec{spec}, cutoff_Hz)) == Approx(0.5L).epsilon(1e-15));
    long double before = 1;
    for (int k = 1; k < 1000; ++k) {
      const long double gain = std::abs(transfer(FilterSpec{spec}, k / 2.0L));
      CHECK(gain <= before * (1 + 1e-15L));
      before = gain;
    }
  }
}

TEST_CASE("the -3 dB points that the header states for the others are there") {
  const auto gain = [](const FilterSpec& spec, long double hertz) { return std::abs(transfer(spec, hertz)); };
  const long double half = std::sqrt(0.5L);
  for (int samples = 2; samples <= 200; ++samples) {
    const long double hertz = 0.443L * kRate_Hz / std::sqrt(samples * samples - 1.0L);
    CHECK(gain(MovingAverageSpec{samples}, 0.97L * hertz) > half);
    CHECK(gain(MovingAverageSpec{samples}, 1.03L * hertz) < half);
  }
  for (const double cutoff_Hz : {0.1, 1.0, 10.0, 100.0, 700.0}) {
    const OneEuroSpec spec{cutoff_Hz, 0, 1};
    const long double w = 2 * kPi * cutoff_Hz / kRate_Hz, a = w / (1 + w), b = 1 - a;
    const long double hertz = std::acos(1 - a * a / (2 * b)) * kRate_Hz / (2 * kPi);
    CHECK(gain(spec, hertz) == Approx(half).epsilon(1e-12));
    if (cutoff_Hz <= 1) CHECK(hertz == Approx(cutoff_Hz).epsilon(1e-2));
  }
  CHECK(gain(OneEuroSpec{0.829 / 0.171 * 1000 / 6.2832, 0, 1}, 500) > half);  // a = 0.829 > 2 (sqrt(2) - 1): never half
}

TEST_CASE("every filter lets a constant through bit for bit from its first sample on") {
  std::vector<FilterSpec> specs = kLinear;
  specs.push_back(OneEuroSpec{1, 5, 1});
  for (const FilterSpec& spec : specs) {
    for (const double value : {0.0, -1.0 / 3, 0.1, 1e-300, -1e300, 0x1.fffffffffffffp+10}) {
      Filter<double> filter = make_filter<double>(spec, kForceRate);
      for (int n = 0; n < 2000; ++n) REQUIRE(same_bits(filter.next(value), value));
    }
  }
}

TEST_CASE("after a step every filter arrives at the new value") {
  for (const FilterSpec& spec : kLinear) {
    Filter<double> filter = make_filter<double>(spec, kForceRate);
    filter.next(-0.7);
    double y = -0.7;
    for (int n = 0; n < settling_samples(spec); ++n) y = filter.next(0.3);
    // Per sample an integrator adds the distance that is left, divided by the delay (450 samples at most). So it stops at a
    // distance of half a unit in the last place times the delay.
    CHECK(std::abs(y - 0.3) < 450 * 0x1p-53);
  }
}

TEST_CASE("behind a ramp every filter lags by its delay at 0 Hz") {
  const double speed = 0x1p-10;  // per sample: the ramp itself is exact
  for (const FilterSpec& spec : kLinear) {
    Filter<double> filter = make_filter<double>(spec, kForceRate);
    const long double delay = delay_samples(spec);
    const int settled = settling_samples(spec);
    double y = 0;
    for (int n = 0; n <= settled; ++n) y = filter.next(n * speed);
    // Positions up to 60 round by 2^-48, and such an error stays for as many samples as the delay.
    CHECK(std::abs((settled * speed - y) / speed - delay) < 1e-9L * (1 + delay));
  }
}

TEST_CASE("a moving average is the mean of its window from the first sample on, and half a window late") {
  for (int samples = 1; samples <= 40; ++samples) {
    Filter<double> filter = make_filter<double>(MovingAverageSpec{samples}, kForceRate);
    Filter<double> integers = make_filter<double>(MovingAverageSpec{samples}, kForceRate);
    for (int n = 0; n < 5 * samples; ++n) {
      const double y = filter.next(noise(n)), whole = integers.next(n * samples);
      long double sum = 0;
      for (int i = n - samples + 1; i <= n; ++i) sum += noise(std::max(i, 0));
      // A sum of 40 differences below 2 in size is off by 40 * 2^-53 of 80 at worst; the mean is that over 40.
      REQUIRE(std::abs(y - sum / samples) < 80 * 0x1p-53L);
      // Whole numbers add up exactly, and 1/n is right to half a unit in the last place.
      const double half_a_window_ago = (n - (samples - 1) / 2.0) * samples;
      if (n >= samples - 1) REQUIRE(std::abs(whole - half_a_window_ago) <= samples * samples * 0x1p-53);
    }
  }
}

TEST_CASE("a moving average is that of its window to the bit, however long it has run") {
  for (const int samples : {3, 8, 31}) {
    for (int earlier = 0; earlier < 2 * samples; ++earlier) {
      Filter<double> fresh = make_filter<double>(MovingAverageSpec{samples}, kForceRate), old = fresh;
      for (int n = 0; n < earlier; ++n) old.next(1e6 * noise(n));
      double a = 0, b = 0;
      for (int n = 0; n < samples; ++n) a = fresh.next(noise(-n)), b = old.next(noise(-n));
      REQUIRE(same_bits(a, b));
    }
  }
}

TEST_CASE("a moving average forgets a sample for good when it leaves the window") {
  Filter<double> filter = make_filter<double>(MovingAverageSpec{8}, kForceRate);
  for (int n = 0; n < 8; ++n) filter.next(n == 3 ? 1e200 : 1.0);
  double y = 0;
  for (int n = 0; n < 4; ++n) y = filter.next(1.0);
  CHECK(y == 1.0);
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    filter.next(bad);
    for (int n = 0; n < 8; ++n) y = filter.next(1.0);
    CHECK(y == 1.0);
  }
}

TEST_CASE("a butterworth filter follows the direct form of its difference equation, from rest at any value") {
  for (const double cutoff_Hz : {2.0, 30.0, 120.0, 400.0}) {
    const long double g = std::tan(kPi * cutoff_Hz / kRate_Hz), root = std::sqrt(2.0L);
    const long double a0 = 1 + root * g + g * g, a1 = 2 * (g * g - 1) / a0, a2 = (1 - root * g + g * g) / a0;
    const long double b0 = g * g / a0;
    Filter<double> filter = make_filter<double>(ButterworthSpec{cutoff_Hz}, kForceRate);
    const long double first = noise(0);
    long double x1 = first, x2 = first, y1 = first, y2 = first, worst = 0;
    for (int n = 0; n < 20'000; ++n) {
      const long double x = noise(n), expected = b0 * (x + 2 * x1 + x2) - a1 * y1 - a2 * y2;
      x2 = x1, x1 = x, y2 = y1, y1 = expected;
      worst = std::max(worst, std::abs(filter.next(noise(n)) - expected));
    }
    // As above: a few 2^-53 per sample, kept for the delay of 113 samples at most.
    CHECK(worst < 1e-13L);
  }
}

TEST_CASE("a slow butterworth filter answers a step as its analog model: 1 - exp(-u) (cos u + sin u)") {
  const double cutoff_Hz = 0.1;  // g = 3e-4: sampled and analog filter differ by that and by a sample of delay
  Filter<double> filter = make_filter<double>(ButterworthSpec{cutoff_Hz}, kForceRate);
  filter.next(0);
  double largest = 0, worst = 0;
  for (int n = 0; n < 30'000; ++n) {
    const double y = filter.next(1), u = 2 * 3.14159265358979 * cutoff_Hz * (n + 0.5) / 1000 / std::sqrt(2.0);
    worst = std::max(worst, std::abs(y - (1 - std::exp(-u) * (std::cos(u) + std::sin(u)))));
    largest = std::max(largest, y);
  }
  CHECK(worst < 5e-4);
  CHECK(largest == Approx(1 + std::exp(-3.14159265358979)).margin(5e-4));  // overshoots by 4.3 %
}

TEST_CASE("at steady speed a one euro filter is the first-order filter of the cutoff that its quadratic gives") {
  for (const double min_cutoff_Hz : {0.1, 1.0, 10.0}) {
    for (const double beta : {0.0, 0.007, 1.0, 100.0}) {
      for (const double speed : {1e-3, 0.1, 2.0}) {
        const OneEuroSpec spec{min_cutoff_Hz, beta, 1};
        const long double b = min_cutoff_Hz + beta * static_cast<long double>(speed);
        const long double cutoff_Hz = (b + std::sqrt(b * b + 4 * beta * speed * kRate_Hz / (2 * kPi))) / 2;
        Filter<double> filter = make_filter<double>(spec, kForceRate), negative = make_filter<double>(spec, kForceRate);
        double lag = 0, mirrored = 0;
        for (int n = 0; n < 60'000; ++n) {
          const double x = speed * n / 1000;
          lag = x - filter.next(x);
          mirrored = -x - negative.next(-x);
        }
        // In 60 s even 0.1 Hz and the derivative's 1 Hz (time constants 1.6 s and 0.16 s) settle to exp(-37). Positions of
        // up to 120 round by 7e-15, and a few hundred of these add up. Where positions are that large, the lag is at least
        // 1e-3.
        CHECK(lag == Approx(static_cast<double>(speed / (2 * kPi * cutoff_Hz))).epsilon(1e-8));
        CHECK(same_bits(mirrored, -lag));
      }
    }
  }
}

TEST_CASE("a one euro filter follows the published algorithm in long double") {
  const OneEuroSpec spec{1.5, 0.4, 3};
  const auto alpha = [](long double cutoff_Hz) { return 1 / (1 + kRate_Hz / (2 * kPi * cutoff_Hz)); };
  Filter<double> filter = make_filter<double>(spec, kForceRate);
  long double filtered = 0, derivative = 0;
  for (int n = 0; n < 5000; ++n) {
    const double x = 0.01 * noise(n) + (n > 2500 ? 1 : 0);
    if (n == 0) filtered = x;
    const long double dx = n == 0 ? 0 : (x - filtered) * kRate_Hz;
    derivative = alpha(spec.derivative_cutoff_Hz) * dx + (1 - alpha(spec.derivative_cutoff_Hz)) * derivative;
    const long double a = alpha(spec.min_cutoff_Hz + spec.beta * std::abs(derivative));
    filtered = a * x + (1 - a) * filtered;
    // The filter contracts: roundings of 1e-16 fade within the delay of 100 samples.
    REQUIRE(std::abs(filter.next(x) - filtered) < 1e-13L);
  }
}

TEST_CASE("a one euro filter of a vector takes one cutoff from the length of its speed, whatever the axes") {
  const OneEuroSpec spec{1, 2, 5};
  Filter<double> along = make_filter<double>(spec, kForceRate);
  Filter<glm::dvec3> vector = make_filter<glm::dvec3>(spec, kForceRate);
  Filter<std::array<double, 3>> array = make_filter<std::array<double, 3>>(spec, kForceRate);
  Filter<std::array<glm::dvec3, 2>> tools = make_filter<std::array<glm::dvec3, 2>>(spec, kForceRate);
  Filter<std::array<double, 4>> pair = make_filter<std::array<double, 4>>(spec, kForceRate);
  for (int n = 0; n < 3000; ++n) {
    const double x = noise(n / 20), y = along.next(x);
    const glm::dvec3 got = vector.next(glm::dvec3(2, -3, 6) / 7.0 * x);
    const std::array<double, 3> same = array.next({2 / 7.0 * x, -3 / 7.0 * x, 6 / 7.0 * x});
    // (2, 3, 6) / 7 has length 1 to a few 2^-53, and the filter contracts.
    for (int axis = 0; axis < 3; ++axis) {
      REQUIRE(std::abs(got[axis] - y * glm::dvec3(2, -3, 6)[axis] / 7.0) < 1e-13);
      REQUIRE(same_bits(got[axis], same[static_cast<std::size_t>(axis)]));
    }
    const auto two = tools.next({glm::dvec3(x, 0, 0), glm::dvec3(0, noise(n), 0)});
    const auto flat = pair.next({x, 0, noise(n), 0});
    REQUIRE(std::abs(two[0].x - flat[0]) < 1e-13);
    REQUIRE(std::abs(two[1].y - flat[2]) < 1e-13);
  }
}

TEST_CASE("linear filters treat the components of every value type alike, bit for bit") {
  for (const FilterSpec& spec : kLinear) {
    Filter<double> one = make_filter<double>(spec, kForceRate), two = one;
    Filter<std::array<double, 2>> array = make_filter<std::array<double, 2>>(spec, kForceRate);
    Filter<glm::dvec3> vector = make_filter<glm::dvec3>(spec, kForceRate);
    auto nested = make_filter<std::array<std::array<double, 1>, 2>>(spec, kForceRate);
    for (int n = 0; n < 400; ++n) {
      const double x = noise(n), y = 1e3 * noise(-n - 2), a = one.next(x), b = two.next(y);
      const std::array<double, 2> both = array.next({x, y});
      const glm::dvec3 three = vector.next({x, y, x});
      const auto deep = nested.next({{{x}, {y}}});
      REQUIRE((same_bits(both[0], a) && same_bits(both[1], b)));
      REQUIRE((same_bits(three.x, a) && same_bits(three.y, b) && same_bits(three.z, a)));
      REQUIRE((same_bits(deep[0][0], a) && same_bits(deep[1][0], b)));
    }
  }
}

TEST_CASE("the domain of every parameter ends where the header says") {
  const double inf = std::numeric_limits<double>::infinity(), nan = std::nan("");
  for (const int samples : {1, 2, kMaxAveragedSamples}) CHECK(in_domain(MovingAverageSpec{samples}, kForceRate));
  for (const int samples : {0, -1, kMaxAveragedSamples + 1}) CHECK_FALSE(in_domain(MovingAverageSpec{samples}, kForceRate));
  for (const double f : {1e-9, 499.999}) CHECK(in_domain(ButterworthSpec{f}, kForceRate));
  for (const double f : {0.0, -1.0, 500.0, inf, nan}) CHECK_FALSE(in_domain(ButterworthSpec{f}, kForceRate));
  CHECK(in_domain(ButterworthSpec{std::nextafter(50.0 / 3, 0)}, {100, 3}));
  CHECK_FALSE(in_domain(ButterworthSpec{17}, {100, 3}));
  for (const double f : {1e-9, 499.0, 1e300}) {
    CHECK(in_domain(OneEuroSpec{f, 0, 1}, kForceRate));
    CHECK(in_domain(OneEuroSpec{1, f, 1}, kForceRate));
    CHECK(in_domain(OneEuroSpec{1, 0, f}, kForceRate));
  }
  for (const double f : {-1.0, inf, nan}) {
    CHECK_FALSE(in_domain(OneEuroSpec{f, 0, 1}, kForceRate));
    CHECK_FALSE(in_domain(OneEuroSpec{1, f, 1}, kForceRate));
    CHECK_FALSE(in_domain(OneEuroSpec{1, 0, f}, kForceRate));
  }
  CHECK_FALSE(in_domain(OneEuroSpec{0, 0, 1}, kForceRate));
  CHECK_FALSE(in_domain(OneEuroSpec{1, 0, 0}, kForceRate));
  CHECK_FALSE(in_domain(MovingAverageSpec{1}, {0, 1}));
}

TEST_CASE("at the edges of the domain the filters stay finite: what they let through is bounded by what came in") {
  for (const FilterSpec& spec : std::vector<FilterSpec>{ButterworthSpec{1e-12}, ButterworthSpec{std::nextafter(500.0, 0)},
                                                        OneEuroSpec{1e-12, 0, 1e-12}, OneEuroSpec{1e300, 0, 1e300},
                                                        OneEuroSpec{1, 1e300, 1}, MovingAverageSpec{kMaxAveragedSamples}}) {
    Filter<double> filter = make_filter<double>(spec, kForceRate);
    for (int n = 0; n < 300; ++n) REQUIRE(std::abs(filter.next(noise(n))) < 2);  // a butterworth overshoots by 4.3 %
  }
}
