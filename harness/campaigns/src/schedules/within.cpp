#include "within.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "evenstep/scheduler/random.h"
#include "evenstep/text/quantity.h"
#include "src/size/clauses.h"

namespace evenstep {
namespace internal {
namespace {

constexpr std::int64_t kScheduledSteps = 25'000'000, kLeastTries = 100, kMostTries = 4000;
constexpr std::int64_t kLeastScheduled = 40, kMostScheduled = 200;
constexpr Duration kLongEnough{4'000'000'000};  // several times what phase_locked remembers

/// A segment whose lengths are all at a bound: `first` for its first `change` steps, then the other one.
struct Extreme {
  bool drawing = false, many = false, first = false;
  std::int64_t change = 0;
};

class Schedules {
 public:
  Schedules(const WithinBounds& bounds, StrategyKind map, Emission emission) : bounds_(bounds), map_(map) {
    setup_.emission = emission;
    setup_.grids.push_back({Rate{1'000'000'000, 1}, RealTime{}});  // a tick at every ns: no sampling term
  }

  std::int64_t segments() const {
    const Duration shortest = bounds_.visualization.least + bounds_.step.least * bounds_.steps->least;
    return std::clamp(kLongEnough.ns / shortest.ns, kLeastScheduled, kMostScheduled);
  }
  WithinNeeds needs(std::span<const Extreme> schedule) {
    play(schedule);
    setup_.end = segments_.back().end + Duration{1};
    RunningNeeds running(setup_.grids, setup_.emission, RunningNeeds::Phase::any);
    each_mapped_step(setup_, map_, segments_, [&](std::span<const MappedStep> steps) { running.add(steps); });
    const LatencyBudget least = running.budget();
    return {least.lead, least.latency - least.lead};
  }

 private:
  void play(std::span<const Extreme> schedule) {
    segments_.resize(schedule.size());
    RealTime at;
    const auto take = [&](const SizeRange& length, bool most) {
      const Interval time{at, at + (most ? length.most : length.least)};
      at = time.end;
      return time;
    };
    for (std::size_t k = 0; k < schedule.size(); ++k) {
      SegmentTiming& segment = segments_[k];
      segment.index = static_cast<std::int64_t>(k);
      segment.begin = at;
      const Interval drawing = take(bounds_.visualization, schedule[k].drawing);
      if (drawing.end > drawing.begin)
        segment.visualization = drawing;
      else
        segment.visualization.reset();
      segment.steps.resize(static_cast<std::size_t>(schedule[k].many ? bounds_.steps->most : bounds_.steps->least));
      for (std::size_t i = 0; i < segment.steps.size(); ++i)
        segment.steps[i] = take(bounds_.step, schedule[k].first == (std::cmp_less(i, schedule[k].change)));
      segment.end = at;
    }
  }

  const WithinBounds& bounds_;
  StrategyKind map_;
  MapSetup setup_;
  std::vector<SegmentTiming> segments_;
};

/// All long, all short, and the two in turns of 1, 4 and 16 segments.
std::vector<std::vector<Extreme>> starts(std::size_t segments, std::int64_t most_steps) {
  std::vector<std::vector<Extreme>> out;
  for (const std::size_t turn : {std::size_t{1}, std::size_t{4}, std::size_t{16}, segments}) {
    for (const bool first : {false, true}) {
      std::vector<Extreme> one(segments);
      for (std::size_t k = 0; k < segments; ++k) {
        const bool most = first == (k / turn % 2 == 0);
        one[k] = {most, most, most, most_steps};
      }
      out.push_back(std::move(one));
    }
  }
  return out;
}

class Changes {
 public:
  explicit Changes(std::int64_t most_steps) : most_steps_(most_steps) {}
  void change(std::vector<Extreme>& schedule) {
    const std::size_t at = pick(schedule.size()), kind = pick(4);
    if (kind == 0) {
      schedule[at] = any();
    } else if (kind == 1) {
      // A run of equal ones: what a map that averages forgets slowest.
      std::fill_n(schedule.begin() + static_cast<std::ptrdiff_t>(at),
                  1 + pick(std::min<std::size_t>(schedule.size() - at, 32)), any());
    } else if (kind == 2) {
      std::swap(schedule[at], schedule[pick(schedule.size())]);
    } else {
      Extreme& one = schedule[at];
      const std::size_t what = pick(4);
      if (what == 0)
        one.drawing = !one.drawing;
      else if (what == 1)
        one.many = !one.many;
      else if (what == 2)
        one.first = !one.first;
      else
        one.change = steps();
    }
  }

 private:
  std::size_t pick(std::size_t count) { return static_cast<std::size_t>(random_.below(draw_++, count)); }
  std::int64_t steps() { return static_cast<std::int64_t>(pick(static_cast<std::size_t>(most_steps_) + 1)); }
  Extreme any() {
    const std::size_t bits = pick(8);
    return {(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0, pick(2) == 0 ? most_steps_ : steps()};
  }

  std::int64_t most_steps_;
  RandomStream random_{0, "size.within"};
  std::uint64_t draw_ = 0;
};

}  // namespace

WithinNeeds linear_within(const WithinBounds& bounds, Emission emission) {
  const Duration step = bounds.step.most;
  return {{}, emission == Emission::linear ? step + step + bounds.visualization.most : step, {}};
}

WithinNeeds paper_within(const WithinBounds& bounds, Emission emission) {
  const SizeRange &drawing = bounds.visualization, &step = bounds.step;
  const SizeCounts& steps = *bounds.steps;
  const Duration longest = drawing.most + step.most * steps.least, shortest = drawing.least + step.least * steps.most;
  // i r, rounded down as the map does. Where it is whole, and N^ an average of several N, the map's rounded sums may put it
  // slightly below, and so 1 ns lower.
  const std::int64_t rounded = steps.least < steps.most ? 1 : 0;
  const auto slow = [&](std::int64_t i) { return Duration{floor_mul_div(longest.ns, i, steps.least)}; };
  const auto fast = [&](std::int64_t i) {
    return i == 0 ? Duration{} : Duration{floor_mul_div(shortest.ns * i - rounded, 1, steps.most)};
  };
  WithinNeeds needs{slow(steps.most - 1) - drawing.least - step.least * (steps.most - 1), drawing.most + step.most, {}};
  const auto ends = [&](std::int64_t i) { return drawing.most + step.most * (i + 1) - fast(i); };
  needs.late = std::max(needs.late, ends(steps.most - 1));
  needs.behind = needs.late - step.most;
  if (emission == Emission::hold) return needs;
  // From the last step of a segment to the end of the first one of the next.
  for (const std::int64_t count : {steps.least, steps.most})
    needs.late = std::max(needs.late, ends(count - 1) + drawing.most + step.most);
  return needs;
}

WithinNeeds clocked_within(const WithinBounds& bounds, Rate step_rate, Emission emission) {
  const SizeRange &drawing = bounds.visualization, &step = bounds.step;
  const Duration size{instant_ns(step_rate, 1)}, size_up = period_ceil(step_rate);
  const auto with_steps = [&](std::int64_t count) { return drawing.most + step.most * count; };
  Duration frame = drawing.most;  // T*
  for (Duration before; before != frame;) {
    before = frame;
    frame = with_steps((frame.ns + size.ns - 1) / size.ns);
  }
  const std::int64_t least_steps = std::max<std::int64_t>(1, drawing.least.ns / size_up.ns);
  const Duration soonest = size + drawing.least + step.least * (least_steps - 1);  // a
  const std::int64_t usual = frame.ns / size.ns;
  const auto latest_with = [&](Duration late, std::int64_t count) {
    return size_up - late + with_steps(count) + drawing.most + step.most;
  };
  const Duration grows = size * (usual + 1) - frame + Duration{1};
  Duration latest = latest_with(Duration{1}, usual);  // b
  if (grows <= size_up) latest = std::max(latest, latest_with(grows, usual + 1));
  const Duration first_soonest = std::max(size, drawing.least) + drawing.least;
  const Duration first_latest = drawing.most + drawing.most + (drawing.least < size ? size - Duration{1} : Duration{});
  const Duration late = latest - first_soonest;
  return {first_latest - soonest, emission == Emission::linear ? late + size_up : late, late - step.least};
}

WithinNeeds searched_within(const WithinBounds& bounds, StrategyKind map, Emission emission, std::int64_t& tried) {
  Schedules schedules(bounds, map, emission);
  const std::int64_t segments = schedules.segments();
  const std::int64_t tries = std::clamp(kScheduledSteps / (segments * bounds.steps->most), kLeastTries, kMostTries);
  const auto all = starts(static_cast<std::size_t>(segments), bounds.steps->most);
  WithinNeeds most;
  tried = 0;
  for (Duration WithinNeeds::*what : {&WithinNeeds::early, &WithinNeeds::late}) {
    Changes changes(bounds.steps->most);
    std::optional<Duration> found;
    for (const std::vector<Extreme>& start : all) {
      std::vector<Extreme> now = start;
      Duration needed = schedules.needs(now).*what;
      for (std::int64_t i = 0; i < tries / std::ssize(all); ++i, ++tried) {
        std::vector<Extreme> next = now;
        changes.change(next);
        const Duration needs = schedules.needs(next).*what;
        if (needs < needed) continue;
        needed = needs;
        now = std::move(next);
      }
      found = std::max(found.value_or(needed), needed);
    }
    most.*what = *found;
  }
  most.behind = most.late - bounds.step.least;
  return most;
}

std::int64_t waiting_within(const WithinBounds& bounds, const WithinNeeds& needs) {
  const Duration step = bounds.step.least, within = needs.early + needs.late;
  const std::int64_t in_segment = bounds.steps->most;
  const Duration segment = bounds.visualization.least + step * in_segment;
  const std::int64_t whole = within.ns / segment.ns;
  return whole * in_segment + std::min(in_segment, (within - segment * whole).ns / step.ns);
}

std::int64_t waiting_clocked(const WithinBounds& bounds, Rate step_rate, const WithinNeeds& needs) {
  return (needs.early + needs.late - bounds.step.least).ns / instant_ns(step_rate, 1) + 1;
}

}  // namespace internal

namespace {

/// "9 ms .. 14 ms", or one value for both; read(text) gives a Result.
template <class Range, class Read>
std::string read_range(std::string_view word, std::string_view text, Range& into, Read read) {
  const std::size_t dots = text.find("..");
  const auto least = read(internal::trimmed(text.substr(0, dots)));
  if (!least) return fmt::format("\"{} {}\": {}", word, text, least.error());
  into = {*least, *least};
  if (dots == std::string_view::npos) return {};
  const auto most = read(internal::trimmed(text.substr(dots + 2)));
  if (!most) return fmt::format("\"{} {}\": {}", word, text, most.error());
  into.most = *most;
  if (into.most < into.least) return fmt::format("\"{} {}\": the first must not be above the second", word, text);
  return {};
}

Result<std::int64_t> read_count(std::string_view text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || value < 1 || value > WithinBounds::kMostSteps)
    return Failure(fmt::format("must be whole numbers from 1 to {}, such as 15 or 10 .. 20", WithinBounds::kMostSteps));
  return value;
}

Result<Duration> read_length(std::string_view text) {
  Result<Duration> length = parse_duration(text);
  if (length && (*length < Duration{} || *length > WithinBounds::kLongest))
    return Failure(std::string("must be from 0 s to 1000 s"));
  return length;
}

}  // namespace

Result<WithinBounds> parse_within(std::string_view text) {
  WithinBounds bounds;
  bool has_step = false;
  const std::string error =
      internal::each_clause(text, [&](std::string_view clause, std::string_view word, std::string_view rest) -> std::string {
        if (word == "visualization") return read_range(word, rest, bounds.visualization, read_length);
        if (word == "step") {
          has_step = true;
          return read_range(word, rest, bounds.step, read_length);
        }
        if (word == "steps") return read_range(word, rest, bounds.steps.emplace(), read_count);
        return fmt::format(
            "\"{}\" is none of \"visualization 9 ms .. 14 ms\", \"step 1.2 ms .. 1.9 ms\" and \"steps 10 .. 20\"", clause);
      });
  if (!error.empty()) return Failure(error);
  if (!has_step || bounds.step.least <= Duration{})
    return Failure(std::string("it must say how long a step takes, above 0 s, such as \"step 1.2 ms .. 1.9 ms\""));
  return bounds;
}

Result<SizeWithin> size_within(const WithinBounds& bounds, const SizeOptions& options) {
  SizeWithin out{.visualization = bounds.visualization, .step = bounds.step, .steps = bounds.steps};
  out.sampling_period = period_ceil(options.sampling);
  out.interpolated = options.emission == Emission::linear;
  if (options.step_size) out.step_size = Duration{instant_ns(*options.step_size, 1)};
  if (bounds.steps.has_value() == options.step_size.has_value())
    return Failure(
        std::string("it takes either \"steps 15\", how many there are in a segment, or --step-size: then a frame runs those "
                    "that are due"));
  const SamplingGrid device{options.sampling, RealTime{}};
  const auto add = [&](StrategyKind map, SizeWithin::How how, const internal::WithinNeeds& needs, std::int64_t waiting) {
    const Duration lead = needs.early + out.sampling_period - Duration{1}, latency = lead + needs.late;
    const RunningCapacities rings({&device, 1}, lead, latency, needs.behind + lead, {});
    out.maps.push_back({name_of(map), how, lead, latency, rings.budget().interaction_capacity,
                        static_cast<std::size_t>(waiting) + 2});  // as RunningCapacities adds
  };
  if (options.step_size) {
    // Close to it, frames would be thousands of times as long as a drawing.
    if (bounds.step.most * 1000 >= *out.step_size * 999)
      return Failure(
          fmt::format("a step may take {} ns and simulates {} ns: the loop does not keep real time, and its latency "
                      "grows for as long as it runs; it takes a step that is shorter than what it simulates",
                      bounds.step.most.ns, out.step_size->ns));
    if (bounds.visualization.least <= Duration{})
      return Failure(std::string("a frame without a step must take time: it takes a visualization above 0 s"));
    const internal::WithinNeeds needs = internal::clocked_within(bounds, *options.step_size, options.emission);
    add(StrategyKind::clocked, SizeWithin::How::bound, needs, internal::waiting_clocked(bounds, *options.step_size, needs));
    return out;
  }
  const auto add_segmented = [&](StrategyKind map, SizeWithin::How how, const internal::WithinNeeds& needs) {
    add(map, how, needs, internal::waiting_within(bounds, needs));
  };
  add_segmented(StrategyKind::linear, SizeWithin::How::exact, internal::linear_within(bounds, options.emission));
  add_segmented(StrategyKind::paper, SizeWithin::How::exact, internal::paper_within(bounds, options.emission));
  std::int64_t tried = 0;
  add_segmented(StrategyKind::phase_locked, SizeWithin::How::found,
                internal::searched_within(bounds, StrategyKind::phase_locked, options.emission, tried));
  out.maps.back().tried = tried;
  return out;
}

}  // namespace evenstep
