// The governor of visualizations: what it may draw in a pause, that it loses and changes no step, and that it does not know
// the future.
#include "evenstep/scheduler/frame_governor.h"
#include "cases.h"

#include <numeric>

#include "evenstep/scheduler/random.h"
#include "timing_checks.h"

using namespace evenstep;

namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::uint64_t kSchedules = 2'000;

/// A schedule of 40 arbitrary segments: 0 to 20 steps, drawings of up to 50 ms or none, gaps, free-running or on a grid of
/// 40 ms, drawings before or after the steps.
std::vector<SegmentTiming> any_schedule(std::uint64_t seed) {
  const RandomStream random(seed, "governor.test");
  std::uint64_t draw = 0;
  const auto below = [&](std::uint64_t bound) { return static_cast<std::int64_t>(random.below(draw++, bound)); };
  const bool grid = below(2) == 0, steps_first = below(3) == 0;
  std::vector<SegmentTiming> out;
  RealTime at{below(kMs)};
  const RealTime origin = at;
  for (std::int64_t k = 0; k < 40; ++k) {
    if (grid) at = std::max(at, origin + Duration{k * 40 * kMs});
    SegmentTiming segment;
    segment.index = k;
    segment.begin = at;
    const auto draws = [&] {
      if (below(8) == 0) return;
      segment.visualization = Interval{at, at + Duration{1 + below(below(6) == 0 ? 50 * kMs : 12 * kMs)}};
      at = segment.visualization->end;
    };
    if (!steps_first) draws();
    for (std::int64_t i = below(21); i > 0; --i) {
      at = at + Duration{segment.steps.empty() && !segment.visualization ? 0 : below(1000)};
      segment.steps.push_back({at, at + Duration{1 + below(3 * kMs)}});
      at = segment.steps.back().end;
    }
    if (steps_first) draws();
    segment.end = at;
    at = at + Duration{1 + below(1000)};
    out.push_back(segment);
  }
  return out;
}

std::vector<SegmentTiming> governed(const std::vector<SegmentTiming>& source, const FrameGovernor& governor,
                                    std::optional<Duration> grid = {}) {
  const auto timing = make_governed_timing(make_replayed_timing(source), governor, grid);
  std::vector<SegmentTiming> out;
  for (SegmentTiming segment; timing->next(segment);) out.push_back(segment);
  return out;
}

FrameGovernor any_governor(std::uint64_t seed) {
  const RandomStream random(seed, "governor.kind");
  FrameGovernor governor;
  if (random.below(0, 2) == 0) governor.split = 1 + static_cast<int>(random.below(1, 6));
  if (random.below(2, 4) > 0) governor.budget = Duration{1 + static_cast<std::int64_t>(random.below(3, 20 * kMs))};
  governor.over_budget = static_cast<OverBudget>(random.below(4, 3));
  governor.forecast = static_cast<int>(random.below(5, 4));
  if (random.below(6, 3) == 0) governor.pace = Duration{1 + static_cast<std::int64_t>(random.below(7, 60 * kMs))};
  governor.spread = random.below(8, 2) == 0;
  return governor;
}

std::optional<Duration> any_grid(std::uint64_t seed) {
  return RandomStream(seed, "governor.grid").below(0, 2) == 0 ? std::optional(Duration{40 * kMs}) : std::nullopt;
}

std::vector<SegmentTiming> governed_replay(const std::vector<SegmentTiming>& recording, const FrameGovernor& governor) {
  const auto timing = make_governed_replay(recording, governor);
  std::vector<SegmentTiming> out;
  for (SegmentTiming segment; timing->next(segment);) out.push_back(segment);
  return out;
}

std::vector<Interval> steps_of(const std::vector<SegmentTiming>& segments) {
  std::vector<Interval> out;
  for (const SegmentTiming& segment : segments) out.insert(out.end(), segment.steps.begin(), segment.steps.end());
  return out;
}

/// What a simulator with a timer of `period` does: `segments` segments of 1 to 20 steps (all the same number, or any), which
/// wait for their turn or begin late. Drawings take their share of the period, and one in ten up to two periods more. `fit`:
/// no step is longer than its slot; otherwise one in a hundred takes up to a period. `jitter`: of the turns, in 1/1000.
struct Paced {
  Duration period;
  std::vector<SegmentTiming> segments;
};
Paced paced_schedule(std::uint64_t seed, bool fit, std::uint64_t jitter = 0, std::int64_t segments = 12) {
  const RandomStream random(seed, "governor.spread");
  std::uint64_t draw = 0;
  const auto below = [&](std::int64_t bound) {
    return static_cast<std::int64_t>(random.below(draw++, static_cast<std::uint64_t>(bound)));
  };
  Paced out{Duration{8 * kMs + below(32 * kMs)}, {}};
  const std::int64_t period = out.period.ns, most = 1 + below(20), share = 1 + below(90), drawing = below(60);
  const bool varies = below(2) == 0;
  RealTime busy;
  for (std::int64_t k = 0; k < segments; ++k) {
    const std::int64_t off = jitter > 0 ? below(period * static_cast<std::int64_t>(jitter) / 1000 + 1) : 0;
    SegmentTiming segment;
    segment.index = k;
    segment.begin = std::max(busy, RealTime{k * period + off});
    RealTime at = segment.begin;
    if (const std::int64_t length = period * drawing / 100 + (below(10) == 0 ? below(2 * period) : 0); length > 0) {
      segment.visualization = Interval{at, at + Duration{length}};
      at = segment.visualization->end;
    }
    const std::int64_t steps = varies ? 1 + below(most) : most;
    for (std::int64_t i = 0; i < steps; ++i) {
      const bool hit = !fit && below(100) == 0;
      const Duration run_time{1 + below(hit ? period : std::max<std::int64_t>(period * share / 100 / steps, 1))};
      segment.steps.push_back({at, at + run_time});
      at = at + run_time;
    }
    segment.end = busy = at;
    out.segments.push_back(segment);
  }
  return out;
}

std::int64_t drawn_ns(const std::vector<SegmentTiming>& segments) {
  std::int64_t sum = 0;
  for (const Duration length : visualization_durations(segments)) sum += length.ns;
  return sum;
}

Duration longest_pause(const std::vector<SegmentTiming>& segments) {
  Duration longest;
  for (const Duration length : visualization_durations(segments)) longest = std::max(longest, length);
  return longest;
}

std::int64_t left_out(const std::vector<SegmentTiming>& segments) {
  return std::count_if(segments.begin(), segments.end(), [](const SegmentTiming& s) { return s.drawing.left_out; });
}

std::int64_t finished(const std::vector<SegmentTiming>& segments) {
  return std::count_if(segments.begin(), segments.end(),
                       [](const SegmentTiming& s) { return s.visualization && s.drawing.finishes; });
}

std::int64_t drawings(const std::vector<SegmentTiming>& segments) {
  return static_cast<std::int64_t>(visualization_durations(segments).size());
}

/// The number of things that are not in the order of time.
std::int64_t out_of_order(const std::vector<SegmentTiming>& segments) {
  std::int64_t wrong = 0;
  RealTime last = segments.front().begin;
  for (std::size_t k = 0; k < segments.size(); ++k) {
    const SegmentTiming& segment = segments[k];
    wrong += segment.index != static_cast<std::int64_t>(k) || segment.begin < last || segment.overlaps();
    last = segment.begin;
    std::vector<Interval> pieces = segment.steps;
    if (segment.visualization) {
      const bool first = pieces.empty() || segment.visualization->begin <= pieces.front().begin;
      pieces.insert(first ? pieces.begin() : pieces.end(), *segment.visualization);
    }
    for (const Interval& piece : pieces) {
      wrong += piece.begin < last || piece.end < piece.begin;
      last = piece.end;
    }
    wrong += segment.end < last;
  }
  return wrong;
}

/// Visualizations of these lengths, each followed by 4 steps of 1 ms, without gaps.
std::vector<SegmentTiming> free_running(const std::vector<std::int64_t>& visualizations_ms) {
  std::vector<SegmentTiming> out;
  RealTime at;
  for (const std::int64_t visualization : visualizations_ms) {
    SegmentTiming segment;
    segment.index = std::ssize(out);
    segment.begin = at;
    segment.visualization = Interval{at, at + Duration{visualization * kMs}};
    at = segment.visualization->end;
    for (int i = 0; i < 4; ++i, at = at + Duration{kMs}) segment.steps.push_back({at, at + Duration{kMs}});
    segment.end = at;
    out.push_back(segment);
  }
  return out;
}

std::vector<std::int64_t> pauses_ms(const std::vector<SegmentTiming>& segments) {
  std::vector<std::int64_t> out;
  for (const SegmentTiming& segment : segments)
    out.push_back(segment.visualization ? length(*segment.visualization).ns / kMs : 0);
  return out;
}

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

TEST_CASE("a governor that is asked for nothing gives any schedule back as it was", "[governor]") {
  std::int64_t different = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(kSchedules); ++seed) {
    const auto source = any_schedule(seed);
    std::vector<SegmentTiming> same = governed(source, {}, any_grid(seed));
    std::vector<SegmentTiming> expected;
    for (const SegmentTiming& segment : source) {
      if (segment.visualization || !segment.steps.empty()) expected.push_back(segment);
    }
    for (std::size_t k = 0; k < expected.size(); ++k) expected[k].index = static_cast<std::int64_t>(k);
    different += digest_of(same) != digest_of(expected);
  }
  CHECK(different == 0);
}

TEST_CASE("a governor loses, changes and overlaps no step of any schedule", "[governor]") {
  std::int64_t wrong = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(kSchedules); ++seed) {
    const auto source = any_schedule(seed);
    const auto after = governed(source, any_governor(seed), any_grid(seed));
    wrong += step_durations(after) != step_durations(source) || out_of_order(after) > 0;
  }
  CHECK(wrong == 0);
}

TEST_CASE("where a drawing can be cut off no pause of any schedule is over the budget", "[governor]") {
  std::int64_t over = 0, kept_over = 0, reached = 0, unaccounted = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(kSchedules); ++seed) {
    const auto source = any_schedule(seed);
    FrameGovernor governor = any_governor(seed);
    governor.over_budget = OverBudget::merge;
    const auto after = governed(source, governor, any_grid(seed));
    if (!governor.budget) continue;
    over += longest_pause(after) > *governor.budget;
    for (const SegmentTiming& segment : after) {
      const bool pause_first =
          segment.visualization && !segment.steps.empty() && segment.visualization->begin < segment.steps.front().begin;
      // Gaps of the source, at most 1 us each, do not belong to the pause.
      kept_over += pause_first && segment.steps.front().begin - segment.begin > *governor.budget + Duration{1000};
    }
    reached += longest_pause(after) == *governor.budget;
    // Each drawing of the source is finished, merged into the one before, or unfinished at the end.
    const std::int64_t open = drawings(source) - finished(after) - left_out(after);
    unaccounted += open != 0 && open != 1;
  }
  CHECK(over == 0);
  CHECK(kept_over == 0);
  CHECK(reached > evenstep::testing::cases(600));  // otherwise the budgets were never tight
  CHECK(unaccounted == 0);
}

TEST_CASE("a drawing in parts takes as long as it did in one, and no part more than its share", "[governor]") {
  std::int64_t wrong = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(kSchedules); ++seed) {
    const auto source = any_schedule(seed);
    FrameGovernor governor;
    governor.split = 1 + static_cast<int>(seed % 7);
    const auto after = governed(source, governor, any_grid(seed));
    wrong += drawn_ns(after) != drawn_ns(source) || finished(after) != drawings(source) || left_out(after) != 0;
    wrong += longest_pause(after).ns > (longest_pause(source).ns + governor.split - 1) / governor.split;
  }
  CHECK(wrong == 0);
}

TEST_CASE("a governor that knows how long drawings take makes none that is over its budget", "[governor]") {
  std::int64_t wrong = 0, left = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(kSchedules); ++seed) {
    FrameGovernor governor = any_governor(seed);
    if (governor.over_budget == OverBudget::merge || !governor.budget) continue;
    governor.forecast = 0;
    const auto source = any_schedule(seed);
    const auto after = governed(source, governor, any_grid(seed));
    wrong += longest_pause(after) > *governor.budget || left_out(after) + finished(after) != drawings(source);
    left += left_out(after);
  }
  CHECK(wrong == 0);
  CHECK(left > evenstep::testing::cases(5000));
}

TEST_CASE("a governor leaves out no more drawings in a row than it looks back", "[governor]") {
  std::int64_t wrong = 0, most_seen = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(kSchedules); ++seed) {
    FrameGovernor governor = any_governor(seed);
    if (governor.over_budget == OverBudget::merge || governor.forecast == 0) continue;
    std::int64_t in_a_row = 0;
    for (const SegmentTiming& segment : governed(any_schedule(seed), governor, any_grid(seed))) {
      if (segment.visualization) in_a_row = 0;
      if (segment.drawing.left_out) ++in_a_row;
      wrong += in_a_row > governor.forecast;
      most_seen = std::max(most_seen, in_a_row);
    }
  }
  CHECK(wrong == 0);
  CHECK(most_seen == 3);  // any_governor looks back by 3 at most
}

TEST_CASE("what a governor did so far does not depend on what comes", "[governor]") {
  std::int64_t wrong = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(kSchedules); ++seed) {
    FrameGovernor governor = any_governor(seed);
    governor.forecast = std::max(governor.forecast, 1);
    std::vector<SegmentTiming> source = any_schedule(seed), other = source;
    const std::size_t from = 20;
    for (std::size_t k = from; k < other.size(); ++k) {  // from there on everything takes three times as long
      SegmentTiming& segment = other[k];
      const RealTime origin = other[from].begin;
      const auto stretch = [&](Interval& i) { i = {origin + (i.begin - origin) * 3, origin + (i.end - origin) * 3}; };
      if (segment.visualization) stretch(*segment.visualization);
      for (Interval& step : segment.steps) stretch(step);
      if (k > from) segment.begin = origin + (segment.begin - origin) * 3;
      segment.end = origin + (segment.end - origin) * 3;
    }
    const auto a = governed(source, governor, any_grid(seed)), b = governed(other, governor, any_grid(seed));
    source.resize(from);
    const std::size_t same = governed(source, governor, any_grid(seed)).size();
    for (std::size_t k = 0; k < same; ++k) wrong += digest_of({a.at(k)}) != digest_of({b.at(k)});
  }
  CHECK(wrong == 0);
}

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

TEST_CASE("what spread did with a recording up to an instant is the same whatever comes after", "[governor][spread]") {
  std::int64_t wrong = 0, compared = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(20'000); ++seed) {
    const FrameGovernor governor{.spread = true};
    const std::vector<SegmentTiming> source = paced_schedule(seed, false, seed % 31).segments;
    std::vector<SegmentTiming> other = source;
    // From step `at` of segment `from` on everything is another recording's, later by a time that is drawn; or nothing
    // comes any more.
    const std::size_t from = 3 + seed % 8, at = seed % (source[from].steps.size() + 1);
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

TEST_CASE("the rest of a drawing over its budget takes the place of the next ones", "[governor]") {
  FrameGovernor governor;
  governor.budget = Duration{10 * kMs};
  const auto after = governed(free_running({4, 25, 4, 4, 4}), governor);
  CHECK(pauses_ms(after) == std::vector<std::int64_t>{4, 10, 10, 5, 4});
  CHECK(left_out(after) == 2);
  CHECK(finished(after) == 3);
  CHECK(after[3].steps.front().begin - after[3].begin == Duration{10 * kMs});  // 5 ms of rest instead of the usual 14.5 ms
  CHECK(after.back().end == RealTime{(4 + 10 + 10 + 10 + 4 + 20) * kMs});
}

TEST_CASE("a drawing that is skipped lets the steps follow at once, one that is held keeps their place", "[governor]") {
  FrameGovernor governor{.budget = Duration{10 * kMs}, .over_budget = OverBudget::skip, .forecast = 0};
  const auto source = free_running({4, 25, 4, 25, 6});
  const auto skipped = governed(source, governor);
  CHECK(pauses_ms(skipped) == std::vector<std::int64_t>{4, 0, 4, 0, 6});
  CHECK(skipped[1].steps.front().begin == skipped[1].begin);
  governor.over_budget = OverBudget::hold;
  const auto held = governed(source, governor);
  CHECK(pauses_ms(held) == pauses_ms(skipped));
  for (const std::size_t k : {1, 3}) CHECK(held[k].steps.front().begin - held[k].begin == Duration{4 * kMs});
}

TEST_CASE("a held pause is as long as the mean of the last eight parts that were drawn, and no older one", "[governor]") {
  const FrameGovernor governor{.budget = Duration{10 * kMs}, .over_budget = OverBudget::hold, .forecast = 0};
  const auto held = governed(free_running({9, 2, 2, 2, 2, 2, 4, 4, 4, 25, 4}), governor);
  CHECK(held[9].steps.front().begin - held[9].begin == Duration{(5 * 2 + 3 * 4) * kMs / 8});
}

TEST_CASE("a forecast is late by one drawing, and tries again after as many as it looks back", "[governor]") {
  FrameGovernor governor{.budget = Duration{10 * kMs}, .over_budget = OverBudget::skip, .forecast = 2};
  const auto after = governed(free_running({4, 25, 25, 25, 25, 4, 4, 4, 4}), governor);
  CHECK(pauses_ms(after) == std::vector<std::int64_t>{4, 25, 0, 0, 25, 0, 0, 4, 4});
}

TEST_CASE("drawings that really run are budgeted by what they took", "[governor]") {
  const auto source = free_running({4, 4, 4, 4, 4, 4});
  SegmentTiming segment;
  SECTION("a forecast believes the clock") {
    const auto timing = make_governed_timing(
        make_replayed_timing(source), {.budget = Duration{10 * kMs}, .over_budget = OverBudget::skip, .forecast = 1}, {});
    REQUIRE(timing->next(segment));
    timing->visualized(Duration{30 * kMs}, true);
    REQUIRE(timing->next(segment));
    CHECK(segment.drawing.left_out);
  }
  SECTION("a drawing that is not finished goes on") {
    const auto timing = make_governed_timing(make_replayed_timing(source), {.budget = Duration{10 * kMs}}, {});
    REQUIRE(timing->next(segment));
    CHECK(segment.drawing.at_most == Duration{10 * kMs});
    timing->visualized(Duration{10 * kMs}, false);
    REQUIRE(timing->next(segment));
    CHECK(segment.drawing.left_out);
    CHECK(segment.visualization);
    timing->visualized(Duration{3 * kMs}, true);
    REQUIRE(timing->next(segment));
    CHECK_FALSE(segment.drawing.left_out);
  }
}

TEST_CASE("a source on a grid shares out its idle time between the parts", "[governor]") {
  std::vector<SegmentTiming> source;
  for (int k = 0; k < 5; ++k) {
    const RealTime at{k * 40 * kMs};
    SegmentTiming segment{k, at, Interval{at, at + Duration{8 * kMs}}, {}, at + Duration{10 * kMs}};
    for (int i = 0; i < 2; ++i) segment.steps.push_back({at + Duration{(8 + i) * kMs}, at + Duration{(9 + i) * kMs}});
    source.push_back(segment);
  }
  CHECK(grid_period(source) == Duration{40 * kMs});
  FrameGovernor governor;
  governor.split = 2;
  const auto after = governed(source, governor, grid_period(source));
  REQUIRE(after.size() == 10);
  for (std::size_t k = 0; k < 10; ++k) {
    CHECK(after[k].begin == RealTime{static_cast<std::int64_t>(k) * 20 * kMs});
    CHECK(after[k].steps.front().begin - after[k].begin == Duration{4 * kMs});
  }
}

TEST_CASE("paced segments begin on their grid or when the one before is over", "[governor]") {
  FrameGovernor governor;
  governor.pace = Duration{20 * kMs};
  const auto after = governed(free_running({4, 25, 4, 4, 4}), governor);
  std::vector<std::int64_t> begins;
  for (const SegmentTiming& segment : after) begins.push_back(segment.begin.ns / kMs);
  CHECK(begins == std::vector<std::int64_t>{0, 20, 49, 60, 80});
}
