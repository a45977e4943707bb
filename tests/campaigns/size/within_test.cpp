// Sizes for every schedule within bounds: no schedule exceeds them, and one reaches them.
#include "src/schedules/within.h"

#include <algorithm>

#include "traces.h"

using namespace evenstep;
using namespace evenstep::internal;
using namespace evenstep::testing;
using Catch::Contains;

namespace {

struct Pieces {
  Duration drawing;
  std::vector<Duration> steps;
};

std::vector<SegmentTiming> back_to_back(const std::vector<Pieces>& pieces) {
  std::vector<SegmentTiming> out;
  RealTime at;
  const auto take = [&](Duration length) {
    const Interval time{at, at + length};
    at = time.end;
    return time;
  };
  for (const Pieces& one : pieces) {
    SegmentTiming segment;
    segment.index = std::ssize(out);
    segment.begin = at;
    const Interval drawing = take(one.drawing);
    if (one.drawing.ns > 0) segment.visualization = drawing;
    for (const Duration step : one.steps) segment.steps.push_back(take(step));
    segment.end = at;
    out.push_back(std::move(segment));
  }
  return out;
}

/// What a schedule needs at any phase of a device of 1 kHz, as `size` counts it.
LatencyBudget needs_of(const std::vector<SegmentTiming>& segments, StrategyKind map, Emission emission,
                       Rate step_rate = {450, 1}) {
  MapSetup setup;
  setup.grids.push_back({Rate{1000, 1}, RealTime{}});
  setup.emission = emission;
  setup.step_rate = step_rate;
  setup.end = segments.back().end + Duration{1};
  RunningNeeds needs(setup.grids, emission, RunningNeeds::Phase::any);
  each_mapped_step(setup, map, segments, [&](std::span<const MappedStep> steps) { needs.add(steps); });
  return needs.budget();
}

/// The rings that a schedule needs with this lead and latency.
LatencyBudget rings_of(const std::vector<SegmentTiming>& segments, StrategyKind map, Duration lead, Duration latency,
                       Rate step_rate = {450, 1}) {
  MapSetup setup;
  setup.grids.push_back({Rate{1000, 1}, RealTime{}});
  setup.step_rate = step_rate;
  setup.end = segments.back().end + Duration{1};
  RunningCapacities rings(setup.grids, lead, latency);
  each_mapped_step(setup, map, segments, [&](std::span<const MappedStep> steps) { rings.add(steps); });
  return rings.budget();
}

SizeWithin::Map row(const SizeWithin& within, StrategyKind map) {
  const auto found =
      std::find_if(within.maps.begin(), within.maps.end(), [&](const auto& one) { return one.name == name_of(map); });
  REQUIRE(found != within.maps.end());
  return *found;
}

/// Draws lengths, every second one at a bound.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : random_(seed, "within.test") {}
  std::int64_t between(std::int64_t least, std::int64_t most) {
    const std::uint64_t how = random_.below(draw_++, 4);
    const std::uint64_t free = random_.below(draw_++, static_cast<std::uint64_t>(most - least) + 1);
    return how == 0 ? least : how == 1 ? most : least + static_cast<std::int64_t>(free);
  }
  Duration in(const SizeRange& range) { return {between(range.least.ns, range.most.ns)}; }

 private:
  RandomStream random_;
  std::uint64_t draw_ = 0;
};

/// Bounds with nothing in common but that they are possible; some have no drawing, or a single value.
WithinBounds random_bounds(Draws& draws) {
  const auto range = [&](std::int64_t least, std::int64_t most) {
    const std::int64_t one = draws.between(least, most), other = draws.between(least, most);
    return SizeRange{{std::min(one, other)}, {std::max(one, other)}};
  };
  WithinBounds bounds{.visualization = range(0, 20 * ms), .step = range(ms / 10, 4 * ms)};
  const SizeRange steps = range(1, 20);
  bounds.steps = SizeCounts{steps.least.ns, steps.most.ns};
  return bounds;
}

std::vector<SegmentTiming> random_schedule(const WithinBounds& bounds, Draws& draws, std::size_t segments) {
  std::vector<Pieces> pieces(segments);
  for (Pieces& one : pieces) {
    one.drawing = draws.in(bounds.visualization);
    one.steps.resize(static_cast<std::size_t>(draws.between(bounds.steps->least, bounds.steps->most)));
    const Duration usual = draws.in(bounds.step);
    const bool even = draws.between(0, 1) == 0;
    for (Duration& step : one.steps) step = even ? usual : draws.in(bounds.step);
  }
  return back_to_back(pieces);
}

/// A loop that runs the steps that are due when a frame begins (accumulator), written anew from that sentence.
class ClockedLoop {
 public:
  explicit ClockedLoop(std::int64_t step_ns) : step_ns_(step_ns) {}
  std::int64_t at_ns() const { return at_ns_; }
  std::int64_t due() const { return at_ns_ / step_ns_ - done_; }
  template <class Step>
  void frame(Duration drawing, Step step) {
    Pieces one{drawing, {}};
    const std::int64_t steps = due();
    at_ns_ += drawing.ns;
    for (std::int64_t i = 0; i < steps; ++i) {
      one.steps.push_back(step());
      at_ns_ += one.steps.back().ns;
    }
    done_ += steps;
    frames_.push_back(std::move(one));
  }
  /// Frames until one ends so long after a step is due.
  void frames_until(std::int64_t after_ns, const WithinBounds& bounds) {
    const auto step = [&] { return bounds.step.least; };
    for (int tries = 0; tries < 1000; ++tries) {
      const std::int64_t soonest_ns = at_ns_ + due() * bounds.step.least.ns + bounds.visualization.least.ns;
      const std::int64_t end_ns = ((soonest_ns - after_ns + step_ns_ - 1) / step_ns_) * step_ns_ + after_ns;
      const Duration drawing = bounds.visualization.least + Duration{end_ns - soonest_ns};
      if (drawing <= bounds.visualization.most) return frame(drawing, step);
      frame(bounds.visualization.least, step);
    }
    FAIL("no frame ends there");
  }
  std::vector<SegmentTiming> segments() const { return back_to_back(frames_); }

 private:
  std::int64_t step_ns_, at_ns_ = 0, done_ = 0;
  std::vector<Pieces> frames_;
};

/// None of so many random schedules of random bounds needs more than what is enough for all; returns how near they came.
double most_needed(std::int64_t schedules, std::uint64_t seed) {
  constexpr std::int64_t kPerBounds = 100;
  double nearest = 0;
  for (std::int64_t round = 0; round < schedules / kPerBounds; ++round) {
    Draws draws(seed + static_cast<std::uint64_t>(round));
    const WithinBounds bounds = random_bounds(draws);
    for (std::int64_t i = 0; i < kPerBounds; ++i) {
      const auto segments = random_schedule(bounds, draws, 4 + static_cast<std::size_t>(draws.between(0, 12)));
      for (const Emission emission : {Emission::hold, Emission::linear}) {
        const auto judge = [&](StrategyKind map, const WithinNeeds& enough) {
          const LatencyBudget needs = needs_of(segments, map, emission);
          const Duration early = needs.lead - Duration{ms - 1}, late = needs.latency - needs.lead;
          if (early > enough.early || late > enough.late)
            FAIL_CHECK(name_of(map) << " in round " << round << ": " << early.ns << " > " << enough.early.ns << " or "
                                    << late.ns << " > " << enough.late.ns);
          nearest = std::max(nearest,
                             static_cast<double>((early + late).ns) / static_cast<double>((enough.early + enough.late).ns));
        };
        judge(StrategyKind::linear, linear_within(bounds, emission));
        judge(StrategyKind::paper, paper_within(bounds, emission));
      }
    }
  }
  return nearest;
}

/// The same of rings, with the lead and the latency that are enough for all.
void most_rings(std::int64_t schedules, std::uint64_t seed) {
  constexpr std::int64_t kPerBounds = 100;
  for (std::int64_t round = 0; round < schedules / kPerBounds; ++round) {
    Draws draws(seed + static_cast<std::uint64_t>(round));
    const WithinBounds bounds = random_bounds(draws);
    const Emission emission = round % 2 == 0 ? Emission::hold : Emission::linear;
    for (std::int64_t i = 0; i < kPerBounds; ++i) {
      const auto segments = random_schedule(bounds, draws, 4 + static_cast<std::size_t>(draws.between(0, 12)));
      const auto judge = [&](StrategyKind map, const WithinNeeds& needs) {
        const Duration lead = needs.early + Duration{ms - 1};
        const LatencyBudget rings = rings_of(segments, map, lead, lead + needs.late);
        // A device of 1 kHz has at most ceil(t / 1 ms) samples in a time t.
        const auto samples = static_cast<std::size_t>(((needs.behind + lead).ns + ms - 1) / ms);
        INFO(name_of(map) << " in round " << round);
        REQUIRE(rings.interaction_capacity <= samples + 2);
        REQUIRE(std::cmp_less_equal(rings.force_capacity, waiting_within(bounds, needs) + 2));
      };
      judge(StrategyKind::linear, linear_within(bounds, emission));
      judge(StrategyKind::paper, paper_within(bounds, emission));
    }
  }
}

/// The same for loops that follow a clock.
double most_clocked(std::int64_t schedules, std::uint64_t seed) {
  constexpr std::int64_t kPerBounds = 100;
  double nearest = 0;
  for (std::int64_t round = 0; round < schedules / kPerBounds; ++round) {
    Draws draws(seed + static_cast<std::uint64_t>(round));
    WithinBounds bounds = random_bounds(draws);
    bounds.steps.reset();
    bounds.visualization.least = std::max(bounds.visualization.least, Duration{ms / 2});
    bounds.visualization.most = std::max(bounds.visualization.most, bounds.visualization.least);
    const std::int64_t step_ns = 1'000'000'000 / draws.between(20, 250);
    const Rate step_rate{1'000'000'000, step_ns};
    bounds.step.most = std::min(bounds.step.most, Duration{9 * step_ns / 10});
    bounds.step.least = std::min(bounds.step.least, bounds.step.most);
    for (std::int64_t i = 0; i < kPerBounds; ++i) {
      ClockedLoop loop(step_ns);
      for (int k = 0; k < 40; ++k) {
        // Some drawings end where a step is due, or 1 ns before.
        const std::int64_t due_ns = (loop.at_ns() / step_ns + draws.between(1, 3)) * step_ns - draws.between(0, 1);
        const Duration until_due{due_ns - loop.at_ns()}, drawn = draws.in(bounds.visualization);
        const bool fits = until_due >= bounds.visualization.least && until_due <= bounds.visualization.most;
        loop.frame(fits && draws.between(0, 2) == 0 ? until_due : drawn, [&] { return draws.in(bounds.step); });
      }
      const std::vector<SegmentTiming> segments = loop.segments();
      if (std::all_of(segments.begin(), segments.end(), [](const auto& one) { return one.steps.empty(); })) continue;
      for (const Emission emission : {Emission::hold, Emission::linear}) {
        const LatencyBudget needs = needs_of(segments, StrategyKind::clocked, emission, step_rate);
        const WithinNeeds enough = clocked_within(bounds, step_rate, emission);
        const Duration early = needs.lead - Duration{ms - 1}, late = needs.latency - needs.lead;
        if (early > enough.early || late > enough.late)
          FAIL_CHECK("in round " << round << ": " << early.ns << " > " << enough.early.ns << " or " << late.ns << " > "
                                 << enough.late.ns);
        nearest = std::max({nearest, static_cast<double>(early.ns) / static_cast<double>(enough.early.ns),
                            static_cast<double>(late.ns) / static_cast<double>(enough.late.ns)});
        const SizeWithin::Map all = (*size_within(bounds, {.emission = emission, .step_size = step_rate})).maps.front();
        const LatencyBudget rings = rings_of(segments, StrategyKind::clocked, all.lead, all.latency, step_rate);
        REQUIRE(rings.interaction_capacity <= all.interaction_capacity);
        REQUIRE(rings.force_capacity <= all.force_capacity);
      }
    }
  }
  return nearest;
}

}  // namespace

TEST_CASE("no schedule within its bounds needs more than the size that is enough for all") {
  CHECK(most_needed(10'000, 0) > 0.9);
  CHECK(most_clocked(10'000, 0) > 0.9);
}

TEST_CASE("no schedule within its bounds overruns the rings that are enough for all") { most_rings(10'000, 0); }

TEST_CASE("none of a million schedules needs more than the size that is enough for all", "[million]") {
  CHECK(most_needed(500'000, 1'000'000) > 0.9);
  CHECK(most_clocked(500'000, 1'000'000) > 0.9);
}

TEST_CASE("one schedule within its bounds needs the whole size that is enough for all") {
  for (const char* text : {"visualization 9 ms .. 14 ms, step 1.2 ms .. 1.9 ms, steps 15",
                           "visualization 9 ms .. 14 ms, step 1.2 ms .. 1.3 ms, steps 10 .. 20",
                           "visualization 8 ms, step 1.5 ms .. 1.6 ms, steps 16",
                           "visualization 0 ms, step 1 ms .. 2 ms, steps 1 .. 3", "step 2 ms .. 3 ms, steps 4"}) {
    const WithinBounds bounds = *parse_within(text);
    const auto segment = [&](bool drawing, bool step, bool steps) {
      return Pieces{drawing ? bounds.visualization.most : bounds.visualization.least,
                    std::vector<Duration>(static_cast<std::size_t>(steps ? bounds.steps->most : bounds.steps->least),
                                          step ? bounds.step.most : bounds.step.least)};
    };
    // One that sets the slowest pace and a quick one; then so many quick ones that the average forgets all else, and long
    // ones.
    std::vector<Pieces> pieces{segment(true, true, false), segment(false, false, true)};
    for (int i = 0; i < 400; ++i) pieces.push_back(segment(false, false, true));
    for (const bool steps : {true, false}) {
      pieces.push_back(segment(true, true, steps));
      pieces.push_back(segment(true, true, steps));
      for (int i = 0; i < 400; ++i) pieces.push_back(segment(false, false, true));
    }
    const std::vector<SegmentTiming> segments = back_to_back(pieces);
    for (const Emission emission : {Emission::hold, Emission::linear}) {
      const SizeWithin within = *size_within(bounds, {.emission = emission});
      for (const StrategyKind map : {StrategyKind::linear, StrategyKind::paper}) {
        const SizeWithin::Map enough = row(within, map);
        const LatencyBudget needs = needs_of(segments, map, emission);
        INFO(text << ", " << enough.name << (emission == Emission::hold ? ", held" : ", interpolated"));
        CHECK(needs.lead == enough.lead);
        CHECK((needs.latency <= enough.latency && enough.latency - needs.latency <= Duration{2}));
        CHECK(enough.how == SizeWithin::How::exact);
        const LatencyBudget rings = rings_of(segments, map, enough.lead, enough.latency);
        CHECK(rings.interaction_capacity == enough.interaction_capacity);
        CHECK(rings.force_capacity <= enough.force_capacity);
        if (map == StrategyKind::linear) CHECK(rings.force_capacity == enough.force_capacity);
      }
    }
  }
}

TEST_CASE("a loop that follows a clock needs the bound of its size where drawings may end at any phase of it") {
  const WithinBounds bounds = *parse_within("visualization 9 ms .. 14 ms, step 1.2 ms .. 1.9 ms");
  const std::int64_t step_ns = 11'100'000;
  const SizeWithin within = *size_within(bounds, {.step_size = Rate{1'000'000'000, step_ns}});
  REQUIRE(within.maps.size() == 1);
  CHECK(within.maps[0].name == "clocked");
  CHECK(within.maps[0].how == SizeWithin::How::bound);
  const Rate step_rate{1'000'000'000, step_ns};
  const auto quick = [&] { return bounds.step.least; };
  const auto slow = [&] { return bounds.step.most; };

  // Step 0 as late as can be: a frame begins 1 ns before it is due, and two long drawings follow. Later a frame begins where
  // its only step is due.
  ClockedLoop early(step_ns);
  early.frame(Duration{step_ns - 1}, quick);
  for (int k = 0; k < 2; ++k) early.frame(bounds.visualization.most, quick);
  do early.frames_until(0, bounds);
  while (early.due() != 1);
  early.frame(bounds.visualization.least, quick);
  CHECK(needs_of(early.segments(), StrategyKind::clocked, Emission::hold, step_rate).lead == within.maps[0].lead);

  // Step 0 as early as can be; later a frame begins 1 ns before a step is due, which two long drawings and a step delay.
  ClockedLoop late(step_ns);
  late.frame(Duration{step_ns}, quick);
  late.frame(bounds.visualization.least, quick);
  do late.frames_until(-1, bounds);
  while (late.due() != 1);
  for (int k = 0; k < 2; ++k) late.frame(bounds.visualization.most, slow);
  const LatencyBudget needs = needs_of(late.segments(), StrategyKind::clocked, Emission::hold, step_rate);
  const Duration bound = within.maps[0].latency - within.maps[0].lead;
  CHECK(needs.latency - needs.lead <= bound);
  CHECK(static_cast<double>((needs.latency - needs.lead).ns) > 0.99 * static_cast<double>(bound.ns));
}

TEST_CASE("no random schedule needs more of phase_locked than the worst one that the search found") {
  const WithinBounds bounds = *parse_within("visualization 9 ms .. 14 ms, step 1.2 ms .. 1.9 ms, steps 10 .. 20");
  const SizeWithin::Map found = row(*size_within(bounds, {}), StrategyKind::phase_locked);
  CHECK(found.how == SizeWithin::How::found);
  CHECK(row(*size_within(bounds, {}), StrategyKind::phase_locked).latency == found.latency);
  Draws draws(7);
  for (int i = 0; i < 2000; ++i) {
    const LatencyBudget needs = needs_of(random_schedule(bounds, draws, 60), StrategyKind::phase_locked, Emission::hold);
    CHECK(needs.lead <= found.lead);
    CHECK(needs.latency - needs.lead <= found.latency - found.lead);
  }
}

TEST_CASE("bounds without a meaning are refused with what would be") {
  for (const char* bad :
       {"", "steps 15", "step 0 ms, steps 15", "step 2 ms .. 1 ms, steps 15", "step 1 ms, steps 0",
        "step 1 ms, steps 2 .. 1001", "step 1 V, steps 3", "drawing 3 ms, step 1 ms", "step 1001 s, steps 1"})
    CHECK_FALSE(parse_within(bad));
  const WithinBounds due = *parse_within("visualization 9 ms, step 1 ms .. 2 ms");
  CHECK_THAT(size_within(due, {}).error(), Contains("either \"steps 15\""));
  CHECK_THAT(size_within(due, {.step_size = Rate{500, 1}}).error(), Contains("does not keep real time"));
  CHECK_THAT(size_within(*parse_within("step 1 ms"), {.step_size = Rate{100, 1}}).error(), Contains("above 0 s"));
  CHECK_FALSE(size_within(*parse_within("step 1 ms, steps 3"), {.step_size = Rate{100, 1}}));
}
