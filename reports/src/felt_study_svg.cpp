// Error of the felt force against cost, and its parts.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "evenstep/reports/felt_study_record.h"
#include "src/svg.h"

namespace evenstep {
namespace {

using internal::Panel;
using internal::Point;
using internal::Range;
using internal::Svg;

constexpr double kWidth = 1100, kLegend = 860;
constexpr internal::Box kCost{90, 50, 840, 430};
constexpr double kPartsTop = 500, kPartsHeight = 190, kPartsLeft = 90, kGap = 26, kRight = 1080;

constexpr std::array kColours{internal::colour::kVermilion, internal::colour::kBlue,   internal::colour::kBlack,
                              internal::colour::kGreen,     internal::colour::kOrange, internal::colour::kPurple,
                              internal::colour::kSkyBlue,   internal::colour::kGrey};
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
    panel.curve(x, y, {colour, 1.8, dash_of(line.method), 1});
    for (std::size_t i = 0; i < x.size(); ++i) {
      svg.line(panel.at(std::log10(line.points[i]->cpu.min), y[i]), panel.at(std::log10(line.points[i]->cpu.max), y[i]),
               {colour, 1, "", 0.6});
      svg.dot(panel.at(x[i], y[i]), 4, colour);
    }
  }
}

std::string latency_of(const FeltStudyRecord& study, const std::string& strategy) {
  for (const FeltPoint& point : study.points) {
    if (point.strategy == strategy && point.state == StudyCell::State::measured)
      return fmt::format("latency {:.3f} + {:.3f} ms", point.latency_s * 1e3, point.device_latency_s * 1e3);
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
constexpr std::array kParts{Part{"discretisation", &FeltPoint::discretisation, internal::colour::kBlue},
                            Part{"remap", &FeltPoint::remap, internal::colour::kOrange},
                            Part{"device", &FeltPoint::device, internal::colour::kGreen}};

/// For each strategy a panel; in it for each point, from the cheapest method's coarsest step on, the parts beside the whole.
void draw_parts(Svg& svg, const FeltStudyRecord& study, const Lines& all) {
  std::vector<double> errors;
  for (const FeltPoint& point : study.points) {
    if (!shown(point)) continue;
    errors.push_back(point.total.rms_N);
    for (const Part& part : kParts) errors.push_back((point.*part.error).rms_N);
  }
  const Range range = decades(errors);
  const auto count = static_cast<double>(std::max<std::size_t>(all.strategies.size(), 1));
  const double width = (kRight - kPartsLeft - kGap * (count - 1)) / count;
  for (std::size_t s = 0; s < all.strategies.size(); ++s) {
    const double left = kPartsLeft + static_cast<double>(s) * (width + kGap);
    const internal::Box box{left, kPartsTop, left + width, kPartsTop + kPartsHeight};
    std::vector<const FeltPoint*> points;
    for (const Line& line : all.lines) {
      if (line.strategy == s) points.insert(points.end(), line.points.begin(), line.points.end());
    }
    const double high = static_cast<double>(points.size()) - 0.5;
    Panel panel(svg, box, {{-0.5, std::max(high, 0.5)}, "", "", false},
                {range, s == 0 ? "rms" : "", s == 0 ? "N" : "", true});
    panel.draw_axes(false, false);
    svg.text({left, kPartsTop - 8}, all.strategies[s], Svg::Anchor::start, 12, true, colour_of(s));
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto at = [&](double newtons, double aside) {
        return panel.at(static_cast<double>(i) + aside, std::max(newtons > 0 ? std::log10(newtons) : range.low, range.low));
      };
      const Point whole = at(points[i]->total.rms_N, 0);
      svg.line({whole.x - 0.42 * width / (high + 0.5), whole.y}, {whole.x + 0.42 * width / (high + 0.5), whole.y},
               {internal::colour::kBlack, 1.6, "", 1});
      for (std::size_t p = 0; p < kParts.size(); ++p) {
        const double aside = 0.24 * (static_cast<double>(p) - 1);
        const Point top = at((points[i]->*kParts[p].error).rms_N, aside);
        svg.line({top.x, kPartsTop + kPartsHeight}, top, {kParts[p].colour, 3, "", 0.85});
      }
      const std::string step = fmt::format("{:.3g}", points[i]->substep_s * 1e3);
      svg.text({panel.x_at(static_cast<double>(i)), kPartsTop + kPartsHeight + 14}, step, Svg::Anchor::middle, 9);
    }
    double from = 0;
    for (const Line& line : all.lines) {
      if (line.strategy != s) continue;
      const auto steps = static_cast<double>(line.points.size());
      svg.text({panel.x_at(from + steps / 2 - 0.5), kPartsTop + kPartsHeight + 28}, line.points.front()->method,
               Svg::Anchor::middle, 10);
      from += steps;
    }
  }
  Point at{kPartsLeft, kPartsTop - 32};
  svg.line(at, {at.x + 20, at.y}, {internal::colour::kBlack, 1.6, "", 1});
  svg.text({at.x + 26, at.y + 4}, "felt error");
  at.x += 110;
  for (const Part& part : kParts) {
    svg.line({at.x, at.y + 5}, {at.x, at.y - 7}, {part.colour, 4, "", 0.85});
    svg.text({at.x + 10, at.y + 4}, part.name);
    at.x += 120;
  }
  svg.text({at.x, at.y + 4}, "below each point: its step in ms", Svg::Anchor::start, 11);
}

}  // namespace

std::string felt_study_svg(const FeltStudyRecord& study) {
  const Lines all = lines_of(study);
  Svg svg(kWidth, kPartsTop + kPartsHeight + 82,
          fmt::format("Error against cost: {}", study.scenario.empty() ? study.file : study.scenario));
  draw_cost(svg, study, all);
  draw_legend(svg, study, all);
  draw_parts(svg, study, all);
  const double foot = kPartsTop + kPartsHeight + 56;
  svg.text({kPartsLeft, foot},
           fmt::format("{}. Judged: {:.6g} s to {:.6g} s of {:.6g} s, {} ticks; {:.3g} N rms.", study.scene,
                       study.judged_from_s, study.judged_to_s, study.run_to_s, study.ticks, study.reference.scale_N),
           Svg::Anchor::start, 10);
  svg.text({kPartsLeft, foot + 14},
           fmt::format("{}, {} processors. {}, evenstep {}.", study.machine, study.cpus, study.compiler, study.version),
           Svg::Anchor::start, 10);
  return std::move(svg).finish();
}

}  // namespace evenstep
