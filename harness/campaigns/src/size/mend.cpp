#include "mend.h"

#include <algorithm>

namespace evenstep::internal {
namespace {

constexpr std::int64_t kLatePart = 100;   // an excess below this fraction of a usual step (1 / 100) is not late
constexpr std::size_t kBlamedBefore = 2;  // segments before: at 30 Hz a loop of 2 Hz has mostly forgotten the third one

}  // namespace

Duration median(std::vector<std::int64_t>& values) {
  if (values.empty()) return {};
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return {*middle};
}

Mending::Mending(std::vector<SegmentTiming>& segments) : segments_(segments) {
  first_step_.reserve(segments.size() + 1);
  first_step_.push_back(0);
  for (const SegmentTiming& segment : segments) {
    first_step_.push_back(first_step_.back() + static_cast<std::int64_t>(segment.steps.size()));
    sees_visualizations_ = sees_visualizations_ || segment.visualization.has_value();
    concurrent_ = concurrent_ || segment.overlaps();
  }
  find_pace();
  find_usual();
}

void Mending::find_pace() {
  std::vector<std::int64_t> lengths;
  lengths.reserve(segments_.size());
  for (std::size_t k = 1; k < segments_.size(); ++k) lengths.push_back((segments_[k].begin - segments_[k - 1].begin).ns);
  const Duration usual = median(lengths);
  for (std::int64_t& length : lengths) length = std::abs(length - usual.ns);
  idle_from_ = {usual.ns / 100};
  keeps_time_ = median(lengths) < idle_from_;
}

void Mending::find_usual() {
  std::vector<std::int64_t> lengths;  // the same storage four times
  lengths.reserve(static_cast<std::size_t>(first_step_.back()));
  const auto usual = [&](bool first, auto length) {
    lengths.clear();
    for (std::size_t k = 0; k < segments_.size(); ++k) {
      const std::size_t count = segments_[k].steps.size();
      for (std::size_t i = first ? 0 : 1; i < (first ? std::min<std::size_t>(count, 1) : count); ++i)
        lengths.push_back(length(At{k, i}).ns);
    }
    return median(lengths);
  };
  const auto pause = [&](At at) { return step(at).begin - pause_begin(at); };
  const auto run = [&](At at) { return step(at).end - step(at).begin; };
  first_ = {usual(true, pause), usual(true, run)};
  other_ = {usual(false, pause), usual(false, run)};
  late_from_ = {first_.run.ns / kLatePart};
}

Mending::At Mending::at(std::int64_t step) const {
  const auto after = std::upper_bound(first_step_.begin(), first_step_.end(), step);
  const auto segment = static_cast<std::size_t>(after - first_step_.begin()) - 1;
  return {segment, static_cast<std::size_t>(step - first_step_[segment])};
}

RealTime Mending::pause_begin(At at) const {
  const SegmentTiming& segment = segments_[at.segment];
  if (at.index > 0) return segment.steps[at.index - 1].end;
  const RealTime begin = segment.steps.front().begin;
  if (segment.visualization && segment.visualization->begin < begin) return std::min(segment.visualization->begin, begin);
  if (at.segment == 0 || segments_[at.segment - 1].steps.empty()) return segment.begin;
  return segments_[at.segment - 1].steps.back().end;
}

Duration Mending::pause_excess(At at) const {
  const Duration usual = at.index == 0 ? first_.pause : other_.pause;
  return std::max(step(at).begin - pause_begin(at) - usual, Duration{});
}

Duration Mending::run_excess(At at) const {
  const Duration usual = at.index == 0 ? first_.run : other_.run;
  return std::max(step(at).end - step(at).begin - usual, Duration{});
}

SizeCulprit Mending::culprit(std::int64_t number) const {
  const At place = at(number);
  return {.step = number,
          .segment = segments_[place.segment].index,
          .index = static_cast<std::int64_t>(place.index),
          .begin = step(place).begin};
}

SizeCulprit Mending::blame(std::int64_t number) const {
  SizeCulprit out = culprit(number);
  const std::size_t segment = at(number).segment;
  for (std::int64_t n = first_step_[segment - std::min(segment, kBlamedBefore)]; n <= number; ++n) {
    const Duration pause = pause_excess(at(n)), run = run_excess(at(n));
    if (pause + run <= std::max(out.pause_excess + out.run_excess, late_from_)) continue;
    out.late_step = n;
    out.pause_excess = pause;
    out.run_excess = run;
  }
  return out;
}

SizeCulprit Mending::blame_run_time(std::int64_t number) const {
  SizeCulprit out = culprit(number);
  out.run_excess = run_excess(at(number));
  if (out.run_excess > late_from_) out.late_step = number;
  return out;
}

bool Mending::cut(const SizeCulprit& culprit) {
  if (culprit.late_step < 0) return false;
  const At place = at(culprit.late_step);
  SegmentTiming& segment = segments_[place.segment];
  kept_ = segment;
  moved_from_ = moved_to_ = place.segment + 1;
  moved_by_ = culprit.pause_excess + culprit.run_excess;
  Interval& late = segment.steps[place.index];
  // Without a visualization, a segment begins with its first step.
  if (segment.begin == late.begin) segment.begin = segment.begin - culprit.pause_excess;
  RealTime busy_until = late.end;
  late = {late.begin - culprit.pause_excess, late.end - moved_by_};
  for (std::size_t i = place.index + 1; i < segment.steps.size(); ++i) {
    Interval& step = segment.steps[i];
    if (step.begin - busy_until > idle_from_) return true;
    busy_until = step.end;
    step = {step.begin - moved_by_, step.end - moved_by_};
  }
  if (concurrent_) return true;
  while (moved_to_ < segments_.size() && !waits(moved_to_)) ++moved_to_;
  move(Duration{} - moved_by_);
  return true;
}

void Mending::move(Duration by) {
  for (std::size_t k = moved_from_; k < moved_to_; ++k) {
    segments_[k].begin = segments_[k].begin + by;
    for (Interval& step : segments_[k].steps) step = {step.begin + by, step.end + by};
  }
}

void Mending::restore() {
  move(moved_by_);
  segments_[moved_from_ - 1] = kept_;
}

/// Whether the begin of segment k is determined by its pace, and not by what ran before it.
bool Mending::waits(std::size_t k) const {
  if (!sees_visualizations_) return keeps_time_;
  const SegmentTiming& before = k == moved_from_ ? kept_ : segments_[k - 1];
  RealTime busy_until = before.steps.empty() ? before.begin : before.steps.back().end;
  if (before.visualization && before.visualization->end > busy_until) {
    if (before.visualization->begin - busy_until > idle_from_) return true;
    busy_until = before.visualization->end;
  }
  return segments_[k].begin - busy_until > idle_from_;
}

}  // namespace evenstep::internal
