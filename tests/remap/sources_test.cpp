// What a device plays when samples come from elsewhere. Each comparator is checked against the law that it follows.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <vector>

#include "catch.h"
#include "evenstep/remap/chunk_player.h"
#include "evenstep/remap/resampler.h"
#include "evenstep/remap/source_maps.h"
#include "for_all.h"

using namespace evenstep;
using namespace evenstep::testing;

namespace {

constexpr Duration kPeriod{10'000'000};

RealTime at_ms(double ms) { return RealTime{static_cast<std::int64_t>(ms * 1e6)}; }

ResamplerSpec of_kind(Resampling kind) {
  ResamplerSpec spec;
  spec.kind = kind;
  spec.period = kPeriod;
  return spec;
}

}  // namespace

TEST_CASE("sources: a scheduled line is exact on constant velocity wherever it has both neighbours, in 10,000 lines") {
  for (std::uint64_t seed = 0; seed < cases(10'000); ++seed) {
    Draw draw(seed);
    const double slope = 200 * draw.unit() - 100, start = draw.unit();
    Resampler<double> line(of_kind(Resampling::scheduled));
    std::vector<RealTime> stamps;
    RealTime stamp{draw.between(0, 1'000'000)};
    for (int i = 0; i < 30; ++i, stamp = stamp + Duration{draw.between(1, 20'000'000)}) stamps.push_back(stamp);
    // Samples arrive in another order: neighbours swap places, as when samples are late.
    std::vector<RealTime> order = stamps;
    for (std::size_t i = 0; i + 1 < order.size(); i += 2) {
      if (draw.unit() < 0.5) std::swap(order[i], order[i + 1]);
    }
    for (const RealTime one : order) line.arrive(one, start + slope * seconds(one - RealTime{}));
    for (int i = 0; i < 20; ++i) {
      const RealTime t{draw.between(stamps.front().ns, stamps.back().ns)};
      const Reading<double> played = line.at(t);
      REQUIRE(played.status == ReadStatus::inside);
      REQUIRE(played.value == Approx(start + slope * seconds(t - RealTime{})).epsilon(1e-12).margin(1e-12));
    }
    REQUIRE(line.at(stamps.back() + Duration{1}).status == ReadStatus::underrun);
    REQUIRE(line.at(stamps.front() - Duration{1}).status == ReadStatus::empty);
  }
}

TEST_CASE("sources: held samples jump by speed times period, in 1,000 speeds and periods") {
  for (std::uint64_t seed = 0; seed < 1'000; ++seed) {
    Draw draw(seed);
    const double speed = draw.unit();
    const Duration period{draw.between(1'000'000, 50'000'000)}, tick{100'000};
    Resampler<double> held(of_kind(Resampling::newest));
    double before = 0, most = 0;
    RealTime now, next;
    for (int k = 0; k < 2'000; ++k, now = now + tick) {
      for (; next <= now; next = next + period) held.arrive(next, speed * seconds(next - RealTime{}));
      const double value = held.at(now).value;
      if (k > 0) most = std::max(most, value - before);
      before = value;
    }
    REQUIRE(most == Approx(speed * seconds(period)).epsilon(1e-9));
  }
}

TEST_CASE("sources: of samples that come in any order the newest counts, and each that came too late, in 10,000 orders") {
  for (std::uint64_t seed = 0; seed < cases(10'000); ++seed) {
    Draw draw(seed);
    Resampler<double> newest(of_kind(Resampling::newest));
    std::int64_t most = -1, overtaken = 0;
    std::vector<std::int64_t> order;
    for (std::int64_t i = 0; i < 20; ++i) order.push_back(i);
    for (std::size_t i = order.size(); i > 1; --i)
      std::swap(order[i - 1], order[static_cast<std::size_t>(draw.between(0, static_cast<std::int64_t>(i) - 1))]);
    for (const std::int64_t i : order) {
      overtaken += i < most;
      most = std::max(most, i);
      newest.arrive(RealTime{i}, static_cast<double>(i));
      REQUIRE(newest.at(RealTime{1000}).value == static_cast<double>(most));
    }
    REQUIRE(newest.overtaken() == overtaken);
  }
}

TEST_CASE("sources: the slope of Holt-Winters converges to that of a line as its recurrence says, in 1,000 weights") {
  for (std::uint64_t seed = 0; seed < 1'000; ++seed) {
    Draw draw(seed);
    ResamplerSpec spec = of_kind(Resampling::holt_winters);
    spec.level = 0.1 + 0.89 * draw.unit();
    spec.trend = 0.05 + 0.95 * draw.unit();
    const double a = spec.level, g = spec.trend, slope = 20 * draw.unit() - 10;
    // With d the period, the matrix (1 - a, 1 - a; -a g, 1 - a g) of determinant 1 - a maps the errors of the level and of
    // the trend times d to the next ones.
    const double trace = 2 - a - a * g, gap = trace * trace / 4 - (1 - a);
    const double radius = gap < 0 ? std::sqrt(1 - a) : trace / 2 + std::sqrt(gap);
    REQUIRE(radius < 1);
    const int count = static_cast<int>(std::ceil(std::log(1e-14) / std::log(radius))) + 50;
    Resampler<double> holt(spec);
    double level = 0, trend = -slope * seconds(kPeriod);  // errors: l - x, (b - v) d
    for (int n = 0; n < count; ++n) {
      const RealTime stamp = RealTime{} + kPeriod * n;
      holt.arrive(stamp, 3 + slope * seconds(stamp - RealTime{}));
      if (n == 0) continue;
      const double next = (1 - a) * (level + trend);
      trend = (1 - a * g) * trend - a * g * level;
      level = next;
      if (n < 40) REQUIRE(holt.trend_per_s() - slope == Approx(trend / seconds(kPeriod)).epsilon(1e-6).margin(1e-9));
    }
    REQUIRE(holt.trend_per_s() == Approx(slope).epsilon(1e-9).margin(1e-9));
    // From then on it plays exactly the line, also between samples, and stops at the distance that it was given.
    const RealTime last = RealTime{} + kPeriod * (count - 1), between = last + Duration{3'000'000};
    REQUIRE(holt.at(between).value == Approx(3 + slope * seconds(between - RealTime{})).epsilon(1e-9).margin(1e-9));
    REQUIRE(holt.at(last + spec.furthest).status == ReadStatus::inside);
    const Reading<double> beyond = holt.at(last + spec.furthest + Duration{1});
    REQUIRE(beyond.status == ReadStatus::underrun);
    REQUIRE(beyond.value == holt.at(last + spec.furthest).value);
  }
}

TEST_CASE("sources: what is interpolated is what an engine draws that keeps an accumulator, in 5,000 loops") {
  for (std::uint64_t seed = 0; seed < cases(5'000); ++seed) {
    Draw draw(seed);
    Resampler<double> drawn(of_kind(Resampling::interpolated));
    // The loop of G. Fiedler, "Fix your timestep!": previous and current state, and what is left of the frames' time.
    double previous = 0, current = 0;
    std::int64_t accumulator = 0, states = 0;
    RealTime frame;
    for (int k = 0; k < 60; ++k) {
      const Duration took{draw.between(1, 3 * kPeriod.ns)};
      frame = frame + took;
      for (accumulator += took.ns; accumulator >= kPeriod.ns; accumulator -= kPeriod.ns) {
        previous = states == 0 ? 0 : current;
        current = draw.unit();
        if (states == 0) previous = current;
        drawn.arrive(RealTime{} + kPeriod * ++states, current);
      }
      if (states == 0) {
        REQUIRE(drawn.at(frame).status == ReadStatus::empty);
        continue;
      }
      const double alpha = static_cast<double>(accumulator) / static_cast<double>(kPeriod.ns);
      const Reading<double> shown = drawn.at(frame);
      REQUIRE(shown.status == ReadStatus::inside);
      REQUIRE(shown.value == Approx(current * alpha + previous * (1 - alpha)).epsilon(1e-12).margin(1e-12));
    }
    // A frame that is late shows the last state; nothing is continued.
    REQUIRE(drawn.at(frame + kPeriod * 2).value == current);
  }
}

TEST_CASE("sources: polyphase has gain 1 and no delay of its own below a fifth of the source's rate, to 0.15 %") {
  Resampler<double> filter(of_kind(Resampling::polyphase));
  for (const double cycles : {0.01, 0.05, 0.1, 0.15, 0.2}) {  // per period
    for (const double phase : {0.0, 0.7, 2.1, 4.0}) {
      Resampler<double> sine = filter;
      const auto signal = [&](RealTime t) {
        return std::sin(2 * std::numbers::pi * cycles * ratio(t - RealTime{}, kPeriod) + phase);
      };
      for (int i = 0; i < 40; ++i) sine.arrive(RealTime{} + kPeriod * i, signal(RealTime{} + kPeriod * i));
      for (int k = 0; k <= 1'000; ++k) {
        const RealTime t = at_ms(100 + 0.1 * k);
        REQUIRE(sine.at(t).status == ReadStatus::inside);
        REQUIRE(std::abs(sine.at(t).value - signal(t)) <= 1.5e-3);
      }
    }
  }
}

TEST_CASE(
    "sources: polyphase keeps a constant whatever is lost, and knows when samples ahead are missing, in 10,000 cases") {
  for (std::uint64_t seed = 0; seed < cases(10'000); ++seed) {
    Draw draw(seed);
    ResamplerSpec spec = of_kind(Resampling::polyphase);
    spec.taps = static_cast<int>(draw.between(2, 8));
    const double value = draw.unit();
    Resampler<double> filter(spec);
    RealTime newest;
    for (int i = 0; i < 60; ++i) {
      if (i > 0 && draw.unit() < 0.1) continue;
      newest = RealTime{} + kPeriod * i;
      filter.arrive(newest, value);
    }
    const RealTime t{draw.between(0, newest.ns + 10'000'000)};
    const Reading<double> played = filter.at(t);
    REQUIRE(played.value == Approx(value).epsilon(1e-12));
    if (newest < t + kPeriod * (spec.taps - 1)) REQUIRE(played.status == ReadStatus::underrun);
  }
}

namespace {

/// Samples 0 to 59 of a schedule that wobbles by up to a tenth of a period. Some are lost, but never the first two and the
/// last two. A lost sample is given the place on the line between its neighbours.
struct LossyPair {
  struct One {
    RealTime stamp;
    double value = 0;
    bool lost = false;
  };
  LossyPair(Draw& draw, double share, const std::function<double(RealTime)>& signal) {
    for (int i = 0; i < 60; ++i) {
      const RealTime stamp = RealTime{} + kPeriod * i + Duration{draw.between(0, 1'000'000)};
      all.push_back({stamp, signal(stamp), i > 1 && i < 58 && draw.unit() < share});
    }
    for (std::size_t i = 1; i < all.size(); ++i) {
      if (!all[i].lost) continue;
      std::size_t next = i;
      while (all[next].lost) ++next;
      const One from = all[i - 1], to = all[next];
      const auto parts = static_cast<std::int64_t>(next - i + 1);
      for (std::int64_t j = 1; j < parts; ++j, ++i) {
        all[i].stamp = from.stamp + Duration{(to.stamp - from.stamp).ns * j / parts};
        all[i].value = from.value + (to.value - from.value) * static_cast<double>(j) / static_cast<double>(parts);
      }
    }
  }
  std::vector<One> all;
};

}  // namespace

TEST_CASE("sources: polyphase plays a lost sample as one on the line between its neighbours, in 10,000 schedules") {
  for (std::uint64_t seed = 0; seed < cases(10'000); ++seed) {
    Draw draw(seed);
    ResamplerSpec spec = of_kind(Resampling::polyphase);
    spec.taps = static_cast<int>(draw.between(1, 8));
    const LossyPair pair(draw, 0.3, [&](RealTime) { return draw.unit(); });
    Resampler<double> by_pace(spec), by_number(spec), filled(spec);
    std::int64_t number = 0;
    for (const LossyPair::One& one : pair.all) {
      filled.arrive(one.stamp, one.value);
      if (!one.lost) by_pace.arrive(one.stamp, one.value);
      if (!one.lost) by_number.arrive(one.stamp, one.value, number);
      ++number;
    }
    for (int i = 0; i < 10; ++i) {
      const RealTime t{draw.between(pair.all.front().stamp.ns, pair.all.back().stamp.ns)};
      INFO("seed " << seed << ", " << t.ns << " ns, taps " << spec.taps);
      REQUIRE(by_pace.at(t).value == Approx(filled.at(t).value).epsilon(1e-12).margin(1e-12));
      REQUIRE(by_number.at(t).value == Approx(filled.at(t).value).epsilon(1e-12).margin(1e-12));
      REQUIRE(by_pace.at(t).status == filled.at(t).status);
    }
  }
}

TEST_CASE("sources: with losses polyphase errs on a sine by its own 0.15 % and what a line leaves out, in 2,000 sines") {
  for (std::uint64_t seed = 0; seed < cases(2'000); ++seed) {
    Draw draw(seed);
    const double cycles = 0.01 + 0.04 * draw.unit(), phase = 6 * draw.unit();
    const auto signal = [&](RealTime t) {
      return std::sin(2 * std::numbers::pi * cycles * ratio(t - RealTime{}, kPeriod) + phase);
    };
    Resampler<double> lossy(of_kind(Resampling::polyphase));
    bool before = false;
    for (int i = 0; i < 60; ++i) {
      // Losses are single. The line between the neighbours of a lost sample is wrong by 1 - cos(w T) of the amplitude at
      // most. The absolute weights of every second tap add up to at most 1 (reached where the tick is at one of them), and
      // they are divided by a sum of 1.
      const bool lost = !before && i > 0 && draw.unit() < 0.05;
      if (!lost) lossy.arrive(RealTime{} + kPeriod * i, signal(RealTime{} + kPeriod * i));
      before = lost;
    }
    const double left_out = 1 - std::cos(2 * std::numbers::pi * cycles);
    for (int k = 0; k < 200; ++k) {
      const RealTime t = at_ms(100 + 2 * k);
      REQUIRE(lossy.at(t).status == ReadStatus::inside);
      REQUIRE(std::abs(lossy.at(t).value - signal(t)) <= 1.5e-3 + 1.1 * left_out);
    }
  }
}

TEST_CASE("sources: that a sample is missing is known from its number, if that can be true, and from the pace") {
  const auto at = [](double gap, std::optional<std::int64_t> first, std::optional<std::int64_t> second, double where) {
    ResamplerSpec spec = of_kind(Resampling::polyphase);
    Resampler<double> filter(spec);
    // A step from 0 to 1 between samples 9 and 10. A sample in between would be 0.5.
    for (int i = 0; i < 20; ++i) {
      const RealTime stamp = RealTime{} + kPeriod * i + Duration{i < 10 ? 0 : static_cast<std::int64_t>((gap - 1) * 1e7)};
      const auto& base = i < 10 ? first : second;
      filter.arrive(stamp, i < 10 ? 0 : 1, base ? std::optional(*base + i) : std::nullopt);
    }
    return filter.at(RealTime{} + kPeriod * 9 + Duration{static_cast<std::int64_t>(where * 1e7)}).value;
  };
  // In the middle of the step both give 0.5 by symmetry, so they are compared at a quarter of the gap.
  const double whole = at(1.4, {}, {}, 0.35), halved = at(1.4, 0, 1, 0.35);
  CHECK(std::abs(whole - halved) > 0.02);
  CHECK(at(1.4, 0, 0, 0.35) == whole);              // numbers that follow each other, a gap below 1.5
  CHECK(at(1.4, 0, 1'000'000, 0.35) == whole);      // a source that began again: 0.0000014 periods a number cannot be true
  CHECK(at(1.4, 5'000, 0, 0.35) == whole);          // one that began again from 0
  CHECK(at(1.6, 0, 0, 0.4) == at(1.6, 0, 1, 0.4));  // no number is missing, but the gap is long: a line here, too
  CHECK(at(1.6, {}, {}, 0.4) == at(1.6, 0, 1, 0.4));
  CHECK(at(3, {}, {}, 1) == Approx(1.0 / 3).epsilon(1e-12));  // at a missing sample: its value on the line
  CHECK(at(3, {}, {}, 2) == Approx(2.0 / 3).epsilon(1e-12));
}

TEST_CASE("sources: where the neighbour ahead is not there yet, polyphase continues the line for its taps, and says so") {
  for (std::uint64_t seed = 0; seed < cases(2'000); ++seed) {
    Draw draw(seed);
    ResamplerSpec spec = of_kind(Resampling::polyphase);
    spec.taps = static_cast<int>(draw.between(1, 8));
    const double slope = 20 * draw.unit() - 10;
    const auto line = [&](RealTime t) { return 1 + slope * seconds(t - RealTime{}); };
    Resampler<double> cut(spec), whole(spec);
    for (int i = 0; i < 40; ++i) {
      const RealTime stamp = RealTime{} + kPeriod * i;
      if (i < 20 && i != 18) cut.arrive(stamp, line(stamp));
      whole.arrive(stamp, line(stamp));
    }
    const RealTime newest = RealTime{} + kPeriod * 19;
    for (int k = 0; k < 20; ++k) {
      const RealTime t{draw.between(newest.ns - 30'000'000, newest.ns)};
      const Reading<double> played = cut.at(t);
      REQUIRE(played.value == Approx(whole.at(t).value).epsilon(1e-12).margin(1e-12));
      REQUIRE((played.status == ReadStatus::underrun) == (newest < t + kPeriod * (spec.taps - 1)));
    }
    // Past the newest sample its value is held.
    REQUIRE(cut.at(newest + Duration{1}).value == line(newest));
    REQUIRE(cut.at(newest + Duration{1}).status == ReadStatus::underrun);
    // A burst is continued as if its samples were a period apart, so that the taps that are missing cannot run away.
    Resampler<double> burst(spec);
    for (int i = 0; i < 20; ++i) burst.arrive(RealTime{} + Duration{1'000} * i, slope * i);
    REQUIRE(std::abs(burst.at(RealTime{} + Duration{18'999}).value) <= std::abs(slope) * (20 + spec.taps));
  }
}

TEST_CASE("sources: the windowed sinc is that of a second computation, zero at whole numbers and beyond its taps") {
  const auto bessel = [](double x) {  // by its integral: mean of exp(x cos) over the circle
    double sum = 0;
    for (int i = 0; i < 64; ++i) sum += std::exp(x * std::cos(2 * std::numbers::pi * i / 64));
    return sum / 64;
  };
  for (int taps = 1; taps <= 32; ++taps) {
    for (double u = -taps - 1; u <= taps + 1; u += 1.0 / 64) {
      const double edge = u / taps, angle = std::numbers::pi * u;
      const double expected =
          std::abs(edge) >= 1 ? 0
                              : (u == 0 ? 1 : std::sin(angle) / angle) * bessel(6 * std::sqrt(1 - edge * edge)) / bessel(6);
      REQUIRE(internal::windowed_sinc(u, taps) == Approx(expected).epsilon(1e-12).margin(1e-14));
      if (u != 0 && u == std::floor(u)) REQUIRE(std::abs(internal::windowed_sinc(u, taps)) < 1e-15);
    }
  }
}

namespace {

ChunkSpec chunks_of(ChunkRule rule, int entries = 10) {
  ChunkSpec spec;
  spec.rule = rule;
  spec.entries = entries;
  spec.every = kPeriod;
  return spec;
}

/// A chunk of a policy that sees `value` at `stamp` and continues with `slope`.
Chunk<double> chunk(RealTime stamp, double value, double slope) { return {stamp, value, slope * seconds(kPeriod)}; }

}  // namespace

TEST_CASE("chunks: all rules play a line exactly as long as a chunk covers the time, in 10,000 schedules") {
  for (std::uint64_t seed = 0; seed < cases(10'000); ++seed) {
    Draw draw(seed);
    const double slope = 2 * draw.unit() - 1;
    const auto value = [&](RealTime t) { return 1 + slope * seconds(t - RealTime{}); };
    for (const ChunkRule rule : {ChunkRule::replace, ChunkRule::append, ChunkRule::blend}) {
      ChunkPlayer<double> player(chunks_of(rule, 12));
      Draw same = draw;
      RealTime stamp;
      RealTime covered;  // the end of the last entry
      for (int n = 0; n < 8; ++n) {
        const RealTime arrives = stamp + Duration{same.between(1'000'000, 80'000'000)};
        player.arrive(arrives, chunk(stamp, value(stamp), slope));
        covered = stamp + kPeriod * 12;
        const RealTime next = arrives + Duration{same.between(0, 20'000'000)};
        for (RealTime t = arrives; t < next; t = t + Duration{1'000'000}) {
          const Reading<double> played = player.at(t);
          // The last entry is held until the end of its time, and beyond.
          REQUIRE(played.value == Approx(value(std::min(t, covered - kPeriod))).epsilon(1e-12));
          REQUIRE(played.status == (t < covered ? ReadStatus::inside : ReadStatus::underrun));
        }
        stamp = next;
      }
    }
  }
}

TEST_CASE(
    "chunks: where two disagree by D, replace jumps by D at once, append at the old one's end, blend by D times a share") {
  const double old_value = 1, new_value = 3, jump = new_value - old_value;
  const auto player = [&](ChunkRule rule, double decay = 0) {
    ChunkSpec spec = chunks_of(rule);
    spec.decay = decay;
    ChunkPlayer<double> chunks(spec);
    chunks.arrive(at_ms(20), chunk(at_ms(0), old_value, 0));
    chunks.arrive(at_ms(60), chunk(at_ms(40), new_value, 0));
    return chunks;
  };
  const auto replaced = player(ChunkRule::replace), appended = player(ChunkRule::append);
  CHECK(replaced.at(at_ms(59)).value == old_value);
  CHECK(replaced.at(at_ms(60)).value == new_value);
  CHECK(appended.at(at_ms(89.9)).value == old_value);  // entry 9 is for 90 ms
  CHECK(appended.at(at_ms(90)).value == new_value);
  for (const double decay : {0.0, 0.01, 0.5, 3.0}) {
    const auto blended = player(ChunkRule::blend, decay);
    const double share = std::exp(-decay) / (1 + std::exp(-decay));  // of the newer one
    CHECK(blended.at(at_ms(70)).value == Approx(old_value + share * jump).epsilon(1e-12));
    CHECK(blended.at(at_ms(110)).value == Approx(new_value).epsilon(1e-12));
  }
}

TEST_CASE("chunks: on a steady acceleration replace jumps by what the policy's line has missed") {
  // The line through x(s) and x(s - w), continued for b, is wrong by a b (b + w) / 2. When a new chunk arrives, the line of
  // the old chunk has been continued for longer than the new one.
  const double a = 4;
  const Duration every{100'000'000}, takes{60'000'000};
  const auto x = [&](RealTime t) { return a / 2 * seconds(t - RealTime{}) * seconds(t - RealTime{}); };
  ChunkPlayer<double> player(chunks_of(ChunkRule::replace, 40));
  for (int n = 1; n < 10; ++n) {
    const RealTime stamp = RealTime{} + every * n, arrives = stamp + takes;
    const double before = n > 1 ? player.at(arrives).value : 0;
    player.arrive(arrives, chunk(stamp, x(stamp), (x(stamp) - x(stamp - every)) / seconds(every)));
    if (n == 1) continue;
    const auto missed = [&](Duration b) { return a * seconds(b) * (seconds(b) + seconds(every)) / 2; };
    REQUIRE(player.at(arrives).value - before == Approx(missed(takes + every) - missed(takes)).epsilon(1e-9));
  }
}

TEST_CASE("chunks: one that comes after a later one is dropped and counted, and a queue that runs dry holds its end") {
  for (const ChunkRule rule : {ChunkRule::replace, ChunkRule::append, ChunkRule::blend}) {
    ChunkPlayer<double> player(chunks_of(rule));
    CHECK(player.at(at_ms(0)).status == ReadStatus::empty);
    player.arrive(at_ms(30), chunk(at_ms(20), 5, 1));
    player.arrive(at_ms(35), chunk(at_ms(0), 7, 1));
    CHECK(player.overtaken() == 1);
    CHECK(player.at(at_ms(119.9)).status == ReadStatus::inside);
    const Reading<double> dry = player.at(at_ms(400));
    CHECK(dry.status == ReadStatus::underrun);
    CHECK(dry.value == Approx(5.09).epsilon(1e-12));  // entry 9
  }
}

TEST_CASE("sources: an absolute grid outlasts a clock that is slower by p for the buffer over p, to a period") {
  const Rate rate{100, 1};
  for (std::int64_t ppm : {20, 100, 500, 2'000}) {
    for (const Duration buffer : {Duration{5'000'000}, Duration{20'000'000}}) {
      AbsoluteGridMap map(rate, {}, buffer);
      const Duration takes{1'000'000};
      std::int64_t n = 0;
      RealTime begin;
      for (;; ++n) {
        begin = RealTime{floor_mul_div(tick_time(rate, n).ns, 1'000'000, 1'000'000 - ppm)};
        map.read(n, begin);
        if (map.emission(n, begin + takes) < begin + takes) break;
      }
      const double expected_s = seconds(buffer - takes) / (1e-6 * static_cast<double>(ppm));
      INFO(ppm << " ppm, " << buffer.ns << " ns");
      CHECK(std::abs(seconds(begin - RealTime{}) - expected_s) <= 0.011 + 1e-6 * static_cast<double>(ppm) * expected_s);
    }
  }
}

TEST_CASE("sources: a lost force needs no latency, and the next one must bridge the gap, in 10,000 schedules") {
  const SamplingGrid device{};
  for (std::uint64_t seed = 0; seed < cases(10'000); ++seed) {
    Draw draw(seed);
    std::vector<MappedStep> steps;
    RealTime begin;
    for (std::int64_t n = 0; n < 30; ++n, begin = begin + Duration{draw.between(8'000'000, 12'000'000)})
      steps.push_back(
          {n, begin, begin + Duration{draw.between(1'000'000, 40'000'000)}, begin, n, n > 0 && draw.unit() < 0.2});
    std::vector<MappedStep> there;
    std::copy_if(steps.begin(), steps.end(), std::back_inserter(there), [](const MappedStep& step) { return !step.lost; });
    for (const Emission emission : {Emission::hold, Emission::linear}) {
      const LatencyBudget all = least_latency_any_phase(steps, {&device, 1}, emission);
      const LatencyBudget rest = least_latency_any_phase(there, {&device, 1}, emission);
      REQUIRE(all.latency == rest.latency);
      REQUIRE(all.latency_culprit == rest.latency_culprit);
      REQUIRE(count_late_forces(steps, all.lead, all.latency, emission) == 0);
      REQUIRE(count_late_forces(steps, all.lead, all.latency - Duration{1}, emission) == 1);
    }
  }
}
