#include "evenstep/reports/pause_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "evenstep/reports/run_record.h"

namespace evenstep {
namespace {

constexpr std::int64_t kNamedPart = 100;  // a part below a hundredth of the pause is not worth naming

double ms(Duration duration) { return static_cast<double>(duration.ns) * 1e-6; }
Duration length(const Interval& time) { return time.end - time.begin; }

}  // namespace

std::string text(const PauseParts& pause) {
  std::string parts;
  const auto part = [&](Duration length, const char* what) {
    if (length.ns > 0 && length * kNamedPart >= pause.length)
      parts += fmt::format("{}{:.3g} are {}", parts.empty() ? "" : ", ", ms(length), what);
  };
  part(pause.drawing, "drawing");
  part(pause.waiting, "waiting");
  if (pause.is_material(pause.unrecorded)) part(pause.unrecorded, "not recorded (waiting, or other work)");
  if (parts.empty()) return "";
  parts = fmt::format("Of the longest pause, {:.3g} ms, {}.", ms(pause.length), parts);
  if (pause.is_material(pause.waiting) && pause.steps.ns > 0)
    parts += fmt::format(" The steps take {:.3g} of {:.4g} ms.", ms(pause.steps), ms(pause.segment));
  return parts;
}

void LongestPause::add_segment(const Interval& segment, const std::optional<Interval>& drawing,
                               std::span<const Interval> steps, bool beside) {
  if (segment_before_) segment_length_ = segment.begin - *segment_before_;
  segment_before_ = segment.begin;
  const Duration drawn = drawing && !beside ? length(*drawing) : Duration{};
  const bool drawn_first = drawing && (steps.empty() || drawing->begin < steps.front().begin);
  if (drawn_first) drawing_ += drawn;
  RealTime work_end = drawing ? drawing->end : segment.begin;
  Duration in_steps;
  for (const Interval& step : steps) {
    if (step_before_ && step.end - step_before_->begin > needs_) {
      needs_ = step.end - step_before_->begin;
      longest_ = {step.begin - step_before_->end, drawing_, waiting_, {}, steps_, segment_length_};
    }
    step_before_ = step;
    drawing_ = waiting_ = {};
    in_steps += length(step);
    work_end = std::max(work_end, step.end);
  }
  if (!drawn_first) drawing_ += drawn;
  waiting_ += std::max(segment.end - work_end, Duration{});
  steps_ = in_steps;
}

PauseParts LongestPause::parts() const {
  PauseParts parts = longest_;
  parts.length = std::max(parts.length, Duration{});
  parts.drawing = std::min(parts.drawing, parts.length);
  parts.waiting = std::min(parts.waiting, parts.length - parts.drawing);
  parts.unrecorded = parts.length - parts.drawing - parts.waiting;
  return parts;
}

PauseParts longest_pause(const StrategyRecord& strategy) {
  LongestPause longest;
  std::vector<Interval> steps;
  std::size_t next = 0;
  for (const SegmentRow& row : strategy.segments) {
    std::optional<Interval> drawing;
    if (row.visualization) drawing = {(*row.visualization)[0], (*row.visualization)[1]};
    bool beside = false;
    steps.clear();
    for (; next < strategy.steps.size() && strategy.steps[next].segment <= row.index; ++next) {
      const StepRow& step = strategy.steps[next];
      steps.push_back({step.begin, step.end});
      beside = beside || (drawing && step.begin < drawing->end && drawing->begin < step.end);
    }
    longest.add_segment({row.begin, row.end}, drawing, steps, beside);
  }
  return longest.parts();
}

}  // namespace evenstep
