#include "evenstep/time/time.h"

#include <vector>

#include "catch.h"
#include "evenstep/time/digest.h"

using namespace evenstep;

namespace {

struct NamedRate {
  const char* description;
  Rate rate;
};

const std::vector<NamedRate> kRates = {
    {"30 Hz: the paper's segments", {30, 1}},
    {"450 Hz: its steps", {450, 1}},
    {"1 kHz: its device", {1000, 1}},
    {"1 Hz", {1, 1}},
    {"once in three seconds", {1, 3}},
    {"a little under 1 Hz", {1000, 1001}},
    {"NTSC", {30000, 1001}},
    {"1 GHz: one tick a nanosecond", {1'000'000'000, 1}},
    {"more than one tick a nanosecond", {3'000'000'000, 1}},
    {"two large primes", {999'999'937, 1'000'003}},
    {"8 ms + 16 steps of 1.5 ms", {1'000'000'000, 32'000'000}},
};

/// Every k with |k| <= 2000, and pseudo-random ones of all magnitudes up to 10^12 and both signs.
std::vector<std::int64_t> tick_numbers() {
  std::vector<std::int64_t> numbers;
  for (std::int64_t k = -2000; k <= 2000; ++k) numbers.push_back(k);
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    const std::int64_t magnitude = static_cast<std::int64_t>((spread(i + 1) >> (i % 40)) % 1'000'000'000'000);
    numbers.push_back(i % 2 ? magnitude : -magnitude);
  }
  numbers.push_back(1'000'000'000'000);
  numbers.push_back(-1'000'000'000'000);
  return numbers;
}

/// For c > 0, q = floor(a / c) is the only q with q c <= a < (q + 1) c. This needs no division, so no rounding rule can be
/// wrong.
bool is_floor(std::int64_t q, __int128 a, __int128 c) { return q * c <= a && a < (q + static_cast<__int128>(1)) * c; }

/// first_tick_at_or_after is asked for instants within +-292 years only.
bool in_range(Rate rate, std::int64_t k) {
  const __int128 ns = static_cast<__int128>(k) * rate.den * 1'000'000'000 / rate.num;
  return ns < INT64_MAX / 4 && ns > INT64_MIN / 4;
}

}  // namespace

TEST_CASE("instant_ns is the floor of the exact rational, for either sign of k") {
  for (const auto& [description, rate] : kRates) {
    INFO(description);
    std::int64_t wrong = 0;
    for (const std::int64_t k : tick_numbers()) {
      if (!in_range(rate, k)) continue;
      wrong += !is_floor(instant_ns(rate, k), static_cast<__int128>(k) * rate.den * 1'000'000'000, rate.num);
    }
    CHECK(wrong == 0);
  }
}

TEST_CASE("floor_mul_div is the floor of the exact rational, for either sign") {
  std::int64_t wrong = 0;
  for (std::uint64_t i = 0; i < 100'000; ++i) {
    const auto a = static_cast<std::int64_t>(spread(3 * i + 1)) >> (1 + i % 60);
    const auto c = static_cast<std::int64_t>(spread(3 * i + 3) >> (1 + i % 61)) + 1;
    // |b| <= c keeps the quotient within 64 bits, whatever a is.
    const auto b = static_cast<std::int64_t>(spread(3 * i + 2)) % c;
    wrong += !is_floor(floor_mul_div(a, b, c), static_cast<__int128>(a) * b, c);
  }
  CHECK(wrong == 0);
  CHECK(floor_mul_div(-1, 1, 3) == -1);
  CHECK(floor_mul_div(-3, 1, 3) == -1);
  CHECK(floor_mul_div(1, -1, 3) == -1);
}

TEST_CASE("whole seconds are hit exactly after up to 10^12 ticks: nothing drifts") {
  for (const auto& [description, rate] : kRates) {
    INFO(description);
    // Tick m * num is at m * den seconds, exactly.
    for (const std::int64_t ticks : {10'000'000LL, 1'000'000'000LL, 1'000'000'000'000LL}) {
      const std::int64_t m = ticks / rate.num;
      if (!in_range(rate, ticks)) continue;
      CHECK(instant_ns(rate, m * rate.num) == m * rate.den * 1'000'000'000);
      CHECK(instant_ns(rate, -m * rate.num) == -m * rate.den * 1'000'000'000);
    }
  }
}

TEST_CASE("neighbouring ticks are floor or ceil of the period apart") {
  for (const auto& [description, rate] : kRates) {
    INFO(description);
    const std::int64_t longest = period_ceil(rate).ns;
    CHECK(static_cast<__int128>(longest) * rate.num >= static_cast<__int128>(rate.den) * 1'000'000'000);
    CHECK(static_cast<__int128>(longest - 1) * rate.num < static_cast<__int128>(rate.den) * 1'000'000'000);
    std::int64_t wrong = 0, seen_longest = 0;
    for (std::int64_t k = -100'000; k < 100'000; ++k) {
      const std::int64_t distance = instant_ns(rate, k + 1) - instant_ns(rate, k);
      wrong += distance > longest || distance < longest - 1;
      seen_longest += distance == longest;
    }
    CHECK(wrong == 0);
    CHECK(seen_longest > 0);
  }
}

TEST_CASE("tick_time is instant_ns after the origin") {
  for (const auto& [description, rate] : kRates) {
    INFO(description);
    for (const std::int64_t origin : {-7'000'000'001LL, 0LL, 123'456'789LL}) {
      for (std::int64_t k = -50; k <= 50; ++k)
        CHECK(tick_time(rate, k, RealTime{origin}).ns == origin + instant_ns(rate, k));
    }
  }
}

TEST_CASE("first_tick_at_or_after is the inverse of tick_time") {
  for (const auto& [description, rate] : kRates) {
    INFO(description);
    std::int64_t not_first = 0, too_early = 0;
    for (const std::int64_t origin_ns : {-7'000'000'001LL, 0LL, 123'456'789LL}) {
      const RealTime origin{origin_ns};
      for (const std::int64_t k : tick_numbers()) {
        if (!in_range(rate, k)) continue;
        for (const std::int64_t beside : {-1, 0, 1}) {
          const RealTime at = tick_time(rate, k, origin) + Duration{beside};
          const std::int64_t first = first_tick_at_or_after(rate, at, origin);
          too_early += tick_time(rate, first, origin) < at;
          not_first += tick_time(rate, first - 1, origin) >= at;
        }
      }
    }
    CHECK(too_early == 0);
    CHECK(not_first == 0);
  }
}

TEST_CASE("the simulation time of step n is exact: the paper's step 450 n is n seconds") {
  const Rate step_rate{450, 1};
  std::int64_t wrong = 0;
  for (std::int64_t n = 0; n < 1'000'000; ++n)
    wrong += !is_floor(sim_time(step_rate, n).ns, static_cast<__int128>(n) * 1'000'000'000, 450);
  CHECK(wrong == 0);
  CHECK(sim_time(step_rate, 450LL * 1'000'000).ns == 1'000'000LL * 1'000'000'000);
  CHECK(sim_time(step_rate, 1).ns == 2'222'222);
}

TEST_CASE("arithmetic of instants and lengths is that of a line") {
  const RealTime t{1'000}, u{400};
  const Duration d{250};
  CHECK(t + d - d == t);
  CHECK(t - u == Duration{600});
  CHECK(u + (t - u) == t);
  CHECK(-d + d == Duration{});
  CHECK(d * 4 - d == Duration{750});
  CHECK((u < t && u <= t && t > u && t != u));
  Duration sum{1};
  sum += d;
  CHECK(sum == Duration{251});
}

TEST_CASE("seconds are for people: nanoseconds to the nearest double") {
  CHECK(seconds(Duration{1'500'000'000}) == Approx(1.5).epsilon(1e-15));
  CHECK(seconds(RealTime{-250'000'000}) == Approx(-0.25).epsilon(1e-15));
  CHECK(seconds(SimTime{2'222'222}) == Approx(0.002222222).epsilon(1e-15));
  CHECK(period_s({450, 1}) == Approx(1.0 / 450).epsilon(1e-15));
  CHECK(period_s({1, 3}) == 3.0);
}
