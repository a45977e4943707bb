#include "timing.h"

#include <algorithm>

#include "evenstep/harness/sizing.h"

namespace evenstep::internal {
namespace {

/// Lower median; 0 of nothing.
template <class T>
T median_ns(std::vector<T> values) {
  if (values.empty()) return {};
  const auto middle = values.begin() + (std::ssize(values) - 1) / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<SegmentTiming> played_segments(const Scenario& scenario) {
  std::vector<SegmentTiming> segments;
  const std::unique_ptr<StepTiming> timing = make_timing(scenario.timing);
  SegmentTiming segment;
  while (timing->next(segment) && segment.begin < RealTime{scenario.run_duration.ns}) segments.push_back(segment);
  return segments;
}

std::int64_t length_ns(const Interval& interval) { return (interval.end - interval.begin).ns; }

/// The current time while visualizations and steps are placed one after the other.
struct Cursor {
  std::int64_t now = 0;
  Interval take(std::int64_t gap, std::int64_t length_ns) {
    const RealTime begin{now + std::max<std::int64_t>(gap, 0)};
    now = begin.ns + std::max<std::int64_t>(length_ns, 0);
    return {begin, RealTime{now}};
  }
};

}  // namespace

TimingShape::TimingShape(const Scenario& scenario) {
  const std::vector<SegmentTiming> segments = played_segments(scenario);
  lanes_ =
      std::any_of(segments.begin(), segments.end(), [](const SegmentTiming& s) { return s.concurrent || s.overlaps(); });
  const ProgrammedTiming& programmed = scenario.timing.programmed;
  if (scenario.timing.trace.empty() && !scenario.timing.governor && !programmed.accumulator &&
      (programmed.paced || (!lanes_ && is_periodic(programmed))))
    grid_ = programmed.segment;
  measure(segments);
  measure_clock(segments, scenario.scene.step_rate);
  set_nominal(scenario);
  compare();
}

void TimingShape::measure(const std::vector<SegmentTiming>& segments) {
  std::int64_t end = segments.empty() ? 0 : segments.front().begin.ns, visualization_end = end;
  for (const SegmentTiming& segment : segments) {
    Lengths& one = segments_.emplace_back();
    Lengths& of_steps = lanes_ ? segments_.front() : one;
    const auto show = [&] {
      std::int64_t& before = lanes_ ? visualization_end : end;
      one.visualization_gap = segment.visualization->begin.ns - before;
      one.visualization = length_ns(*segment.visualization);
      before = segment.visualization->end.ns;
    };
    bool shown = !segment.visualization;
    for (const Interval& step : segment.steps) {
      if (!shown && (lanes_ || segment.visualization->begin <= step.begin)) {
        show();
        shown = true;
      }
      if (!shown) ++one.steps_before;
      of_steps.gaps.push_back(step.begin.ns - end);
      of_steps.steps.push_back(length_ns(step));
      end = step.end.ns;
    }
    if (!shown) show();
  }
}

void TimingShape::measure_clock(const std::vector<SegmentTiming>& segments, Rate step_rate) {
  for (Lengths& one : segments_) one.dropped.assign(one.steps.size(), 0);
  std::optional<std::int64_t> before;
  std::size_t n = 0;
  for (std::size_t k = 0; k < segments.size(); ++k) {
    for (std::size_t i = 0; i < segments[k].simulated.size(); ++i, ++n) {
      const SimTime t = segments[k].simulated[i];
      const std::int64_t number = first_tick_at_or_after(step_rate, RealTime{t.ns});
      if (sim_time(step_rate, number) != t || (before && number <= *before)) return;
      if (!before) first_step_ = number;
      (lanes_ ? segments_.front().dropped[n] : segments_[k].dropped[i]) = before ? number - *before - 1 : 0;
      before = number;
    }
  }
  if (before) clock_ = step_rate;
}

void TimingShape::set_nominal(const Scenario& scenario) {
  std::vector<std::int64_t> visualizations, visualization_gaps, steps, gaps;
  std::vector<std::size_t> counts, before;
  for (const Lengths& one : segments_) {
    if (one.visualization > 0) {
      visualizations.push_back(one.visualization);
      visualization_gaps.push_back(one.visualization_gap);
      before.push_back(one.steps_before);
    }
    steps.insert(steps.end(), one.steps.begin(), one.steps.end());
    gaps.insert(gaps.end(), one.gaps.begin(), one.gaps.end());
    counts.push_back(one.steps.size());
  }
  nominal_ = {.visualization = median_ns(visualizations),
              .visualization_gap = median_ns(visualization_gaps),
              .step = median_ns(steps),
              .gap = median_ns(gaps),
              .count = median_ns(counts),
              .steps_before = median_ns(before)};
  if (!scenario.timing.trace.empty()) return;
  nominal_.visualization = scenario.timing.programmed.visualization.ns;
  nominal_.step = scenario.nominal.step_run_time.ns;
  nominal_.visualization_gap = nominal_.gap = 0;
}

void TimingShape::compare() {
  using Kind = Perturbation::Kind;
  const auto add = [&](Kind kind, std::size_t segment, std::size_t step, std::int64_t is, std::int64_t nominal) {
    if (is != nominal) perturbations_.push_back({kind, segment, step, nominal, is - nominal});
  };
  for (std::size_t k = 0; k < segments_.size(); ++k) {
    const Lengths& one = segments_[k];
    if (!lanes_) add(Kind::count, k, 0, std::ssize(one.steps), static_cast<std::int64_t>(nominal_.count));
    if (!grid_ && k > 0 && one.visualization > 0)
      add(Kind::visualization_gap, k, 0, one.visualization_gap, nominal_.visualization_gap);
    add(Kind::visualization, k, 0, one.visualization, nominal_.visualization);
    for (std::size_t i = 0; i < one.steps.size(); ++i) {
      if (!grid_ && (k > 0 || i > 0)) add(Kind::step_gap, k, i, one.gaps[i], nominal_.gap);
      add(Kind::step, k, i, one.steps[i], nominal_.step);
      if (clock_) add(Kind::dropped, k, i, one.dropped[i], 0);
    }
  }
}

std::vector<TimingShape::Lengths> TimingShape::lengths(const std::vector<Perturbation>& perturbations) const {
  std::vector<Lengths> all(segments_.size());
  for (std::size_t k = 0; k < all.size(); ++k) {
    Lengths& one = all[k];
    one.visualization = nominal_.visualization;
    one.visualization_gap = k == 0 ? segments_[0].visualization_gap : nominal_.visualization_gap;
    one.steps_before = segments_[k].visualization > 0 ? segments_[k].steps_before : nominal_.steps_before;
    one.steps.assign(lanes_ ? segments_[k].steps.size() : nominal_.count, nominal_.step);
    one.gaps.assign(one.steps.size(), nominal_.gap);
    one.dropped.assign(one.steps.size(), 0);
    if (k == 0 && !one.gaps.empty() && !segments_[0].gaps.empty()) one.gaps[0] = segments_[0].gaps[0];
  }
  for (const Perturbation& p : perturbations) {  // the numbers of steps come first
    if (p.kind != Perturbation::Kind::count) continue;
    const auto count = static_cast<std::size_t>(std::max<std::int64_t>(p.nominal + p.deviation, 0));
    all[p.segment].steps.resize(count, nominal_.step);
    all[p.segment].gaps.resize(count, nominal_.gap);
    all[p.segment].dropped.resize(count, 0);
  }
  for (const Perturbation& p : perturbations) {
    Lengths& one = all[p.segment];
    const std::int64_t value = p.nominal + p.deviation;
    if (p.kind == Perturbation::Kind::visualization) one.visualization = value;
    if (p.kind == Perturbation::Kind::visualization_gap) one.visualization_gap = value;
    if (p.step >= one.steps.size()) continue;
    if (p.kind == Perturbation::Kind::step) one.steps[p.step] = value;
    if (p.kind == Perturbation::Kind::step_gap) one.gaps[p.step] = value;
    if (p.kind == Perturbation::Kind::dropped) one.dropped[p.step] = value;
  }
  return all;
}

std::vector<SegmentTiming> TimingShape::in_turn(const std::vector<Lengths>& all) const {
  std::vector<SegmentTiming> segments;
  Cursor cursor;
  for (const Lengths& one : all) {
    SegmentTiming& segment = segments.emplace_back();
    const auto k = std::ssize(segments) - 1;
    segment.index = k;
    if (grid_) cursor.now = std::max(cursor.now, tick_time(*grid_, k).ns);
    segment.begin = RealTime{cursor.now};
    const auto show = [&] {
      if (one.visualization <= 0) return;
      // With steps first, the visualization ends on the grid if it can.
      const std::int64_t last = grid_ && one.steps_before > 0 ? tick_time(*grid_, k + 1).ns - one.visualization : cursor.now;
      segment.visualization =
          cursor.take(grid_ ? std::max<std::int64_t>(last - cursor.now, 0) : one.visualization_gap, one.visualization);
    };
    for (std::size_t i = 0; i < one.steps.size(); ++i) {
      if (i == one.steps_before) show();
      segment.steps.push_back(cursor.take(grid_ ? 0 : one.gaps[i], one.steps[i]));
    }
    if (one.steps_before >= one.steps.size()) show();
    if (grid_) cursor.now = std::max(cursor.now, tick_time(*grid_, k + 1).ns);
    segment.end = RealTime{cursor.now};
  }
  return segments;
}

/// Places each lane on its own; a segment contains the steps that begin in it.
std::vector<SegmentTiming> TimingShape::side_by_side(const std::vector<Lengths>& all) const {
  std::vector<SegmentTiming> segments;
  Cursor lane;
  for (const Lengths& one : all) {
    SegmentTiming& segment = segments.emplace_back();
    segment.index = std::ssize(segments) - 1;
    if (grid_) lane.now = std::max(lane.now, tick_time(*grid_, segment.index).ns);
    segment.visualization = lane.take(grid_ ? 0 : one.visualization_gap, one.visualization);
    segment.begin = segment.visualization->begin;
    segment.end = segment.visualization->end;
    if (one.visualization <= 0) segment.visualization.reset();
  }
  std::size_t k = 0;
  Cursor steps;
  for (std::size_t i = 0; i < all.front().steps.size(); ++i) {
    const Interval step = steps.take(all.front().gaps[i], all.front().steps[i]);
    while (k + 1 < segments.size() && segments[k + 1].begin <= step.begin) ++k;
    segments[k].steps.push_back(step);
    segments[k].end = std::max(segments[k].end, step.end);
  }
  return segments;
}

void TimingShape::put_clock(const std::vector<Lengths>& all, std::vector<SegmentTiming>& segments) const {
  std::int64_t number = first_step_;
  std::size_t n = 0;
  for (std::size_t k = 0; k < segments.size(); ++k) {
    for (std::size_t i = 0; i < segments[k].steps.size(); ++i, ++n) {
      number += lanes_ ? all.front().dropped[n] : all[k].dropped[i];
      segments[k].simulated.push_back(sim_time(*clock_, number++));
    }
  }
}

std::vector<SegmentTiming> TimingShape::build(const std::vector<Perturbation>& perturbations, std::size_t segments) const {
  const std::vector<Lengths> all = lengths(perturbations);
  std::vector<SegmentTiming> out = lanes_ ? side_by_side(all) : in_turn(all);
  if (clock_) put_clock(all, out);
  out.resize(std::min(segments, out.size()));
  return out;
}

}  // namespace evenstep::internal
