// Error of the felt force against cost, and its parts.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "evenstep/reports/felt_study_record.h"
#include "writers/figures/svg.h"
#include "writers/texts/study_table.h"

namespace evenstep {
namespace {

using internal::Panel;
using internal::Point;
using internal::Range;
using internal::Svg;

constexpr double kWidth = 1100, kLegend = 860;
constexpr internal::Box kCost{90, 50, 840, 430};
constexpr internal::Box kParts{90, 530, 1080, 730};

// The first three are the colours of direct, paper and phase_locked in the figures of a run.
constexpr std::array kColours{internal::colour::kVermilion, internal::colour::kSkyBlue, internal::colour::kBlack,
                              internal::colour::kGreen,     internal::colour::kPurple,  internal::colour::kOrange,
                              internal::colour::kBlue,      internal::colour::kGrey};
constexpr std::array kDashes{"", "7 3", "2 3", "12 3 2 3", "1 5", "10 6"};

/// The points of one strategy with one solver, method and number of iterations.
struct Line {
  std::vector<const FeltPoint*> points;
  std::size_t strategy = 0, method = 0;  ///< which colour and which dash
};

bool shown(const FeltPoint& point) {
  return point.state == StudyCell::State::measured && point.total.rms_N > 0 && point.cpu.median > 0;
}

std::string method_of(const FeltPoint& point) {
  return fmt::format("{}, {}{}", point.method, point.solver,
                     point.iterations > 0 ? fmt::format(", {} it", point.iterations) : "");
}

std::size_t index_in(std::vector<std::string>& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  names.push_back(name);
  return names.size() - 1;
}

struct Lines {
  std::vector<std::string> strategies, methods;
  std::vector<Line> lines;
};

Lines lines_of(const FeltStudyRecord& study) {
  Lines all;
  for (const FeltPoint& point : study.points) {
    const std::size_t strategy = index_in(all.strategies, point.strategy), method = index_in(all.methods, method_of(point));
    if (!shown(point)) continue;
    const bool same = !all.lines.empty() && all.lines.back().strategy == strategy && all.lines.back().method == method;
    if (!same) all.lines.push_back({{}, strategy, method});
    all.lines.back().points.push_back(&point);
  }
  return all;
}

const char* colour_of(std::size_t strategy) { return kColours[strategy % kColours.size()]; }
const char* dash_of(std::size_t method) { return kDashes[method % kDashes.size()]; }

Range decades(const std::vector<double>& values) {
  constexpr double kMost = 9;  // decades; far below the greatest error there is only rounding
  double least = INFINITY, most = 0;
  for (const double value : values) {
    if (!(value > 0) || std::isinf(value)) continue;
    least = std::min(least, value);
    most = std::max(most, value);
  }
  if (most == 0) return {-1, 1};
  const double high = std::ceil(std::log10(most) + 0.05);
  return {std::clamp(std::floor(std::log10(least) - 0.05), high - kMost, high - 1), high};
}

void draw_cost(Svg& svg, const FeltStudyRecord& study, const Lines& all) {
  std::vector<double> errors, costs{1};
  for (const Line& line : all.lines) {
    for (const FeltPoint* point : line.points) {
      errors.push_back(point->total.rms_N);
      costs.insert(costs.end(), {point->cpu.min, point->cpu.max});
    }
  }
  const Range error = decades(errors), cost = decades(costs);
  Panel panel(svg, kCost, {cost, "CPU time per simulated time", "s/s", true}, {error, "felt error, rms", "N", true});
  panel.draw_axes(true, true);
  svg.line(panel.at(0, error.low), panel.at(0, error.high), {internal::colour::kGrey, 1.2, "8 4", 1});
  svg.text({panel.x_at(0) - 5, kCost.top + 14}, "real time", Svg::Anchor::end, 11);
  const double floor = std::log10(study.reference.estimate_N);
  if (floor > error.low && floor < error.high) {
    svg.line({kCost.left, panel.y_at(floor)}, {kCost.right, panel.y_at(floor)}, {internal::colour::kGrey, 1.2, "2 3", 1});
    svg.text({kCost.right - 6, panel.y_at(floor) - 4}, "reference's own error", Svg::Anchor::end, 11);
  }
  for (const Line& line : all.lines) {
    std::vector<double> x, y;
    for (const FeltPoint* point : line.points) {
      x.push_back(std::log10(point->cpu.median));
      y.push_back(std::max(std::log10(point->total.rms_N), error.low));
    }
    const char* colour = colour_of(line.strategy);
    // Points that coincide must all be visible, so the first are the largest.
    const double radius = 3.5 + 1.5 * static_cast<double>(all.strategies.size() - 1 - line.strategy);
    panel.curve(x, y, {colour, 1.8, dash_of(line.method), 1});
    for (std::size_t i = 0; i < x.size(); ++i) {
      svg.line(panel.at(std::log10(line.points[i]->cpu.min), y[i]), panel.at(std::log10(line.points[i]->cpu.max), y[i]),
               {colour, 1, "", 0.6});
      svg.dot(panel.at(x[i], y[i]), radius, colour);
    }
  }
}

std::string latency_of(const FeltStudyRecord& study, const std::string& strategy) {
  for (const FeltPoint& point : study.points) {
    if (point.strategy == strategy && point.state == StudyCell::State::measured)
      return fmt::format("latency {}", latency_text(point));
  }
  return "no point";
}

void draw_legend(Svg& svg, const FeltStudyRecord& study, const Lines& all) {
  Point at{kLegend, kCost.top + 10};
  for (std::size_t s = 0; s < all.strategies.size(); ++s) {
    svg.dot({at.x + 8, at.y}, 4, colour_of(s));
    svg.text({at.x + 20, at.y + 4}, all.strategies[s], Svg::Anchor::start, 12, true);
    svg.text({at.x + 20, at.y + 19}, latency_of(study, all.strategies[s]), Svg::Anchor::start, 11);
    at.y += 38;
  }
  for (std::size_t m = 0; m < all.methods.size(); ++m, at.y += 17) {
    svg.line(at, {at.x + 34, at.y}, {internal::colour::kBlack, 1.8, dash_of(m), 1});
    svg.text({at.x + 40, at.y + 4}, all.methods[m], Svg::Anchor::start, 11);
  }
  at.y += 4;
  for (const char* line : {"Latency: strategy + device. Each force", "is compared at its own latency.",
                           "Bars: least to greatest of the repeats."})
    svg.text({at.x, at.y += 15}, line, Svg::Anchor::start, 11);
  std::ptrdiff_t missing =
      std::count_if(study.points.begin(), study.points.end(), [](const FeltPoint& p) { return !shown(p); });
  if (missing > 0)
    svg.text({at.x, at.y += 20}, fmt::format("{} points without a place here", missing), Svg::Anchor::start, 11);
}

struct Part {
  const char* name;
  FeltError FeltPoint::*error;
  const char* colour;
};
constexpr std::array kPartsOf{Part{"discretisation", &FeltPoint::discretisation, internal::colour::kBlue},
                              Part{"remap", &FeltPoint::remap, internal::colour::kOrange},
                              Part{"device", &FeltPoint::device, internal::colour::kGreen}};

/// One point: its parts as bars, its whole error as a line across.
void draw_point(Svg& svg, const Panel& panel, double x, const FeltPoint& point, double low) {
  const auto at = [&](double newtons, double aside) {
    return panel.at(x + aside, newtons > 0 ? std::max(std::log10(newtons), low) : low);
  };
  for (std::size_t p = 0; p < kPartsOf.size(); ++p) {
    const Point top = at((point.*kPartsOf[p].error).rms_N, 0.24 * (static_cast<double>(p) - 1));
    svg.line({top.x, kParts.bottom}, top, {kPartsOf[p].colour, 4, "", 0.85});
  }
  svg.line(at(point.total.rms_N, -0.42), at(point.total.rms_N, 0.42), {internal::colour::kBlack, 1.6, "", 1});
  svg.text({panel.x_at(x), kParts.bottom + 13}, fmt::format("{:.3g}", point.substep_s * 1e3), Svg::Anchor::middle, 9);
}

void draw_parts_legend(Svg& svg) {
  Point at{kParts.left, kParts.top - 36};
  svg.line(at, {at.x + 20, at.y}, {internal::colour::kBlack, 1.6, "", 1});
  svg.text({at.x + 26, at.y + 4}, "felt error");
  at.x += 110;
  for (const Part& part : kPartsOf) {
    svg.line({at.x, at.y + 5}, {at.x, at.y - 7}, {part.colour, 4, "", 0.85});
    svg.text({at.x + 10, at.y + 4}, part.name);
    at.x += 120;
  }
  svg.text({at.x, at.y + 4}, "below each point: its step in ms", Svg::Anchor::start, 11);
}

/// Every point beside the others, by strategy and method.
void draw_parts(Svg& svg, const FeltStudyRecord& study, const Lines& all) {
  std::vector<double> errors;
  double count = 0;
  for (const FeltPoint& point : study.points) {
    if (!shown(point)) continue;
    ++count;
    errors.push_back(point.total.rms_N);
    for (const Part& part : kPartsOf) errors.push_back((point.*part.error).rms_N);
  }
  const Range range = decades(errors);
  Panel panel(svg, kParts, {{-0.5, std::max(count, 1.0) - 0.5}, "", "", false}, {range, "rms", "N", true});
  panel.draw_axes(false, false);
  double x = 0;
  std::size_t strategy = all.strategies.size();  // none yet
  for (const Line& line : all.lines) {
    const double from = panel.x_at(x - 0.5), middle = panel.x_at(x + static_cast<double>(line.points.size()) / 2 - 0.5);
    if (line.strategy != strategy) {
      strategy = line.strategy;
      svg.line({from, kParts.top - 20}, {from, kParts.bottom}, {internal::colour::kBlack, 1, "", 1});
      svg.text({from + 5, kParts.top - 7}, all.strategies[strategy], Svg::Anchor::start, 12, true, colour_of(strategy));
    }
    svg.text({middle, kParts.bottom + 27}, line.points.front()->method, Svg::Anchor::middle, 10);
    for (const FeltPoint* point : line.points) draw_point(svg, panel, x++, *point, range.low);
  }
  draw_parts_legend(svg);
}

}  // namespace

std::string felt_study_svg(const FeltStudyRecord& study) {
  const Lines all = lines_of(study);
  Svg svg(kWidth, kParts.bottom + 82,
          fmt::format("Error against cost: {}", study.scenario.empty() ? study.file : study.scenario));
  draw_cost(svg, study, all);
  draw_legend(svg, study, all);
  draw_parts(svg, study, all);
  const double foot = kParts.bottom + 52;
  svg.text({kParts.left, foot},
           fmt::format("{}. Judged: {:.6g} s to {:.6g} s of {:.6g} s, {} ticks; {:.3g} N rms.", study.scene,
                       study.judged_from_s, study.judged_to_s, study.run_to_s, study.ticks, study.reference.scale_N),
           Svg::Anchor::start, 10);
  svg.text(
      {kParts.left, foot + 14},
      fmt::format("{}. {}, evenstep {}.", internal::machine_text(study.machine, study.cpus), study.compiler, study.version),
      Svg::Anchor::start, 10);
  return std::move(svg).finish();
}

}  // namespace evenstep
