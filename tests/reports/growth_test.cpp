#include "evenstep/reports/growth.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "catch.h"

using namespace evenstep;

namespace {

using Numbers = std::vector<double>;
constexpr std::size_t kSamples = 30;  // samples in a bin
constexpr double kBegin = 0.02;       // the share of the run after which judging begins

/// Normal enough, and the same with every standard library.
struct GrowthNoise {
  std::mt19937_64 bits;
  double operator()() {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += static_cast<double>(bits() >> 11) * 0x1p-53;
    return sum;
  }
};

double time_of(std::size_t i, std::size_t count, double begin = kBegin) {
  return begin + (1 - begin) * (static_cast<double>(i) + 0.5) / static_cast<double>(count);
}
Numbers bin_times(std::size_t count, double begin = kBegin) {
  Numbers t;
  for (std::size_t i = 0; i < count; ++i) t.push_back(time_of(i, count, begin));
  return t;
}

/// GrowthNoise whose values are correlated over `length` bins, or not at all if `length` is 0.
class Related {
 public:
  Related(GrowthNoise& noise, double length) : noise_(noise), value_(noise()) {
    if (length > 0) keep_ = std::exp(-1 / (length * kSamples));
  }
  double next() { return value_ = keep_ * value_ + std::sqrt(1 - keep_ * keep_) * noise_(); }

 private:
  GrowthNoise& noise_;
  double keep_ = 0, value_;
};

/// RMS in each bin of error(t), which is called for one sample after another.
template <class Error>
Numbers rms_of(std::size_t bins, Error error) {
  Numbers rms(bins);
  for (std::size_t b = 0; b < bins; ++b) {
    for (std::size_t i = 0; i < kSamples; ++i) {
      const double e = error(time_of(b * kSamples + i, bins * kSamples));
      rms[b] += e * e / kSamples;
    }
    rms[b] = std::sqrt(rms[b]);
  }
  return rms;
}

Numbers walk(std::size_t bins, GrowthNoise& noise, double floor) {
  const auto samples = static_cast<double>(bins * kSamples);
  double place = std::sqrt(kBegin / (1 - kBegin) * samples) * noise();
  return rms_of(bins, [&](double) { return (place += noise()) / std::sqrt(samples) + floor * noise(); });
}

struct Kind {
  const char* name;
  const char* truth;
  Numbers (*series)(std::size_t bins, GrowthNoise& noise);
  double most_false = 0.05;
};
template <int kPerMille>
Numbers related(std::size_t bins, GrowthNoise& noise) {
  Related error(noise, kPerMille * 1e-3 * static_cast<double>(bins));
  return rms_of(bins, [&](double) { return error.next(); });
}
template <int kPerMille>
Numbers swelling(std::size_t bins, GrowthNoise& noise) {
  Related strength(noise, kPerMille * 1e-3 * static_cast<double>(bins));
  return rms_of(bins, [&](double) { return std::exp(0.3 * strength.next()) * noise(); });
}
template <int kPercent>
Numbers drift(std::size_t bins, GrowthNoise& noise) {
  return rms_of(bins, [&](double t) { return t + kPercent * 1e-2 * noise(); });
}
template <int kPercent>
Numbers walk_above(std::size_t bins, GrowthNoise& noise) {
  return walk(bins, noise, kPercent * 1e-2);
}
template <class Strength>
Numbers strength(std::size_t bins, GrowthNoise& noise, Strength of) {
  return rms_of(bins, [&](double t) { return of(t) * noise(); });
}

const Kind kKinds[] = {
    {"noise", "bounded", related<0>},
    {"noise related over 1/160 of the run", "bounded", related<6>},
    {"noise related over 1/40 of the run", "bounded", related<25>},
    {"noise related over 1/20 of the run", "bounded", related<50>},
    {"noise related over 1/10 of the run", "bounded", related<100>, 0.2},
    {"strength related over 1/80 of the run", "bounded", swelling<12>},
    {"strength related over 1/40 of the run", "bounded", swelling<25>},
    {"strength related over 1/20 of the run", "bounded", swelling<50>, 0.1},
    {"walk", "square root", walk_above<0>},
    {"walk above noise of a tenth", "square root", walk_above<10>},
    {"walk above noise of a half", "square root", walk_above<50>},
    {"strength sqrt t", "square root",
     [](std::size_t b, GrowthNoise& n) { return strength(b, n, [](double t) { return std::sqrt(t); }); }},
    {"drift above noise of 5 %", "linear", drift<5>},
    {"drift above noise of 20 %", "linear", drift<20>},
    {"drift above noise of 100 %", "linear", drift<100>},
    {"strength t", "linear", [](std::size_t b, GrowthNoise& n) { return strength(b, n, [](double t) { return t; }); }},
    {"strength 0.2 + t", "linear",
     [](std::size_t b, GrowthNoise& n) { return strength(b, n, [](double t) { return 0.2 + t; }); }},
    {"strength 1 + t", "linear",
     [](std::size_t b, GrowthNoise& n) { return strength(b, n, [](double t) { return 1 + t; }); }},
    {"strength 1 + 0.3 t", "linear",
     [](std::size_t b, GrowthNoise& n) { return strength(b, n, [](double t) { return 1 + 0.3 * t; }); }},
    {"strength t^2", "undetermined",
     [](std::size_t b, GrowthNoise& n) { return strength(b, n, [](double t) { return t * t; }); }},
    {"strength exp 5 t", "undetermined",
     [](std::size_t b, GrowthNoise& n) { return strength(b, n, [](double t) { return std::exp(5 * t); }); }},
};

struct Rates {
  double named = 0, falsely = 0;
  std::map<std::string, int> counts;
};
Rates rates_of(const Kind& kind, std::size_t bins, int seeds) {
  const GrowthFit fit(bin_times(bins));
  Rates rates;
  for (int seed = 0; seed < seeds; ++seed) {
    GrowthNoise noise{std::mt19937_64(static_cast<std::uint64_t>(seed))};
    const std::string name = growth_name(fit(kind.series(bins, noise)).value());
    ++rates.counts[name];
    if (name == kind.truth) rates.named += 1.0 / seeds;
    if (name != kind.truth && name != "undetermined") rates.falsely += 1.0 / seeds;
  }
  return rates;
}

}  // namespace

// test_reports "[.rates]" prints the rates that docs/reference/metrics.md states.
TEST_CASE("how often each growth is named", "[.rates]") {
  for (const Kind& kind : kKinds) {
    for (const std::size_t bins : {20, 60, 119}) {
      const Rates rates = rates_of(kind, bins, 1000);
      fmt::print("{:40} {:3} bins: {:12} named {:5.1f} %, falsely {:4.1f} %\n", kind.name, bins, kind.truth,
                 100 * rates.named, 100 * rates.falsely);
    }
  }
}

TEST_CASE("growth: at most 5 % of 300 series are named falsely, but of noise that is related for long", "[sweep]") {
  for (const Kind& kind : kKinds) {
    for (const std::size_t bins : {20, 60, 119}) {
      CAPTURE(kind.name, bins);
      CHECK(rates_of(kind, bins, 300).falsely <= kind.most_false);
    }
  }
}

TEST_CASE("growth: what is plain is named, by nine in ten series of 119 bins, a walk by one in seven", "[sweep]") {
  for (const Kind& kind : kKinds) {
    const std::string name = kind.name;
    double least = 0;
    for (const char* plain : {"noise", "strength sqrt t", "drift above noise of 5 %", "drift above noise of 20 %",
                              "strength t", "strength 0.2 + t"})
      least = name == plain ? 0.88 : least;
    if (name == "walk" || name == "walk above noise of a tenth") least = 1 / 7.0;
    CAPTURE(name);
    CHECK(rates_of(kind, 119, 300).named >= least);
  }
}

TEST_CASE("growth without noise: each power, also above a start of any size, is named or not, but never falsely") {
  for (const std::size_t bins : {20, 60, 119}) {
    for (const double begin : {0.0, 0.02, 0.3}) {
      const Numbers t = bin_times(bins, begin);
      const GrowthFit fit(t);
      for (const auto& [power, name] : {std::pair{0.5, "square root"}, {1.0, "linear"}, {2.0, "undetermined"}}) {
        for (const double start : {0.0, 0.01, 0.1, 0.5}) {
          for (const bool offset : {true, false}) {
            Numbers rms;
            for (const double at : t) {
              const double grown = std::pow(at, power);
              rms.push_back(1e-6 * (offset ? start + grown : std::hypot(start, grown)));
            }
            const std::string is = growth_name(fit(rms).value());
            CAPTURE(bins, begin, power, start, offset, fit(rms)->low, fit(rms)->high);
            CHECK((is == name || is == "undetermined"));
            if (start == 0) CHECK(is == name);
          }
        }
      }
    }
  }
}

TEST_CASE("growth: no error at all and an error that stays are bounded, what grows by less than a quarter is, too") {
  const GrowthFit fit(bin_times(60));
  for (const double level : {0.0, 5e-324, 1e-300, 1e-13, 1.0, 1e300}) {
    const GrowthInterval interval = fit(Numbers(60, level)).value();
    CHECK((interval.low == 0 && interval.high == 0));
    CHECK(growth_text(interval) == "bounded (0)");
  }
  Numbers rms;
  for (std::size_t i = 0; i < 60; ++i) rms.push_back(1 + 0.1 * time_of(i, 60));
  CHECK(std::string(growth_name(fit(rms).value())) == "bounded");
}

TEST_CASE("growth: fewer than ten bins and values that are not finite have none, any others are inside [0, 5]") {
  for (std::size_t bins = 0; bins < 10; ++bins) CHECK_FALSE(GrowthFit(bin_times(bins))(Numbers(bins, 1.0)));
  const GrowthFit fit(bin_times(40));
  CHECK_FALSE(fit(Numbers(39, 1.0)));
  std::mt19937_64 bits(1);
  for (int i = 0; i < 2000; ++i) {
    Numbers rms;
    for (int b = 0; b < 40; ++b)
      rms.push_back(bits() % 3 == 0 ? 0.0 : std::ldexp(1.0, static_cast<int>(bits() % 2000) - 1000));
    const GrowthInterval interval = fit(rms).value();
    REQUIRE((interval.low >= 0 && interval.low <= interval.high && interval.high <= 5));
    const GrowthInterval again = fit(rms).value();
    REQUIRE((again.low == interval.low && again.high == interval.high));
    rms[bits() % 40] = i % 2 ? std::numeric_limits<double>::infinity() : std::numeric_limits<double>::quiet_NaN();
    REQUIRE_FALSE(fit(rms));
  }
}

TEST_CASE("growth: the interval alone decides the name, which it contains alone") {
  const auto name = [](double low, double high) { return std::string(growth_name({low, high})); };
  CHECK(name(0, 0) == "bounded");
  CHECK(name(0, 0.4) == "bounded");
  CHECK(name(0, 0.5) == "undetermined");
  CHECK(name(0.1, 0.4) == "undetermined");
  CHECK(name(0.1, 0.9) == "square root");
  CHECK(name(0.5, 1) == "undetermined");
  CHECK(name(0.6, 1.9) == "linear");
  CHECK(name(0.6, 2) == "undetermined");
  CHECK(name(1.1, 5) == "undetermined");
  CHECK(growth_text({0.9, 1.1}) == "linear (0.9 to 1.1)");
}
