#include "evenstep/text/quantity.h"

#include <fmt/format.h>

#include <cmath>

#include "catch.h"
#include "evenstep/text/rational.h"
#include "evenstep/text/suggest.h"
#include "evenstep/text/units.h"

using namespace evenstep;
using Catch::Contains;

namespace {
std::int64_t ns(std::string_view text) {
  const Result<Duration> parsed = parse_duration(text);
  INFO(text << ": " << parsed.error_or(""));
  REQUIRE(parsed.ok());
  return parsed->ns;
}
}  // namespace

TEST_CASE("A duration is read to the exact nanosecond, without a double in between") {
  CHECK(ns("11.1 ms") == 11'100'000);
  CHECK(ns("11.1ms") == 11'100'000);
  CHECK(ns(" 1.4822 ms ") == 1'482'200);
  CHECK(ns("0.000000001 s") == 1);
  CHECK(ns("1e-6 ms") == 1);
  CHECK(ns("-2 us") == -2000);
  CHECK(ns("+2E3 ns") == 2000);
  CHECK(ns("0 h") == 0);
  CHECK(ns("1.5 min") == 90'000'000'000);
  CHECK(ns("277.5 h") == 999'000'000'000'000);
  CHECK(ns("1e6 s") == 1'000'000'000'000'000);
  // 123456789.123456789 ms has more digits than a double holds.
  CHECK(ns("123456789.123456 ms") == 123'456'789'123'456);
}

TEST_CASE("Every count of nanoseconds up to 10 us and around each power of ten reads back in each unit") {
  struct {
    const char* unit;
    int digits;
  } const rows[] = {{"ns", 0}, {"us", 3}, {"ms", 6}, {"s", 9}};
  const auto check = [&](std::int64_t value) {
    for (const auto& row : rows) {
      std::int64_t scale = 1;
      for (int i = 0; i < row.digits; ++i) scale *= 10;
      const std::string written = fmt::format("{}.{:0>{}} {}", value / scale, value % scale, row.digits, row.unit);
      if (ns(written) != value) FAIL(written);
    }
  };
  for (std::int64_t value = 0; value <= 10'000; ++value) check(value);
  for (std::int64_t power = 100'000; power <= 1'000'000'000'000'000; power *= 10) {
    for (std::int64_t value = power - 3; value <= std::min<std::int64_t>(power + 3, 1'000'000'000'000'000); ++value)
      check(value);
  }
}

TEST_CASE("A duration that cannot be meant is refused with the remedy") {
  struct {
    const char* text;
    const char* error;
  } const rows[] = {
      {"11.1", "'11.1' has no unit; write a time such as \"11.1 ms\""},
      {"11.1 msec", "'msec' is not a unit of time; did you mean 'ms'?"},
      {"11.1 MS", "did you mean 'ms'?"},
      {"1 µs", "did you mean 'us'?"},
      {"3 seconds", "did you mean 's'?"},
      {"3 parsec", "'parsec' is not a unit of time"},
      {"30 Hz", "'Hz' is a unit of rate, not of time"},
      {"30 hz", "'hz' is not a unit of time; 'Hz' is a unit of rate"},
      {"nan ms", "does not begin with a number"},
      {"inf s", "does not begin with a number"},
      {"", "does not begin with a number"},
      {". s", "does not begin with a number"},
      {"0.1 ns", "finer than 1 ns"},
      {"1e-300 s", "finer than 1 ns"},
      {"1000000.000000001 s", "longer than 1e6 s"},
      {"-1000001 s", "longer than 1e6 s"},
      {"1e300 s", "longer than 1e6 s"},
      {"99999999999999999999 s", "more than 18 digits"},
      {"1/3 s", "only a rate may be a fraction"},
      {"1 segment", "[timing] itself defines it"},
      {"1.2.3 ms", "'.3 ms' is not a unit of time"},
  };
  for (const auto& row : rows) {
    INFO(row.text);
    CHECK_THAT(parse_duration(row.text).error(), Contains(row.error));
  }
}

TEST_CASE("Nominal times are units of time once the timing table is known, with or without a plural s") {
  const NominalUnits nominal{{33'333'333}, {11'100'000}, {2'222'222}, {1'482'222}, true};
  CHECK(parse_duration("8 segments", nominal)->ns == 8 * 33'333'333LL);
  CHECK(parse_duration("1 segment", nominal)->ns == 33'333'333);
  CHECK(parse_duration("0.5 visualization", nominal)->ns == 5'550'000);
  CHECK(parse_duration("3 slots", nominal)->ns == 6'666'666);
  CHECK(parse_duration("2 step_run_times", nominal)->ns == 2'964'444);
  CHECK_FALSE(parse_duration("1e9 segments", nominal).ok());
  CHECK_FALSE(parse_duration("1 mss", nominal).ok());  // symbols take no plural
}

TEST_CASE("A rate is an exact fraction in lowest terms") {
  struct {
    const char* text;
    Rate rate;
  } const rows[] = {
      {"30 Hz", {30, 1}},      {"1/3 Hz", {1, 3}},     {"2.5 kHz", {2500, 1}},      {"33.3 Hz", {333, 10}},
      {"2/6 kHz", {1000, 3}},  {"1e3 Hz", {1000, 1}},  {"0.5Hz", {1, 2}},           {"500 mHz", {1, 2}},
      {"1000/3Hz", {1000, 3}}, {"1.5/4.5 Hz", {1, 3}}, {"1e-6 Hz", {1, 1'000'000}}, {"1e9 Hz", {1'000'000'000, 1}},
  };
  for (const auto& row : rows) {
    INFO(row.text);
    const Result<Rate> parsed = parse_rate(row.text);
    REQUIRE(parsed.error_or("") == "");
    CHECK(*parsed == row.rate);
  }
  for (const char* bad :
       {"0 Hz", "-1 Hz", "1/0 Hz", "30", "30 hz", "30 ms", "2e9 Hz", "1e-7 Hz", "1/ Hz", "nan Hz", "1e-30 Hz", "1e30 kHz"}) {
    INFO(bad);
    CHECK_FALSE(parse_rate(bad).ok());
  }
}

TEST_CASE("A unit with the wrong capital letters is named as it is written, but millions are not taken for thousandths") {
  using D = Dimension;
  struct {
    const char* text;
    D dimension;
    const char* error;
  } const rows[] = {
      {"200 n/m", D::stiffness, "'n/m' is not a unit of stiffness; did you mean 'N/m'?"},
      {"200 KN/M", D::stiffness, "'KN/M' is not a unit of stiffness; did you mean 'kN/m'?"},
      {"3 MM", D::length, "'MM' is not a unit of length; did you mean 'mm'?"},
      {"1 n s/m", D::damping, "'n s/m' is not a unit of damping; did you mean 'N s/m'?"},
      {"2 KG", D::mass, "'KG' is not a unit of mass; did you mean 'kg'?"},
      {"5 PPM", D::ratio, "'PPM' is not a unit of ratio; did you mean 'ppm'?"},
      {"1 MN", D::force, "'MN' is not a unit of force; there is no prefix for millions here, known: uN, mN, N, kN"},
  };
  for (const auto& row : rows) {
    INFO(row.text);
    CHECK(parse_si(row.text, row.dimension).error() == row.error);
  }
  CHECK(parse_rate("8 khz").error() == "'khz' is not a unit of rate; did you mean 'kHz'?");
  CHECK(parse_rate("30 hz").error() == "'hz' is not a unit of rate; did you mean 'Hz'?");
  CHECK(parse_rate("2 MHz").error() ==
        "'MHz' is not a unit of rate; there is no prefix for millions here, known: mHz, Hz, kHz");
  CHECK(parse_limit("2 MS").error() == "'MS' is not a unit; did you mean 'ms'?");
}

TEST_CASE("An SI value is the double nearest to what is written") {
  using D = Dimension;
  struct {
    const char* text;
    D dimension;
    double value;
  } const rows[] = {
      {"5 mm", D::length, 5e-3},       {"0.3 nm", D::length, 3e-10},     {"2 cm", D::length, 0.02},
      {"0.1 m/s", D::velocity, 0.1},   {"10 mm/s", D::velocity, 0.01},   {"3 uN", D::force, 3e-6},
      {"2 kN", D::force, 2000},        {"200 N/m", D::stiffness, 200},   {"0.3 N/mm", D::stiffness, 300},
      {"0.2 kN/m", D::stiffness, 200}, {"1e-3 N s/m", D::damping, 1e-3}, {"0.125 g", D::mass, 1.25e-4},
      {"7 ug", D::mass, 7e-9},         {"10 %", D::ratio, 0.1},          {"2 kHz", D::rate, 2000},
      {"3 h", D::time, 10800},         {"1000 kN/s", D::slew, 1e6},      {"0.1", D::none, 0.1},
  };
  for (const auto& row : rows) {
    INFO(row.text);
    const Result<double> parsed = parse_si(row.text, row.dimension);
    REQUIRE(parsed.error_or("") == "");
    CHECK(*parsed == row.value);
  }
  CHECK_FALSE(parse_si("0.1 m", D::none).ok());
  CHECK_FALSE(parse_si("0.1", D::length).ok());
  CHECK_FALSE(parse_si("1 segment", D::time).ok());
}

TEST_CASE("Each unit measures exactly one dimension") {
  using D = Dimension;
  for (const internal::Unit& unit : internal::units()) {
    for (const D dimension :
         {D::time, D::length, D::velocity, D::force, D::stiffness, D::damping, D::mass, D::rate, D::ratio, D::slew}) {
      INFO(unit.name);
      const bool plain = unit.kind == internal::UnitKind::plain;
      CHECK(parse_si(fmt::format("2 {}", unit.name), dimension).ok() == (plain && unit.dimension == dimension));
    }
  }
}

TEST_CASE("A limit keeps its number and unit, its factor is resolved later") {
  const Result<Limit> limit = parse_limit("1e-6 steps");
  REQUIRE(limit.ok());
  CHECK(limit->number == 1e-6);
  CHECK(limit->unit == "step");
  CHECK(parse_limit("12")->unit.empty());
  CHECK_THAT(parse_limit("1 stepp").error(), Contains("did you mean 'step'?"));
  CHECK_FALSE(parse_limit("lots").ok());

  const NominalUnits nominal{{33'333'333}, {11'100'000}, {2'222'222}, {1'482'222}, true};
  CHECK(*unit_factor("step", "m", 2.5e-4, nominal) == 2.5e-4);
  CHECK(*unit_factor("ms", "s", 0, nominal) == 1e-3);
  CHECK(*unit_factor("segment", "s", 0, nominal) == seconds(nominal.segment));
  CHECK(*unit_factor("%", "1", 0, nominal) == 0.01);
  CHECK(*unit_factor("", "count", 0, nominal) == 1);
  CHECK(*unit_factor("mN", "N", 0, nominal) == 1e-3);
  CHECK_THAT(unit_factor("step", "m", 0, nominal).error(), Contains("nominal speed"));
  CHECK_THAT(unit_factor("step", "s", 1, nominal).error(), Contains("a length or a force"));
  CHECK_THAT(unit_factor("", "s", 0, nominal).error(), Contains("needs a unit"));
  CHECK_THAT(unit_factor("ms", "m", 0, nominal).error(), Contains("'ms' is a unit of time, not of length"));
  CHECK_THAT(unit_factor("segment", "s", 0, {}).error(), Contains("not known"));
}

TEST_CASE("A limit equals the measured value that it names, in every unit of times and shares") {
  std::uint64_t state = 1;
  for (int i = 0; i < 100'000; ++i) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    const std::int64_t ns = 1'000'000 + static_cast<std::int64_t>((state >> 20) % 99'000'000);
    const double measured = seconds(Duration{ns});
    for (const auto& [unit, decimals] : {std::pair("us", 3), {"ms", 6}, {"s", 9}, {"ns", 0}}) {
      std::string digits = fmt::format("{:0>{}}", ns, decimals + 1);
      if (decimals > 0) digits.insert(digits.size() - static_cast<std::size_t>(decimals), ".");
      const Limit limit = *parse_limit(fmt::format("{} {}", digits, unit));
      CAPTURE(digits, unit);
      REQUIRE(*in_base(limit, "s", 0, {}) == measured);
      REQUIRE(*in_unit(measured, unit, "s", 0, {}) == limit.number);
    }
  }
  for (int share = 0; share <= 10'000; ++share) {  // 0.00 % to 100.00 %
    const double measured = share / 10'000.0;
    const Limit limit = *parse_limit(fmt::format("{}.{:02} %", share / 100, share % 100));
    CAPTURE(share);
    REQUIRE(*in_base(limit, "1", 0, {}) == measured);
    REQUIRE(*in_unit(measured, "%", "1", 0, {}) == limit.number);
  }
  const NominalUnits nominal{{33'333'333}, {11'100'000}, {2'222'222}, {1'482'222}, true};
  for (int count = 0; count <= 1000; ++count) {
    const double measured = seconds(Duration{count * nominal.segment.ns});
    REQUIRE(*in_base({static_cast<double>(count), "segment"}, "s", 0, nominal) == measured);
    REQUIRE(*in_unit(measured, "segment", "s", 0, nominal) == count);
  }
  CHECK(*in_base({0.7, "min"}, "s", 0, {}) == 42);
  CHECK(*in_unit(42, "min", "s", 0, {}) == 0.7);
  CHECK(std::isinf(*in_unit(INFINITY, "ms", "s", 0, {})));
  CHECK_THAT(in_base({1, "ms"}, "m", 0, {}).error(), Contains("'ms' is a unit of time, not of length"));
}

TEST_CASE("A rate of a long recording is within 1 / (den * 9e9) of the quotient and its denominator times 1e9 fits int64") {
  std::uint64_t state = 1;
  for (int i = 0; i < 20'000; ++i) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    const std::int64_t steps = 1 + static_cast<std::int64_t>(state >> 44);                                 // up to 1e6
    const std::int64_t length_ns = 1'000'000 + static_cast<std::int64_t>((state >> 14) & 0xff'ffff'ffff);  // up to 18 min
    const Rate rate = internal::reduced_rate(static_cast<__int128>(steps) * 1'000'000'000, length_ns);
    REQUIRE(rate.den <= internal::kMostRateDen);
    // |num/den - p/q| * q * 9e9 < 1, all in integers: |num q - p den| * 9e9 < den, by long division.
    __int128 difference =
        static_cast<__int128>(steps) * 1'000'000'000 * rate.den - static_cast<__int128>(rate.num) * length_ns;
    if (difference < 0) difference = -difference;
    REQUIRE(difference * internal::kMostRateDen <= length_ns);
  }
  CHECK(internal::reduced_rate(30 * 15, 1) == Rate{450, 1});
  CHECK(internal::reduced_rate(600, 45) == Rate{40, 3});
}

TEST_CASE("The nearest known word is found for a slip of the fingers and for an abbreviation") {
  using internal::nearest;
  const std::vector<std::string_view> known{"segment", "visualization", "steps", "step", "order"};
  CHECK(nearest("vis", known) == "visualization");
  CHECK(nearest("vsi", known) == "visualization");
  CHECK(nearest("segmnet", known) == "segment");
  CHECK(nearest("stpe", known) == "step");
  CHECK(nearest("zzz", known).empty());
  CHECK(nearest("", known).empty());
  CHECK(internal::edit_distance("kitten", "sitting") == 3);
  CHECK(internal::edit_distance("ab", "ba") == 1);
  CHECK(internal::edit_distance(std::string(5000, 'a'), "b") == 64);
}
