#include "evenstep/campaigns/size.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <span>
#include <utility>

#include "evenstep/harness/sizing.h"
#include "evenstep/harness/trust.h"
#include "evenstep/recordings/step_list.h"
#include "evenstep/remap/buffer_oracle.h"
#include "evenstep/remap/jump_bound.h"
#include "evenstep/remap/step_windows.h"
#include "evenstep/remap/velocity_jump.h"
#include "evenstep/reports/json.h"
#include "fits.h"
#include "hitches.h"
#include "mend.h"
#include "own_clock.h"
#include "per.h"
#include "rate.h"
#include "src/schedules/worst_order.h"
#include "unseen.h"
#include "what_if_rows.h"

namespace evenstep {
namespace {

using internal::Mending;

/// What is sized: segments, and what the maps need besides.
struct Input {
  MapSetup setup;
  std::vector<SegmentTiming> segments;
};

Duration longest_period(const std::vector<SamplingGrid>& devices) {
  Duration longest;
  for (const SamplingGrid& device : devices) longest = std::max(longest, period_ceil(device.rate));
  return longest;
}

SizeWindows windows_of(std::vector<Duration> latencies) {
  if (latencies.empty()) return {};
  std::sort(latencies.begin(), latencies.end());
  const auto rank = [&](double share) {
    const double n = static_cast<double>(latencies.size());
    return latencies[static_cast<std::size_t>(std::max(std::ceil(share * n) - 1, 0.0))];
  };
  return {
      .p50 = rank(0.5), .p99 = rank(0.99), .most = latencies.back(), .count = static_cast<std::int64_t>(latencies.size())};
}

/// A least latency without the sampling term, and its culprit.
struct Least {
  Duration latency;
  std::int64_t culprit = -1;
};
Least least_of(const RunningLine& line) {
  const BestLine best = line.best();
  return {best.latency, best.latency_culprit};
}
Least least_of(const RunningPath& path) { return {path.least().latency, path.least().latency_culprit}; }

/// Computes everything for one input. It does not store the steps; each computation is a pass over the segments.
class Sizer {
 public:
  Sizer(Input& input, const SizeOptions& options)
      : input_(input), options_(options), devices_(input.setup.grids), mending_(input.segments) {
    each_step([&](RealTime begin, RealTime end) {
      if (steps_ == 0) first_begin_ = begin;
      last_begin_ = begin;
      last_end_ = end;
      ++steps_;
    });
    if (steps_ > 1) slot_ = {(last_begin_ - first_begin_).ns / (steps_ - 1)};
  }

  void size(SizeResult& result) {
    SizeRecord& record = result.record;
    record.steps = steps_;
    record.segments = static_cast<std::int64_t>(input_.segments.size());
    record.visualizations = std::count_if(input_.segments.begin(), input_.segments.end(),
                                          [](const SegmentTiming& one) { return one.visualization.has_value(); });
    record.forces_travel = std::any_of(input_.segments.begin(), input_.segments.end(),
                                       [](const SegmentTiming& one) { return !one.transports.empty(); });
    record.length = last_end_ - first_begin_;
    record.sampling_period = longest_period(devices_);
    record.interpolated = input_.setup.emission == Emission::linear;
    record.damping_N_s_per_m = options_.damping_N_s_per_m;
    record.rate = options_.rate;
    record.confidence = options_.confidence;
    record.per = options_.per;
    if (options_.rate) record.clean_segments = internal::chosen_segments_needed(*options_.rate, options_.confidence, 1);
    LongestPause pauses;
    for (const SegmentTiming& one : input_.segments)
      pauses.add_segment({one.begin, one.end}, one.visualization, one.steps, one.overlaps());
    record.pause = pauses.parts();
    record.held = bounds(false);
    if (record.interpolated) record.linear = bounds(true);
    maps_ = internal::maps_to_size(input_.setup, options_.other_maps);
    for (const StrategyKind map : maps_) record.strategies.push_back(strategy(map));
    add_other_jumps(record);
    add_hitches(record);
    if (options_.fits) record.fit = internal::fit_of(*options_.fits, record, input_.setup, input_.segments);
    record.what_ifs = internal::what_if_rows(input_.setup, input_.segments, maps_, options_);
    if (options_.worst_order)
      record.worst_order =
          internal::worst_orders(input_.setup, input_.segments, maps_, *options_.worst_order, record, result.worst);
  }

 private:
  /// The longest time that a sample can come after the time for which a read asks.
  Duration sampling_term() const {
    Duration longest;
    for (const SamplingGrid& device : devices_) longest = std::max(longest, period_ceil(device.rate) + device.age);
    return longest - Duration{1};
  }

  /// Visits the steps that end within the run, as the maps see them.
  template <class Visit>
  void each_step(Visit visit) const {
    const RealTime end = input_.setup.end;
    for (const SegmentTiming& segment : input_.segments) {
      for (std::size_t i = 0; i < segment.steps.size() && segment.steps[i].end < end; ++i)
        visit(segment.steps[i].begin, segment.steps[i].end);
    }
  }

  /// Visits these steps with their numbers, and with the ends at which their forces are due (if forces are interpolated, an
  /// end is that of the next step, as in `interpolate`).
  template <class Visit>
  void each_due_step(bool linear, Visit visit) const {
    std::int64_t n = 0;
    if (!linear) return each_step([&](RealTime begin, RealTime end) { visit(n++, begin, end); });
    RealTime begin_before, end_before;
    each_step([&](RealTime begin, RealTime end) {
      if (n > 0) visit(n - 1, begin_before, end);
      begin_before = begin;
      end_before = end;
      ++n;
    });
    if (n > 0) visit(n - 1, begin_before, end_before);
  }

  void close_loop(SizeNeed& need, bool linear) const {
    need.total_delay = need.latency + (linear ? Duration{} : Duration{slot_.ns / 2});
    const double held_s = seconds(longest_period(devices_)) / 2;
    need.stiffness_limit_N_per_m = options_.damping_N_s_per_m / (held_s + seconds(need.total_delay));
  }

  /// The latency that `Running`, a line or a path, needs, and what it would need if its culprit had not been late.
  template <class Running>
  SizeNeed bound(bool linear, const Running& whole, std::vector<Duration> windows,
                 SizeCulprit (Mending::*blame)(std::int64_t) const) {
    SizeNeed need;
    if (steps_ == 0) return need;
    const Least least = least_of(whole);
    need.latency = least.latency + sampling_term();
    need.windows = windows_of(std::move(windows));
    need.culprit = (mending_.*blame)(std::min(least.culprit + (linear ? 1 : 0), steps_ - 1));
    need.culprit.mended_latency = need.latency;
    mending_.mended(need.culprit, [&] {
      Running mended;
      each_due_step(linear, [&](std::int64_t n, RealTime begin, RealTime end) { mended.add(n, begin, end); });
      need.culprit.mended_latency = least_of(mended).latency + sampling_term();
    });
    close_loop(need, linear);
    return need;
  }

  Duration latency_of(StrategyKind kind, std::span<const SegmentTiming> segments) const {
    RunningNeeds needs(devices_, input_.setup.emission, RunningNeeds::Phase::any);
    each_mapped_step(input_.setup, kind, segments, [&](std::span<const MappedStep> steps) { needs.add(steps); });
    return needs.budget().latency + needed_ahead(input_.setup, kind, input_.setup.emission);
  }

  void add_hitches(SizeRecord& record) const {
    const internal::Hitches found(input_.segments);
    record.segment = found.usual_segment();
    for (std::size_t i = 0; i < found.kinds().size(); ++i) {
      SizeHitches kind = in_record(found.kinds()[i]);
      const std::vector<SegmentTiming> alone = found.mended(i, 1), above = i == 0 ? alone : found.mended(0, i + 1);
      for (const StrategyKind map : maps_) {
        SizeNeed all;
        all.latency = latency_of(map, above);
        close_loop(all, record.interpolated);
        kind.mended.push_back({latency_of(map, alone), all.latency, all.stiffness_limit_N_per_m});
      }
      record.hitches.push_back(std::move(kind));
    }
  }

  static SizeHitches in_record(const internal::HitchKind& kind) {
    const auto [shortest, longest] =
        std::minmax_element(kind.begin(), kind.end(), [](const auto& a, const auto& b) { return a.length < b.length; });
    SizeHitches out{.what = kind.front().what,
                    .count = std::ssize(kind),
                    .shortest = shortest->length,
                    .longest = longest->length,
                    .usual = kind.front().usual,
                    .first = kind.front().begin};
    std::vector<Duration> between;
    for (std::size_t i = 1; i < kind.size(); ++i) between.push_back(kind[i].begin - kind[i - 1].begin);
    if (between.empty()) return out;
    std::sort(between.begin(), between.end());
    out.least_between = between.front();
    out.median_between = between[between.size() / 2];
    out.most_between = between.back();
    return out;
  }

  /// The bounds of jump_bound.h take several passes over the steps with dozens of operations each.
  static constexpr std::int64_t kMostPathSteps = 100'000;

  std::vector<StepTimes> due_steps(bool linear) const {
    std::vector<StepTimes> steps;
    if (steps_ > kMostPathSteps) return steps;
    steps.reserve(static_cast<std::size_t>(steps_));
    each_due_step(linear, [&](std::int64_t, RealTime begin, RealTime end) { steps.push_back({begin, end}); });
    return steps;
  }

  Duration in_ns(double slots) const { return Duration{static_cast<std::int64_t>(slots * static_cast<double>(slot_.ns))}; }

  SizePath path(std::span<const StepTimes> steps, double jump) const {
    return {jump, least_latency_with_jump(steps, in_ns(jump)) + sampling_term()};
  }

  void add_paths(bool linear, SizeBounds& bounds) const {
    const std::vector<StepTimes> steps = due_steps(linear);
    if (steps.empty()) return;
    for (const double jump : {0.005, 0.02, 0.05, 0.1, 0.15, 0.35}) bounds.paths.push_back(path(steps, jump));
  }

  SizeBounds bounds(bool linear) {
    PauseBound pause(slot_);
    RunningLine line, line_window;
    RunningPath path, path_window;
    std::vector<Duration> line_windows, path_windows;
    const auto close_window = [&] {
      line_windows.push_back(least_of(line_window).latency + sampling_term());
      path_windows.push_back(least_of(path_window).latency + sampling_term());
    };
    WindowBorder border;
    each_due_step(linear, [&](std::int64_t n, RealTime begin, RealTime end) {
      if (border.begins(begin) && n > 0) {
        close_window();
        line.append(line_window);
        line_window.restart();
        path_window.restart();
      }
      pause.add(begin, end);
      line_window.add(n, begin, end);
      path_window.add(n, begin, end);
      path.add(n, begin, end);
    });
    if (line_windows.empty()) close_window();
    line.append(line_window);
    SizeBounds bounds{bound(linear, line, std::move(line_windows), &Mending::blame),
                      bound(linear, path, std::move(path_windows), &Mending::blame_run_time),
                      pause.latency() + sampling_term()};
    add_paths(linear, bounds);
    return bounds;
  }

  void add_other_jumps(SizeRecord& record) const {
    if (std::find(maps_.begin(), maps_.end(), StrategyKind::phase_locked) == maps_.end()) return;
    for (const double times : {0.5, 2.0}) {
      MapSetup setup = input_.setup;
      setup.remap.jump = std::clamp(times * setup.remap.jump, 0.01, 1.0);  // what [remap] takes
      RunningNeeds needs(devices_, setup.emission, RunningNeeds::Phase::any);
      each_mapped_step(setup, StrategyKind::phase_locked, input_.segments,
                       [&](std::span<const MappedStep> steps) { needs.add(steps); });
      record.other_jumps.push_back(
          {setup.remap.jump, needs.budget().latency + needed_ahead(setup, StrategyKind::phase_locked, setup.emission)});
    }
  }

  SizeStrategy strategy(StrategyKind kind) {
    const Emission emission = input_.setup.emission;
    RunningNeeds any(devices_, emission, RunningNeeds::Phase::any), window = any;
    RunningNeeds here(devices_, emission, RunningNeeds::Phase::this_one);
    const Duration ahead = needed_ahead(input_.setup, kind, input_.setup.emission);
    internal::SegmentNeeds any_of_segments(devices_, emission, RunningNeeds::Phase::any, ahead);
    internal::SegmentNeeds here_of_segments(devices_, emission, RunningNeeds::Phase::this_one, ahead);
    std::vector<Duration> windows;
    WindowBorder border;
    bool open = false;
    VelocityJump jump(first_begin_ + std::min(Duration{1'000'000'000}, Duration{(last_end_ - first_begin_).ns / 2}));
    each_mapped_step(input_.setup, kind, input_.segments, [&](std::span<const MappedStep> steps) {
      any.add(steps);
      here.add(steps);
      any_of_segments.add(steps);
      if (options_.rate) here_of_segments.add(steps);
      jump.add(steps);
      std::size_t from = 0;
      for (std::size_t i = 0; i < steps.size(); ++i) {
        if (!border.begins(steps[i].begin)) continue;
        window.add(steps.subspan(from, i - from));
        from = i;
        if (open) windows.push_back(window.budget().latency + ahead);
        open = true;
        window.restart();
      }
      window.add(steps.subspan(from));
    });
    if (open && windows.empty()) windows.push_back(window.budget().latency + ahead);
    LatencyBudget least = any.budget();
    least.latency = least.latency + ahead;
    SizeStrategy out{name_of(kind), traits_of(kind).for_comparison};
    out.jump_seen = jump.seen();
    if (slot_.ns > 0) out.velocity_jump = static_cast<double>(jump.most_ns()) / static_cast<double>(slot_.ns);
    if (const std::vector<StepTimes> steps = due_steps(emission == Emission::linear); !steps.empty()) {
      out.path = path(steps, out.velocity_jump);
      out.pauses_bound = pauses_bound(steps, slot_, in_ns(out.velocity_jump)) + sampling_term();
    }
    out.lead = least.lead;
    out.latency_this_phase = here.budget().latency + ahead;
    out.lead_this_phase = here.budget().lead;
    out.lead_culprit = least.lead_culprit;
    out.interaction_capacity = static_cast<std::int64_t>(any.interaction_capacity());
    out.force_capacity = force_capacity(kind, least);
    const internal::MapNeeds needs{any_of_segments.take(), here_of_segments.take()};
    out.unseen = internal::play_unseen(needs.any_phase);
    out.trust = internal::trust_in(needs.any_phase);
    if (options_.rate && !needs.any_phase.empty())
      out.rate = internal::rate_of(needs, out.trust, *options_.rate, options_.confidence);
    if (options_.per)
      out.per =
          internal::size_per(needs.any_phase, out.trust, *options_.per, options_.rate.value_or(0), options_.confidence);
    SizeNeed& need = out.any_phase;
    need.latency = least.latency;
    need.windows = windows_of(std::move(windows));
    close_loop(need, emission == Emission::linear);
    if (least.latency_culprit < 0) return out;
    need.culprit = mending_.blame(least.latency_culprit);
    need.culprit.mended_latency = need.latency;
    mending_.mended(need.culprit, [&] {
      any.restart();
      each_mapped_step(input_.setup, kind, input_.segments, [&](std::span<const MappedStep> steps) { any.add(steps); });
      need.culprit.mended_latency = any.budget().latency + ahead;
    });
    return out;
  }

  std::int64_t force_capacity(StrategyKind kind, const LatencyBudget& least) const {
    WaitingForces waiting(least.latency - least.lead);
    each_mapped_step(input_.setup, kind, input_.segments, [&](std::span<const MappedStep> steps) { waiting.add(steps); });
    return static_cast<std::int64_t>(waiting.most()) + 2;
  }

  Input& input_;
  const SizeOptions& options_;
  std::vector<SamplingGrid> devices_;
  Mending mending_;
  std::vector<StrategyKind> maps_;  // as in SizeRecord::strategies
  std::int64_t steps_ = 0;
  RealTime first_begin_, last_begin_, last_end_;
  Duration slot_;  // mean time from the begin of a step to that of the next
};

SizeCycle in_record(const StepCycle& cycle) {
  const std::size_t first = cycle.boundaries.empty() ? 0 : cycle.boundaries.front();
  return {.found = cycle.found,
          .reason = cycle.reason,
          .segments = cycle.segments,
          .steps_per_segment = cycle.steps_per_segment,
          .least_steps = cycle.least_steps,
          .most_steps = cycle.most_steps,
          .first_boundary = static_cast<std::int64_t>(first),
          .period = cycle.period,
          .pause = cycle.pause,
          .longest_gap = cycle.longest_gap,
          .period_variation = cycle.period_variation,
          .confidence = cycle.confidence,
          .regularity = cycle.regularity};
}

/// Finds segments for a list that has none.
void find_segments(Input& input, SizeRecord& record) {
  const StepCycle cycle = cycle_of(input.segments);
  record.cycle = in_record(cycle);
  const bool given = input.segments.size() > 1 || input.segments.front().visualization.has_value();
  if (given) return;
  record.segments_from = cycle.found ? "cycle" : "step";
  CutSteps cut = cut_steps(input.segments.front().steps, cycle);
  record.left_out = cut.left_out;
  input.segments = std::move(cut.segments);
}

/// Changes the step numbers of the record so that they count all steps of the file.
void shift_numbers(SizeRecord& record) {
  const auto shift = [&](SizeNeed& need) {
    for (std::int64_t* step : {&need.culprit.step, &need.culprit.late_step}) *step += *step >= 0 ? record.left_out : 0;
  };
  for (SizeBounds* bounds : {&record.held, record.linear ? &*record.linear : nullptr}) {
    if (bounds == nullptr) continue;
    shift(bounds->best_line);
    shift(bounds->taut_string);
  }
  for (SizeStrategy& strategy : record.strategies) {
    shift(strategy.any_phase);
    if (strategy.lead_culprit >= 0) strategy.lead_culprit += record.left_out;
  }
}

}  // namespace

std::vector<SegmentTiming> internal::segments_of(const Scenario& scenario) {
  std::vector<SegmentTiming> segments;
  const std::unique_ptr<StepTiming> timing = make_timing(scenario.timing);
  for (SegmentTiming segment; timing->next(segment) && segment.begin < RealTime{scenario.run_duration.ns};)
    segments.push_back(segment);
  return segments;
}

std::vector<StrategyKind> internal::maps_to_size(const MapSetup& setup, bool other_maps) {
  std::vector<StrategyKind> maps;
  for (const StrategyTraits& traits : kAllStrategies) {
    if (!traits.remaps || (traits.kind == StrategyKind::foreign && !setup.remap.foreign)) continue;
    if (traits.kind == StrategyKind::clocked && !setup.has_clock) continue;
    if (!traits.for_comparison || other_maps) maps.push_back(traits.kind);
  }
  return maps;
}

SizeResult size_scenario(const Scenario& scenario, const SizeOptions& options) {
  if (scenario.case_spec)
    return {{}, {}, {{scenario.file, 0, 0, "a [case] drives the solver without a loop: there is no latency to size"}}};
  Input input{map_setup(scenario), internal::segments_of(scenario)};
  SizeResult result;
  result.record.input = scenario.file;
  result.record.segments_from = scenario.timing.trace.empty() ? "programmed" : "recording";
  Sizer(input, options).size(result);
  result.segments = std::move(input.segments);
  result.damage = scenario.timing.trace_damage;
  return result;
}

namespace {

/// Steps per second, as far as it matters to a map that has to know it: at most one per ns.
Rate mean_rate(const std::vector<SegmentTiming>& segments) {
  std::int64_t steps = 0;
  for (const SegmentTiming& segment : segments) steps += static_cast<std::int64_t>(segment.steps.size());
  const Duration length = segments.back().end - segments.front().begin;
  return {1'000'000'000, std::max<std::int64_t>(length.ns / std::max<std::int64_t>(steps, 1), 1)};
}

/// [timing] roles for options of the command line; empty if there are none.
std::string roles_in_toml(const RecordingOptions& options) {
  const Roles& roles = options.roles;
  const CsvColumns& columns = options.profile.columns;
  const std::string step_time = roles.steps > 0 ? fmt::format("{} ns", roles.step_time.ns) : "";
  std::string out;
  const auto add = [&](const char* key, const std::string& value) {
    if (!value.empty()) out += fmt::format("{}{} = {}", out.empty() ? "" : ", ", key, value);
  };
  for (const auto& [key, text] :
       std::initializer_list<std::pair<const char*, const std::string&>>{{"preset", options.preset},
                                                                         {"segment", roles.segment},
                                                                         {"visualization", roles.visualization},
                                                                         {"step", roles.step},
                                                                         {"step_begin", roles.step_begin},
                                                                         {"process", roles.process},
                                                                         {"step_time", step_time},
                                                                         {"format", options.profile.format},
                                                                         {"name", columns.name},
                                                                         {"begin", columns.begin},
                                                                         {"end", columns.end},
                                                                         {"duration", columns.duration},
                                                                         {"unit", columns.unit}})
    add(key, text.empty() ? "" : json_text(Json(text)));
  add("steps", roles.steps > 0 ? std::to_string(roles.steps) : "");
  add("header", options.profile.header > 0 ? std::to_string(options.profile.header) : "");
  return out.empty() ? "" : "{ " + out + " }";
}

SizeResult size_input(std::vector<SegmentTiming> segments, const std::string& name, const SizeOptions& options) {
  SizeResult result;
  SizeRecord& record = result.record;
  record.input = name;
  record.segments_from = "recording";
  Input input;
  input.segments = std::move(segments);
  find_segments(input, record);
  input.setup.grids.push_back({options.sampling, RealTime{}});
  input.setup.emission = options.emission;
  input.setup.step_rate = mean_rate(input.segments);
  if (options.step_size || has_clock(input.segments)) {
    input.setup.step_rate =
        options.step_size.value_or(Rate{1'000'000'000, std::max<std::int64_t>(usual_step_size(input.segments).ns, 1)});
    record.clock = internal::follow_clock(input.segments, input.setup.step_rate);
    input.setup.has_clock = record.clock->follows;
  }
  for (const SegmentTiming& segment : input.segments)  // a step may end after the segment that follows its own
    input.setup.end = std::max(input.setup.end, segment.end + Duration{1});
  Sizer(input, options).size(result);
  shift_numbers(record);
  result.segments = std::move(input.segments);
  return result;
}

}  // namespace

SizeRecord size_segments(std::vector<SegmentTiming> segments, const std::string& name, const SizeOptions& options) {
  return size_input(std::move(segments), name, options).record;
}

SizeResult size_recording(const std::string& path, const SizeOptions& options, const RecordingOptions& recording) {
  std::string damage;
  Recording csv = read_recording(path, recording, true, &damage);
  if (!csv) return {{}, {}, csv.error()};
  const auto has_steps = [](const SegmentTiming& segment) { return !segment.steps.empty(); };
  if (std::none_of(csv->begin(), csv->end(), has_steps))
    return {{},
            {},
            {{path, 0, 0,
              "there is no step in it; write a row of kind step for each, or, of pictures, --steps and --step-time"}}};
  SizeResult result = size_input(*std::move(csv), path, options);
  result.damage = std::move(damage);
  // Of a list a scenario finds the same segments; of other files it takes the one that they have.
  if (result.record.segments_from != "recording" && !is_step_list(path)) return result;
  result.record.trace = path;
  result.record.trace_roles = roles_in_toml(recording);
  return result;
}

}  // namespace evenstep
