// The governor that spreads steps over their slots, alone and with drawings in parts.
#include "evenstep/scheduler/frame_governor.h"
#include "governor_schedules.h"

using namespace evenstep;
using namespace evenstep::governor_schedules;

namespace {

/// Half of them with steps of any length, half with steps that fit their slots.
void check_split_and_spread(std::uint64_t first, std::uint64_t schedules) {
  std::int64_t later_than_split = 0, later_than_spread = 0, early = 0, needs_more = 0, wins = 0;
  for (std::uint64_t seed = first; seed < first + schedules; ++seed) {
    const bool fit = seed % 2 == 0;
    const auto [period, source] = paced_schedule(seed, fit);
    const int parts = 2 + static_cast<int>(seed / 2 % 5);
    const std::vector<Interval> split = steps_of(governed(source, {.split = parts}, period)),
                                spread = steps_of(governed(source, {.spread = true}, period)),
                                both = steps_of(governed(source, {.split = parts, .spread = true}, period));
    Duration lead, split_late, spread_late, late, longest_slot;
    std::vector<RealTime> slots;
    for (std::size_t k = 0; k < source.size(); ++k) {
      const std::int64_t count = std::ssize(source[k].steps);
      longest_slot = std::max(longest_slot, Duration{period.ns / count + 1});
      for (std::int64_t i = 0; i < count; ++i)
        slots.push_back(RealTime{static_cast<std::int64_t>(k) * period.ns + floor_mul_div(period.ns, i, count)});
    }
    for (std::size_t n = 0; n < slots.size(); ++n) {
      lead = std::max(lead, slots[n] - split[n].begin);
      split_late = std::max(split_late, split[n].end - slots[n]);
      spread_late = std::max(spread_late, spread[n].end - slots[n]);
      late = std::max(late, both[n].end - slots[n]);
    }
    const Duration other_parts = Duration{(longest_pause(source).ns + parts - 1) / parts} * (parts - 1);
    for (std::size_t n = 0; n < slots.size(); ++n) {
      early += both[n].begin < slots[n];
      later_than_split += both[n].end > split[n].end + lead;
      later_than_spread += both[n].end > spread[n].end + other_parts;
    }
    needs_more += late > lead + split_late || (fit && late > spread_late + longest_slot);
    wins += late < std::min(lead + split_late, spread_late);
  }
  CHECK(early == 0);
  CHECK(later_than_split == 0);
  CHECK(later_than_spread == 0);
  CHECK(needs_more == 0);
  CHECK(wins > static_cast<std::int64_t>(schedules / 2));
}

}  // namespace

TEST_CASE("a step that is spread begins at its slot or when it could begin without, whichever is later",
          "[governor][spread]") {
  // 100,000 schedules with a period that is known and steps that fit their slots: long drawings and any number of steps.
  std::int64_t wrong = 0, waited = 0, late = 0, steps = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(100'000); ++seed) {
    const auto [period, source] = paced_schedule(seed, true);
    const auto after = governed(source, {.spread = true}, period);
    REQUIRE(after.size() == source.size());
    for (std::size_t k = 0; k < source.size(); ++k) {
      const std::vector<Interval>&before = source[k].steps, &now = after[k].steps;
      const auto count = static_cast<std::int64_t>(before.size());
      for (std::int64_t i = 0; i < count; ++i) {
        const auto n = static_cast<std::size_t>(i);
        const RealTime slot{static_cast<std::int64_t>(k) * period.ns + floor_mul_div(period.ns, i, count)};
        const RealTime expected = std::max(slot, before[n].begin);
        // The source's gaps of up to a hundredth of the period are work.
        wrong += now[n].begin < expected || now[n].begin > expected + Duration{period.ns / 100};
        late += now[n].begin > expected;
        waited += now[n].begin > before[n].begin;
        ++steps;
      }
    }
  }
  CHECK(wrong == 0);
  CHECK(waited > steps / 4);
  CHECK(late < steps / 1000);
}

TEST_CASE("a spread step comes later than in a burst by at most one segment, however long steps and drawings take",
          "[governor][spread]") {
  // 100,000 recordings whose turns come up to 3 % late. What is learned from them may be wrong.
  std::int64_t wrong = 0, early = 0, lost = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(100'000); ++seed) {
    const std::vector<SegmentTiming> source = paced_schedule(seed, false, seed % 31).segments;
    const auto after = governed_replay(source, {.spread = true});
    Duration longest;
    for (std::size_t k = 0; k < source.size(); ++k) {
      const RealTime next = k + 1 < source.size() ? source[k + 1].begin : source[k].begin + Duration{1'000 * kMs};
      longest = std::max(longest, next - source[k].begin);
      wrong += after.at(k).begin - source[k].begin > longest;
      for (std::size_t i = 0; i < source[k].steps.size(); ++i) {
        const Duration by = after[k].steps.at(i).begin - source[k].steps[i].begin;
        wrong += by > longest;
        early += by < Duration{};
      }
    }
    lost +=
        step_durations(after) != step_durations(source) || visualization_durations(after) != visualization_durations(source);
  }
  CHECK(wrong == 0);
  CHECK(early == 0);
  CHECK(lost == 0);
}

TEST_CASE("spread steps end no later after their slots than a burst begins before and ends after them",
          "[governor][spread]") {
  // 100,000 schedules: steps of any length. Lateness and lead together are what a latency has to bridge.
  std::int64_t wrong = 0, less = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(100'000); ++seed) {
    const auto [period, source] = paced_schedule(seed, false);
    const std::vector<Interval> burst = steps_of(source), spread = steps_of(governed(source, {.spread = true}, period));
    Duration earliest, latest, spread_latest;
    std::size_t n = 0;
    for (std::size_t k = 0; k < source.size(); ++k) {
      const auto count = static_cast<std::int64_t>(source[k].steps.size());
      for (std::int64_t i = 0; i < count; ++i, ++n) {
        const RealTime slot{static_cast<std::int64_t>(k) * period.ns + floor_mul_div(period.ns, i, count)};
        earliest = std::max(earliest, slot - burst[n].begin);
        latest = std::max(latest, burst[n].end - slot);
        spread_latest = std::max(spread_latest, spread.at(n).end - slot);
        wrong += spread[n].begin < slot;
      }
    }
    wrong += spread_latest > earliest + latest;
    less += spread_latest < earliest + latest;
  }
  CHECK(wrong == 0);
  CHECK(less > evenstep::testing::cases(50'000));
}

TEST_CASE("split and spread together need no more than split alone, and if steps fit, within a slot of spread alone",
          "[governor][spread]") {
  check_split_and_spread(0, evenstep::testing::cases(20'000));
}
TEST_CASE("split and spread together are within the same bounds on 200,000 other schedules", "[million]") {
  check_split_and_spread(1'000'000, evenstep::testing::cases(200'000));
}

TEST_CASE("a long step after the last part ends later than with spread alone by the other parts", "[governor][spread]") {
  // Segments of 40 ms: a drawing of 12 ms and 4 steps of 1 ms; the third step of the second segment takes 30 ms.
  std::vector<SegmentTiming> source;
  for (int k = 0; k < 3; ++k) {
    const RealTime at{k * 40 * kMs};
    SegmentTiming segment{k, at, Interval{at, at + Duration{12 * kMs}}, {}, {}};
    segment.end = segment.visualization->end;
    for (int i = 0; i < 4; ++i) {
      segment.steps.push_back({segment.end, segment.end + Duration{(k == 1 && i == 2 ? 30 : 1) * kMs}});
      segment.end = segment.steps.back().end;
    }
    source.push_back(segment);
  }
  const auto end_of_it = [&](const FrameGovernor& governor) {
    return steps_of(governed(source, governor, Duration{40 * kMs})).at(6).end.ns / kMs;
  };
  CHECK(end_of_it({.spread = true}) == 40 + 20 + 30);
  CHECK(end_of_it({.split = 2, .spread = true}) == 40 + 20 + 6 + 30);
}

TEST_CASE("split parts that are spread have their turns at the slots of their first steps", "[governor][spread]") {
  std::vector<SegmentTiming> source = free_running({4});
  source.front().steps.pop_back();  // 3 steps of 1 ms, so the second part comes before the second
  std::vector<std::int64_t> begins;
  for (const SegmentTiming& segment : governed(source, {.split = 2, .spread = true}, Duration{60 * kMs})) {
    begins.push_back(segment.begin.ns / kMs);
    for (const Interval& step : segment.steps) begins.push_back(step.begin.ns / kMs);
  }
  CHECK(begins == std::vector<std::int64_t>{0, 2, 20, 22, 40});
}

TEST_CASE("a recording with a stated pace is split and spread from its first segment on", "[governor][spread]") {
  std::vector<std::int64_t> begins;
  const FrameGovernor governor{.split = 2, .pace = Duration{40 * kMs}, .spread = true};
  for (const Interval& step : steps_of(governed_replay(free_running({4, 4}), governor)))
    begins.push_back(step.begin.ns / kMs);
  CHECK(begins == std::vector<std::int64_t>{2, 10, 22, 30, 42, 50, 62, 70});
}

TEST_CASE("of a recording without a grid the parts of the first segment follow each other at once", "[governor][spread]") {
  std::vector<std::int64_t> ends;
  for (const SegmentTiming& segment : governed_replay(free_running({4, 4}), {.split = 2, .spread = true})) {
    ends.push_back(segment.visualization->end.ns / kMs);
    ends.push_back(segment.steps.back().end.ns / kMs);
  }
  // Drawings of 4 ms in two parts, and four steps of 1 ms shared out.
  CHECK(std::vector(ends.begin(), ends.begin() + 4) == std::vector<std::int64_t>{2, 4, 6, 8});
}

TEST_CASE("what spread did with a recording up to an instant is the same whatever comes after", "[governor][spread]") {
  std::int64_t wrong = 0, compared = 0;
  for (std::uint64_t drawn = 0; drawn < evenstep::testing::cases(40'000); ++drawn) {
    const std::uint64_t seed = drawn / 2;
    const FrameGovernor governor{.split = 1 + static_cast<int>(drawn % 2), .spread = true};
    const std::vector<SegmentTiming> source = paced_schedule(seed, false, seed % 31).segments;
    std::vector<SegmentTiming> other = source;
    // From step `at` of segment `from` on everything is another recording's, later by a time that is drawn; or nothing
    // comes any more. Who shares steps out between parts knows the period of the recording and the steps of a segment.
    const bool shares = governor.split > 1;
    const std::size_t from = 3 + seed % 8, all = source[from].steps.size(), at = shares ? all : seed % (all + 1);
    const RealTime instant = at < source[from].steps.size() ? source[from].steps[at].begin : source[from + 1].begin;
    other.resize(from + 1);
    other[from].steps.resize(at);
    other[from].end = instant;
    if (seed % 3 > 0) {
      const Duration by{1 + static_cast<std::int64_t>(RandomStream(seed, "governor.cut").below(0, 60 * kMs))};
      for (const SegmentTiming& next : paced_schedule(seed + 1, false).segments) {
        SegmentTiming segment = next;
        const auto move = [&](Interval& i) {
          i = {i.begin + (instant - RealTime{}) + by, i.end + (instant - RealTime{}) + by};
        };
        segment.index = std::ssize(other);
        segment.begin = segment.begin + (instant - RealTime{}) + by;
        segment.end = segment.end + (instant - RealTime{}) + by;
        if (segment.visualization) move(*segment.visualization);
        for (Interval& step : segment.steps) move(step);
        other.push_back(segment);
      }
    }
    if (shares && grid_period(source) != grid_period(other)) continue;
    const std::vector<Interval> a = steps_of(governed_replay(source, governor)),
                                b = steps_of(governed_replay(other, governor));
    for (std::size_t n = 0; n < std::min(a.size(), b.size()) && std::min(a[n].begin, b[n].begin) < instant; ++n) {
      wrong += a[n].begin != b[n].begin;
      ++compared;
    }
  }
  CHECK(wrong == 0);
  CHECK(compared > evenstep::testing::cases(500'000));
}

TEST_CASE("a governor that spreads a recording forgets what came before its last eight segments", "[governor][spread]") {
  // From the first segment on that waits for its turn, and has eight before it, in both: one governor has seen 16 more.
  constexpr std::size_t kPast = 16, kLearnedFrom = 8;
  std::int64_t wrong = 0, compared = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(5'000); ++seed) {
    const FrameGovernor governor{.split = 1 + static_cast<int>(seed % 3), .spread = true};
    const std::vector<SegmentTiming> all = paced_schedule(seed, false, seed % 31, 36).segments,
                                     last(all.begin() + kPast, all.end());
    const auto old = governed_replay(all, governor), fresh = governed_replay(last, governor);
    // What was made of the segments of the source from number k on, if the first of them waited for its turn.
    const auto from = [](const std::vector<SegmentTiming>& made, const std::vector<SegmentTiming>& source, std::size_t k) {
      std::vector<SegmentTiming> out;
      std::size_t before = 0;
      for (std::size_t i = 0; i < k; ++i) before += source[i].steps.size();
      for (const SegmentTiming& segment : made) {
        if (before == 0 && segment.begin >= source[k].begin) out.push_back(segment);
        before -= std::min(before, segment.steps.size());
      }
      if (out.front().begin != source[k].begin) out.clear();
      for (SegmentTiming& segment : out) segment.index = 0;
      return out;
    };
    std::vector<SegmentTiming> is, expected;
    for (std::size_t k = kLearnedFrom; k < last.size() && (is.empty() || expected.empty()); ++k) {
      if (last[k].begin < last[k - 1].end + Duration{kMs}) continue;  // the source did not wait, so its turn was before it
      is = from(old, all, kPast + k), expected = from(fresh, last, k);
    }
    if (is.empty() || expected.empty()) continue;
    wrong += digest_of(is) != digest_of(expected);
    compared += std::ssize(is);
  }
  CHECK(wrong == 0);
  CHECK(compared > evenstep::testing::cases(50'000));
}

TEST_CASE("a source that runs freely is not spread", "[governor][spread]") {
  const auto source = free_running({20, 20, 20, 4, 4, 4, 25, 4, 4, 11, 4, 3, 9});
  CHECK(digest_of(governed_replay(source, {.spread = true})) == digest_of(source));
  CHECK(digest_of(governed(source, {.spread = true})) == digest_of(source));
}

TEST_CASE("what is spread already stays as it is", "[governor][spread]") {
  std::int64_t different = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(kSchedules); ++seed) {
    const auto [period, source] = paced_schedule(seed, true);
    const auto once = governed(source, {.spread = true}, period);
    different += digest_of(governed(once, {.spread = true}, period)) != digest_of(once);
  }
  CHECK(different == 0);
}

TEST_CASE("a recording is spread from its second segment on, over what was usual", "[governor][spread]") {
  std::vector<SegmentTiming> source;
  for (int k = 0; k < 4; ++k) {
    const RealTime at{k * 40 * kMs};
    SegmentTiming segment{k, at, Interval{at, at + Duration{2 * kMs}}, {}, at + Duration{6 * kMs}};
    for (int i = 0; i < (k == 2 ? 6 : 4); ++i)
      segment.steps.push_back({at + Duration{(2 + i) * kMs}, at + Duration{(3 + i) * kMs}});
    source.push_back(segment);
  }
  std::vector<std::vector<std::int64_t>> begins;
  for (const SegmentTiming& segment : governed_replay(source, {.spread = true})) {
    begins.emplace_back();
    for (const Interval& step : segment.steps) begins.back().push_back((step.begin - segment.begin).ns / kMs);
  }
  CHECK(begins ==
        std::vector<std::vector<std::int64_t>>{{2, 3, 4, 5}, {2, 10, 20, 30}, {2, 10, 20, 30, 31, 32}, {2, 6, 13, 20}});
}

TEST_CASE("spread with a pace keeps to the pace, and split parts keep their turns", "[governor][spread]") {
  const auto source = free_running({4, 4, 4});  // segments of 8 ms
  const auto paced = governed(source, {.split = 2, .pace = Duration{40 * kMs}, .spread = true});
  std::vector<std::int64_t> begins;
  for (const Interval& step : steps_of(paced)) begins.push_back(step.begin.ns / kMs);
  CHECK(begins == std::vector<std::int64_t>{2, 10, 22, 30, 42, 50, 62, 70, 82, 90, 102, 110});
}
