#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>

#include "evenstep/reports/figures.h"
#include "src/judged.h"
#include "writers/figures/failure_marks.h"
#include "writers/figures/svg.h"

namespace evenstep {
namespace {

using internal::Svg;
namespace colour = internal::colour;

// Top to bottom as in the paper's Figures 3 and 4: the hand, the slots, the steps as they ran, the forces.
constexpr double kWidth = 900, kHeight = 600, kLeft = 96, kRight = 880;
constexpr internal::Box kHand{kLeft, 66, kRight, 190}, kForce{kLeft, 418, kRight, 550};
constexpr double kSlotTop = 226, kSlotBottom = 250, kStepTop = 310, kStepBottom = 334, kEmission = 396;
constexpr const char* kStepFill = "#b9dff5";   // pale kSkyBlue: numbers on it stay readable
constexpr const char* kSlotFill = "#bfe5d9";   // pale kGreen
constexpr const char* kPauseFill = "#f6d58a";  // pale kOrange

/// One segment of one strategy and device.
struct View {
  const SegmentRow* segment = nullptr;
  Rows<std::size_t> steps;
  bool mapped = false;  ///< false: direct has no slots
  internal::Range time_s;
  std::vector<double> tick_s, tick_position_m, tick_force_N;
  std::vector<double> read_s, position_m, emission_s, force_N;
};

Rows<std::size_t> steps_of(const StrategyRecord& strategy, const Rows<std::size_t>& judged, std::int64_t segment) {
  Rows<std::size_t> steps;
  std::copy_if(judged.begin(), judged.end(), std::back_inserter(steps),
               [&](std::size_t n) { return strategy.steps[n].segment == segment; });
  return steps;
}

/// The segment of the last judged step that began at or before `at`, or the one in the middle of those judged.
const SegmentRow* shown_segment(const StrategyRecord& strategy, const Rows<std::size_t>& judged,
                                std::optional<RealTime> at) {
  if (judged.empty()) return nullptr;
  std::size_t shown = judged[judged.size() / 2];
  if (at) {
    const auto after =
        std::find_if(judged.begin(), judged.end(), [&](std::size_t n) { return strategy.steps[n].begin > *at; });
    shown = after == judged.begin() ? *after : *std::prev(after);
  }
  const std::int64_t index = strategy.steps[shown].segment;
  const auto found = std::find_if(strategy.segments.begin(), strategy.segments.end(),
                                  [&](const SegmentRow& s) { return s.index == index; });
  return found == strategy.segments.end() ? nullptr : &*found;
}

/// The axis along which the hand moved farthest in the segment.
std::size_t main_axis(const DeviceRecord& device, const Rows<std::size_t>& steps) {
  const Vec3 &first = device.steps.at(steps.front()).position_m, &last = device.steps.at(steps.back()).position_m;
  std::size_t best = 0;
  for (std::size_t axis = 1; axis < 3; ++axis) {
    if (std::abs(last[axis] - first[axis]) > std::abs(last[best] - first[best])) best = axis;
  }
  return best;
}

std::optional<View> view_of(const RunRecord& run, const StrategyRecord& strategy, const DeviceRecord& device,
                            std::optional<RealTime> at) {
  const Rows<std::size_t> judged = internal::judged_steps(strategy, run.nominal);
  View view;
  view.segment = shown_segment(strategy, judged, at);
  if (!view.segment) return std::nullopt;
  view.steps = steps_of(strategy, judged, view.segment->index);
  view.mapped = strategy.steps[view.steps.front()].mapped;
  const std::size_t axis = main_axis(device, view.steps);
  RealTime from = view.segment->begin, to = view.segment->end;
  for (const std::size_t n : view.steps) {
    const StepRow& step = strategy.steps[n];
    from = std::min(from, step.read);
    to = std::max({to, step.end, step.emission});
    view.read_s.push_back(seconds(step.read));
    view.position_m.push_back(device.steps[n].position_m[axis]);
    view.emission_s.push_back(seconds(step.emission));
    view.force_N.push_back(device.steps[n].force_N[axis]);
  }
  view.time_s = internal::Range::around({seconds(from), seconds(to)}, 0.02);
  for (const TickRow& tick : device.ticks) {
    const double sent_s = seconds(internal::sent_at(tick));
    if (sent_s < view.time_s.low || sent_s > view.time_s.high) continue;
    view.tick_s.push_back(sent_s);
    view.tick_position_m.push_back(tick.position_m[axis]);
    view.tick_force_N.push_back(tick.force_N[axis]);
  }
  return view;
}

internal::Range joint_range(std::vector<double> a, const std::vector<double>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return internal::Range::around(a, 0.08);
}

void numbered_block(Svg& svg, double from, double to, double top, double bottom, const char* fill,
                    const std::string& number) {
  svg.rect({from, top, to, bottom}, fill, colour::kGrey);
  if (to - from > 7.5 * static_cast<double>(number.size()) + 2) {
    svg.text({(from + to) / 2, (top + bottom) / 2 + 4}, number, Svg::Anchor::middle, 11);
  }
}

void draw_legend(Svg& svg) {
  double x = kLeft;
  const auto entry = [&](const char* text, auto&& mark) {
    mark(x);
    svg.text({x + 22, 50}, text, Svg::Anchor::start, 11);
    x += 36 + 6.9 * static_cast<double>(std::string_view(text).size());
  };
  const auto trace = [&](const char* colour) {
    return [&svg, colour](double at) {
      svg.line({at, 46}, {at + 16, 46}, {colour, 1.2});
      svg.dot({at + 8, 46}, 2.4, colour);
    };
  };
  const auto square = [&](const char* colour) { return [&svg, colour](double at) { svg.square({at + 8, 46}, 4, colour); }; };
  const auto block = [&](const char* fill) {
    return [&svg, fill](double at) { svg.rect({at, 40, at + 16, 52}, fill, colour::kGrey); };
  };
  entry("device sample", trace(colour::kBlue));
  entry("read by a step", square(colour::kVermilion));
  entry("visualization", block(kPauseFill));
  entry("force sent", trace(colour::kGreen));
  entry("force of a step", square(colour::kPurple));
}

void draw_rows(Svg& svg, const internal::Panel& time, const RunRecord& run, const StrategyRecord& strategy,
               const View& view) {
  const auto x = [&](RealTime t) { return time.x_at(seconds(t)); };
  svg.text({kLeft - 8, (kSlotTop + kSlotBottom) / 2 + 4}, "slots", Svg::Anchor::end);
  svg.text({kLeft - 8, (kStepTop + kStepBottom) / 2 + 4}, "steps ran", Svg::Anchor::end);
  svg.text({kLeft - 8, kEmission + 4}, "emission", Svg::Anchor::end);
  for (const double y : {kSlotBottom, kStepBottom, kEmission}) svg.line({kLeft, y}, {kRight, y}, {colour::kGrey, 1});
  if (view.segment->visualization) {
    const auto [begin, end] = *view.segment->visualization;
    svg.rect({x(begin), kStepTop, x(end), kStepBottom}, kPauseFill, colour::kGrey);
    if (x(end) - x(begin) > 90) svg.text({(x(begin) + x(end)) / 2, kStepTop + 16}, "visualization", Svg::Anchor::middle, 11);
  }
  if (!view.mapped) svg.text({kLeft + 8, kSlotBottom - 8}, "none: newest sample", Svg::Anchor::start, 11);
  const internal::Stroke map{"#555555", 1, "", 0.8};
  const Duration slot{static_cast<std::int64_t>(run.nominal.slot_s * 1e9)};
  for (std::size_t i = 0; i < view.steps.size(); ++i) {
    const StepRow& step = strategy.steps[view.steps[i]];
    const std::string number = fmt::format("{}", i + 1);
    if (view.mapped)
      numbered_block(svg, x(step.read), std::min(x(step.read + slot), kRight), kSlotTop, kSlotBottom, kSlotFill, number);
    numbered_block(svg, x(step.begin), x(step.end), kStepTop, kStepBottom, kStepFill, number);
    svg.line({x(step.begin), kStepTop}, {x(step.read), kSlotBottom}, map);
    svg.line({x(step.end), kStepBottom}, {x(step.emission), kEmission}, map);
    svg.dot({x(step.emission), kEmission}, 2.6, colour::kPurple);
  }
}

void draw_panels(Svg& svg, const View& view) {
  const internal::Axis time{view.time_s, "real time", "s"};
  internal::Panel hand(svg, kHand, time, {joint_range(view.tick_position_m, view.position_m), "hand", "m"});
  internal::Panel force(svg, kForce, time, {joint_range(view.tick_force_N, view.force_N), "force", "N"});
  hand.draw_axes(false, false);
  force.draw_axes(true, true);
  const internal::Stroke drop{colour::kGrey, 0.8, "2 3", 1};
  for (std::size_t i = 0; i < view.steps.size(); ++i) {
    svg.line(hand.at(view.read_s[i], view.position_m[i]), {hand.x_at(view.read_s[i]), view.mapped ? kSlotTop : kSlotBottom},
             drop);
    svg.line({force.x_at(view.emission_s[i]), kEmission}, force.at(view.emission_s[i], view.force_N[i]), drop);
  }
  hand.curve(view.tick_s, view.tick_position_m, {colour::kBlue, 1.2});
  force.curve(view.tick_s, view.tick_force_N, {colour::kGreen, 1.2});
  for (std::size_t i = 0; i < view.tick_s.size(); ++i) {
    svg.dot(hand.at(view.tick_s[i], view.tick_position_m[i]), 2, colour::kBlue);
    svg.dot(force.at(view.tick_s[i], view.tick_force_N[i]), 2, colour::kGreen);
  }
  for (std::size_t i = 0; i < view.steps.size(); ++i) {
    svg.square(hand.at(view.read_s[i], view.position_m[i]), 3.4, colour::kVermilion);
    svg.square(force.at(view.emission_s[i], view.force_N[i]), 3.4, colour::kPurple);
  }
}

/// The first result that fails for this strategy and device.
const ExpectationResult* failed_for(std::span<const ExpectationResult> results, const std::string& strategy,
                                    const std::string& device) {
  for (const ExpectationResult& result : results) {
    if (result.worst && result.signal.starts_with(device + '.') && result.signal.ends_with('.' + strategy)) return &result;
  }
  return nullptr;
}

}  // namespace

std::string figure_2to4_svg(const RunRecord& run, const std::string& strategy_name, const std::string& device_name,
                            std::span<const ExpectationResult> results) {
  const ExpectationResult* const failed = failed_for(results, strategy_name, device_name);
  const std::optional<RealTime> at = failed ? std::optional(failed->worst->at) : std::nullopt;
  Svg svg(kWidth, kHeight, fmt::format("One time segment of {}: {}", strategy_name, device_name));
  for (const StrategyRecord& strategy : run.strategies) {
    if (strategy.name != strategy_name) continue;
    for (const DeviceRecord& device : strategy.devices) {
      if (device.name != device_name) continue;
      const std::optional<View> view = view_of(run, strategy, device, at);
      if (!view) break;
      draw_legend(svg);
      draw_rows(svg, internal::Panel(svg, kHand, {view->time_s, "", "s"}, {}), run, strategy, *view);
      draw_panels(svg, *view);
      if (at) {
        const double x = internal::Panel(svg, kHand, {view->time_s, "", "s"}, {}).x_at(seconds(*at));
        internal::draw_mark(svg, x, {kLeft, kHand.top, kRight, kForce.bottom}, kHand.bottom + 22, "worst failure");
      }
      return std::move(svg).finish();
    }
  }
  svg.text({kWidth / 2, kHeight / 2}, "nothing was judged here", Svg::Anchor::middle, 14);
  return std::move(svg).finish();
}

}  // namespace evenstep
