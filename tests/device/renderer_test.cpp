
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "catch.h"
#include "evenstep/device/renderer.h"
#include "evenstep/device/stiffness_laws.h"
#include "units.h"
#include "vectors.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

constexpr Duration kFresh{-kMs};  // not past the newest record
constexpr double kPi = 3.14159265358979323846;

/// Three springs along any directions, so the matrix is positive definite.
Symmetric random_stiffness(Random& random, double size) {
  Symmetric k;
  for (int spring = 0; spring < 3; ++spring) {
    const glm::dvec3 n = random.direction();
    const double s = random.uniform(0, size);
    k = {k.xx + s * n.x * n.x, k.yy + s * n.y * n.y, k.zz + s * n.z * n.z,
         k.xy + s * n.x * n.y, k.xz + s * n.x * n.z, k.yz + s * n.y * n.z};
  }
  return k;
}

Symmetric along(const glm::dvec3& n, double stiffness) {
  return {stiffness * n.x * n.x, stiffness * n.y * n.y, stiffness * n.z * n.z,
          stiffness * n.x * n.y, stiffness * n.x * n.z, stiffness * n.y * n.z};
}

/// The record that a step against the wall n . x = `at` leaves, with the tool at `tool_m`.
ContactRecord wall_record(const glm::dvec3& n, double at, double stiffness, const glm::dvec3& tool_m) {
  const double gap_m = dot(n, tool_m) - at;
  return {n * (stiffness * std::max(0.0, -gap_m)), tool_m, along(n, stiffness), n, gap_m, true, {}};
}

/// The record that a step on the spring f = -K x leaves.
ContactRecord spring_record(const Symmetric& k, const glm::dvec3& tool_m) {
  return {k * -tool_m, tool_m, k, {}, 0, false, {}};
}

}  // namespace

TEST_CASE("local: on a spring the force is that of no delay, wherever the tool was, 100,000 random cases") {
  Random random(1);
  const LocalRenderer local(1);
  for (int i = 0; i < 100'000; ++i) {
    const double size = std::pow(10, random.uniform(0, 4));
    const Symmetric k = random_stiffness(random, size);
    const AffineContact a = affine_contact(spring_record(k, random.vector(0.1)), true);
    const AffineContact b = affine_contact(spring_record(k, random.vector(0.1)), true);
    const glm::dvec3 hand = random.vector(0.1);
    // Some thirty roundings of values up to 3 size * 0.3 m.
    REQUIRE(length(local.force_N(lerp(a, b, random.uniform(0, 1)), kFresh, hand) - k * -hand) <= 40 * kEpsilon * size);
  }
}

TEST_CASE("local: a wall is felt where it is, before, in and after the touch, at any mix of two records") {
  Random random(2);
  const LocalRenderer local(1);
  int pushed = 0, touched_between = 0;
  for (int i = 0; i < 100'000; ++i) {
    const glm::dvec3 n = random.direction();
    const double at = random.uniform(-0.1, 0.1), size = std::pow(10, random.uniform(0, 4));
    const ContactRecord first = wall_record(n, at, size, n * at + random.vector(0.01));
    const ContactRecord second = wall_record(n, at, size, n * at + random.vector(0.01));
    const glm::dvec3 hand = n * at + random.vector(0.01);
    const AffineContact mix = lerp(affine_contact(first, true), affine_contact(second, true), random.uniform(0, 1));
    const glm::dvec3 force = local.force_N(mix, kFresh, hand);
    REQUIRE(length(force - wall_record(n, at, size, hand).force_N) <= 100 * kEpsilon * size);
    pushed += length(force) > 0;
    touched_between += first.gap_m > 0 && second.gap_m < 0;
  }
  CHECK(pushed > 40'000);
  CHECK(touched_between > 20'000);
}

TEST_CASE("local without gaps feels nothing until a record has touched, and then the same") {
  const glm::dvec3 n{0, 0, 1};
  const LocalRenderer local(1);
  const glm::dvec3 inside{0, 0, -3e-3};
  const AffineContact apart = affine_contact(wall_record(n, 0, 300, {0, 0, 1e-3}), false);
  const AffineContact touched = affine_contact(wall_record(n, 0, 300, {0, 0, -1e-3}), false);
  CHECK(local.force_N(apart, kFresh, inside) == glm::dvec3(0));
  CHECK(local.force_N(touched, kFresh, inside).z == Approx(0.9).epsilon(1e-14));
  // This is the jump that the gap prevents: without a gap, the whole force comes within the slot in which the touch is
  // reported.
  CHECK(local.force_N(lerp(apart, touched, 0.5), kFresh, inside).z == Approx(0.5 * 0.3 + 0.5 * 300 * 3e-3).epsilon(1e-12));
}

TEST_CASE("local: a contact that only pushes never pulls, and its push is that of the law, 100,000 random cases") {
  Random random(3);
  int played = 0;
  for (int i = 0; i < 100'000; ++i) {
    const double alpha = random.uniform(0.1, 4);
    ContactRecord record{random.vector(5),
                         random.vector(0.01),
                         random_stiffness(random, 2000),
                         random.direction(),
                         random.uniform(-1e-3, 1e-3),
                         random.uniform(0, 1) < 0.8,
                         {}};
    const AffineContact contact = affine_contact(record, random.uniform(0, 1) < 0.5);
    const glm::dvec3 hand = random.vector(0.01);
    const glm::dvec3 law = contact.force_N + (contact.stiffness_N_per_m * (contact.tool_m - hand)) * alpha;
    const glm::dvec3 force = LocalRenderer(alpha).force_N(contact, kFresh, hand);
    if (record.unilateral && dot(record.normal, law) < 0) {
      REQUIRE(force == glm::dvec3(0));
    } else {
      REQUIRE(force == law);
      ++played;
    }
  }
  CHECK((played > 30'000 && played < 90'000));
}

TEST_CASE("along the normal alone: the stiffness to the side is 0, that along the normal is kept, 20,000 random contacts") {
  Random random(31);
  for (int i = 0; i < 20'000; ++i) {
    ContactRecord record;
    record.normal = random.direction();
    record.stiffness_N_per_m = random_stiffness(random, 1000);
    record.force_N = record.normal * random.uniform(0, 5);
    record.gap_m = random.uniform(-1e-3, 1e-3);
    record.unilateral = true;
    const glm::dvec3& n = record.normal;
    const ContactRecord part = with_part(record, StiffnessPart::normal);
    const double along_N_per_m = dot(n, record.stiffness_N_per_m * n);
    const double rounding = 64 * kEpsilon * (1 + along_N_per_m);
    // A way to the side meets no stiffness and gives no force along the normal. A way along the normal meets the same
    // stiffness as before.
    const glm::dvec3 way = random.vector(1);
    const glm::dvec3 aside = way - n * dot(n, way);
    REQUIRE(length(part.stiffness_N_per_m * aside) <= rounding);
    REQUIRE(length(part.stiffness_N_per_m * n - n * along_N_per_m) <= rounding);
    // The whole force is played, and the rest of the record is the same.
    REQUIRE(part.force_N == record.force_N);
    REQUIRE(part.gap_m == record.gap_m);
    // In the law that a tick plays, the force does not change at all with a way to the side.
    const LocalRenderer local(1);
    record.gap_m = -1e-3;
    record.force_N = n * (along_N_per_m * 1e-3);
    const AffineContact law = affine_contact(with_part(record, StiffnessPart::normal), true);
    const glm::dvec3 off = local.force_N(law, kFresh, aside * 1e-3) - record.force_N;
    REQUIRE(length(off) <= 1e-3 * rounding + 64 * kEpsilon * length(record.force_N));
    const glm::dvec3 in = local.force_N(law, kFresh, n * -1e-3) - record.force_N;
    REQUIRE(length(in - n * (along_N_per_m * 1e-3)) <= 1e-3 * rounding + 64 * kEpsilon * length(record.force_N));
  }
}

TEST_CASE("along the normal alone is for a contact that only pushes: one that is held keeps all of its stiffness") {
  Random random(32);
  ContactRecord held;
  held.stiffness_N_per_m = random_stiffness(random, 500);
  held.normal = random.direction();
  const Symmetric& all = held.stiffness_N_per_m;
  const Symmetric kept = with_part(held, StiffnessPart::normal).stiffness_N_per_m;
  CHECK(std::bit_cast<std::array<std::uint64_t, 6>>(kept) == std::bit_cast<std::array<std::uint64_t, 6>>(all));
  const Symmetric axes = with_part(held, StiffnessPart::axes).stiffness_N_per_m;
  CHECK(axes.xx == all.xx);
  CHECK(axes.xy == 0);
  CHECK(all.xy != 0);
}

TEST_CASE("records mix with one weight: their ends bit for bit, their stiffness positive semidefinite in between") {
  Random random(4);
  for (int i = 0; i < 20'000; ++i) {
    AffineContact a{random.vector(9), random.vector(1), random_stiffness(random, 1000), random.direction(), RealTime{i * 7}};
    AffineContact b{random.vector(9), random.vector(1), random_stiffness(random, 1000), {}, RealTime{i * 7 + 2'222'222}};
    REQUIRE(lerp(a, b, 0).force_N == a.force_N);
    REQUIRE(lerp(a, b, 0).outward == a.outward);
    REQUIRE(lerp(a, b, 0).read_at == a.read_at);
    REQUIRE(lerp(a, b, 1).read_at == b.read_at);
    const double w = random.uniform(0, 1);
    const AffineContact mix = lerp(a, b, w);
    const glm::dvec3 v = random.direction();
    REQUIRE(dot(v, mix.stiffness_N_per_m * v) >= -1e-12);
    REQUIRE(length(mix.tool_m - (a.tool_m * (1 - w) + b.tool_m * w)) <= 1e-15 * 8);
    REQUIRE(std::abs(static_cast<double>((mix.read_at - a.read_at).ns) - 2'222'222 * w) <= 1);
  }
}

TEST_CASE("a record is held for 100 ms, then force and stiffness fade together to nothing in 50 ms") {
  const LocalRenderer local(1.1);
  const AffineContact contact{{1, 2, 3}, {0, 0, 0}, {300, 300, 300, 0, 0, 0}, {}, {}};
  const auto stiffness = [&](Duration age) {
    return (local.force_N(contact, age, {0, 0, 0}) - local.force_N(contact, age, {1e-3, 0, 0})).x / 1e-3;
  };
  for (std::int64_t us = -5000; us <= 200'000; us += 50) {
    const Duration age{us * 1000};
    const double expected = us <= 100'000 ? 1 : us >= 150'000 ? 0 : 1 - static_cast<double>(us - 100'000) / 50'000;
    REQUIRE(fade(age) == Approx(expected).margin(1e-15));
    REQUIRE(length(local.force_N(contact, age, {0, 0, 0}) - glm::dvec3(1, 2, 3) * expected) <= 1e-14);
    REQUIRE(stiffness(age) == Approx(330 * expected).margin(1e-9));
  }
}

TEST_CASE("the damping that a delayed spring renders follows b_eq within the next order of the delay") {
  // x = A cos(w t). In every tick the spring answers for where the hand was a time L ago, and its force is corrected by
  // alpha K (x_c - x). The work of one turn, -sum F dx, is pi A^2 w b_eq.
  const double amplitude = 5e-3, stiffness = 300, h = 1e-3;
  for (const double frequency : {1.0, 3.0, 5.0}) {
    for (const double latency : {0.005, 0.015064, 0.0233}) {
      for (const double device : {0.0, 1e-3, 2e-3}) {
        for (const double alpha : {0.1, 0.5, 0.9, 1.0, 1.1, 1.5}) {
          const double w = 2 * kPi * frequency;
          const auto x = [&](double t) { return amplitude * std::cos(w * t); };
          const LocalRenderer local(alpha);
          double work = 0;
          const int ticks = static_cast<int>(1000 / frequency);
          const double period = static_cast<double>(ticks) * h * frequency;  // the share of a turn: 1 or 0.999
          for (int k = 0; k < ticks; ++k) {
            const double t = k * h;
            ContactRecord record = spring_record({stiffness, stiffness, stiffness, 0, 0, 0}, {x(t - latency), 0, 0});
            const glm::dvec3 force = local.force_N(affine_contact(record, true), kFresh, {x(t), 0, 0});
            work -= force.x * (x(t + device + h) - x(t + device));
          }
          const LoopDelays loop{latency + h / 2, h, device};
          const double measured = work / (kPi * amplitude * amplitude * w * period);
          const double scheduled = loop.scheduled_s + device, direct = h / 2 + device;
          const double next_order =
              stiffness * w * w / 6 *
              (std::abs(1 - alpha) * std::pow(scheduled, 3) + alpha * std::pow(direct, 3) + h * h * scheduled);
          // An incomplete turn leaves up to 0.1 % of K A^2 / 2 behind.
          const double incomplete = period == 1 ? 0 : 1e-3 * stiffness / w;
          INFO(frequency << " Hz, L " << latency << ", d " << device << ", alpha " << alpha);
          CHECK(std::abs(measured - rendered_damping(stiffness, alpha, loop)) <= next_order + incomplete + 1e-9);
        }
      }
    }
  }
}

TEST_CASE("local plays a ramp and its dead stop exactly, where the scheduled force runs on for the latency") {
  const double stiffness = 300, speed = 0.1, stop = 0.2, latency = 0.015064;
  const auto x = [&](double t) { return speed * std::min(std::max(t, 0.0), stop); };
  double local_error = 0, force_error = 0;
  const LocalRenderer local(1);
  for (int k = 0; k < 400; ++k) {
    const double t = k * 1e-3;
    const ContactRecord record = spring_record({stiffness, stiffness, stiffness, 0, 0, 0}, {x(t - latency), 0, 0});
    local_error = std::max(local_error,
                           std::abs(local.force_N(affine_contact(record, true), kFresh, {x(t), 0, 0}).x + stiffness * x(t)));
    force_error = std::max(force_error, std::abs(record.force_N.x + stiffness * x(t)));
  }
  CHECK(local_error <= 16 * kEpsilon * stiffness * speed * stop);
  CHECK(force_error == Approx(stiffness * speed * latency).epsilon(1e-9));
}

namespace {

/// A mode of static stiffness K and frequency f. Its contact spring and its ground spring both have 2 K.
SpringMode mode_of(double stiffness, double frequency, double ratio) {
  const double w = 2 * kPi * frequency, mass = 4 * stiffness / (w * w);
  return {2 * stiffness, 2 * stiffness, mass, 2 * ratio * mass * w};
}

/// G for a hand that starts at rest, by Runge-Kutta of order 4 with steps of 5 us, in long double, every `stride` steps.
std::vector<double> reference(const SpringMode& mode, const std::function<double(double)>& x, double until) {
  const double h = 5e-6;
  long double q = x(0) * mode.contact_N_per_m / (mode.contact_N_per_m + mode.ground_N_per_m), v = 0;
  std::vector<double> forces;
  const auto acceleration = [&](double t, long double q_now, long double v_now) {
    return (mode.contact_N_per_m * (x(t) - q_now) - mode.ground_N_per_m * q_now - mode.damping_N_s_per_m * v_now) /
           mode.mass_kg;
  };
  for (std::int64_t n = 0; static_cast<double>(n) * h <= until; ++n) {
    const double t = static_cast<double>(n) * h;
    if (n % 200 == 0) forces.push_back(static_cast<double>(-mode.contact_N_per_m * (x(t) - q)));
    const long double v1 = v, a1 = acceleration(t, q, v1);
    const long double v2 = v + h / 2 * a1, a2 = acceleration(t + h / 2, q + h / 2 * v1, v2);
    const long double v3 = v + h / 2 * a2, a3 = acceleration(t + h / 2, q + h / 2 * v2, v3);
    const long double v4 = v + h * a3, a4 = acceleration(t + h, q + h * v3, v4);
    q += h / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  return forces;
}

}  // namespace

TEST_CASE("smith: with the tissue's own mode the force is that of no delay") {
  const auto x = [](double t) {
    const double turn = std::sin(2 * kPi * 2 * t);
    return 0.005 * turn * turn;
  };
  for (const double frequency : {3.0, 7.0, 30.0}) {
    for (const int late : {5, 15, 24}) {  // ms
      const SpringMode mode = mode_of(300, frequency, 0.1);
      const std::vector<double> truth = reference(mode, x, 1.0);
      SmithRenderer smith(mode, Duration{60 * kMs}, Duration{kMs});
      double error = 0, uncorrected = 0;
      for (int k = 0; k < 1000; ++k) {
        const int then = std::max(k - late, 0);
        const AffineContact record{{truth[static_cast<std::size_t>(then)], 0, 0}, {}, {}, {}, RealTime{then * kMs}};
        const double force = smith.force_N(record, kFresh, RealTime{k * kMs}, {x(k * 1e-3), 0, 0}).x;
        error = std::max(error, std::abs(force - truth[static_cast<std::size_t>(k)]));
        uncorrected = std::max(uncorrected, std::abs(record.force_N.x - truth[static_cast<std::size_t>(k)]));
      }
      INFO(frequency << " Hz, " << late << " ms");
      // The error is one of 3 N. From tick to tick the hand is taken to move in a straight line, which is off by up to
      // h^2 x'' / 8 = 0.1 um. The contact spring makes 60 uN of that, both now and at the record's time. The damping is half
      // a step early.
      CHECK(error <= 2e-4);
      CHECK(uncorrected >= 0.09);  // 300 N/m, 63 mm/s and 5 ms at least
    }
  }
}

TEST_CASE("smith: a hand at rest is given the scheduled force, and a pause begins anew") {
  SmithRenderer smith(mode_of(300, 7, 0.1), Duration{50 * kMs}, Duration{kMs});
  const glm::dvec3 hand{0.01, -0.02, 0.03};
  const AffineContact record{{1, 2, 3}, {}, {}, {}, RealTime{0}};
  for (int k = 0; k < 300; ++k) {
    // The hand is at rest from the start, so only 600 N/m times 30 mm are rounded.
    REQUIRE(length(smith.force_N(record, kFresh, RealTime{k * kMs}, hand) - glm::dvec3(1, 2, 3)) <= 1e-11);
  }
  // 101 ms later the mode is at rest at the new place, whatever happened before.
  const AffineContact later{{1, 2, 3}, {}, {}, {}, RealTime{400 * kMs}};
  REQUIRE(length(smith.force_N(later, kFresh, RealTime{401 * kMs}, {0, 0, 0}) - glm::dvec3(1, 2, 3)) <= 1e-11);
}

TEST_CASE("smith: what is read between ticks is on the line between them, and older than its memory is the oldest") {
  const SpringMode mode = mode_of(300, 7, 0.1);
  const auto forces_at = [&](std::int64_t read_us) {
    SmithRenderer smith(mode, Duration{10 * kMs}, Duration{kMs});
    glm::dvec3 force{0};
    for (int k = 0; k <= 100; ++k)
      force = smith.force_N({{}, {}, {}, {}, RealTime{read_us * 1000}}, kFresh, RealTime{k * kMs}, {k * 1e-4, 0, 0});
    return force.x;
  };
  for (std::int64_t tick = 89; tick < 100; ++tick) {  // 89 ms is the oldest of the 12 outputs that are kept
    const double from = forces_at(tick * 1000), to = forces_at(tick * 1000 + 1000);
    CHECK(from != to);
    CHECK(forces_at(tick * 1000 + 250) == Approx(from + (to - from) / 4).epsilon(1e-12));
  }
  CHECK(forces_at(100'000) == 0);
  CHECK(forces_at(89'000) == forces_at(88'000));
  CHECK(forces_at(89'000) == forces_at(0));
}

TEST_CASE("smith never pulls on a contact that only pushes, and fades like every record") {
  SmithRenderer smith(mode_of(300, 7, 0.1), Duration{50 * kMs}, Duration{kMs});
  AffineContact record{{0, 0, 0.1}, {}, {}, {0, 0, 1}, RealTime{0}};
  bool pulled = false, pushed = false;
  for (int k = 0; k < 300; ++k) {
    const double x = 1e-3 * std::sin(2 * kPi * 5 * k * 1e-3);
    record.read_at = RealTime{std::max(0, k - 15) * kMs};
    const glm::dvec3 force = smith.force_N(record, kFresh, RealTime{k * kMs}, {0, 0, x});
    pulled |= force.z < 0;
    pushed |= force.z > 0.1;
  }
  CHECK_FALSE(pulled);
  CHECK(pushed);
  CHECK(smith.force_N(record, kFadeAfter + kFadeFor, RealTime{300 * kMs}, {0, 0, -1e-3}) == glm::dvec3(0));
}
