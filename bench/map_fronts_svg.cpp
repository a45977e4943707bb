#include "map_fronts_svg.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "writers/figures/svg.h"

namespace evenstep::bench {
namespace {

using internal::Axis;
using internal::Box;
using internal::Panel;
using internal::Point;
using internal::Range;
using internal::Stroke;
using internal::Svg;

constexpr int kColumns = 3;
constexpr double kWidth = 1100, kTop = 40, kPanelWidth = 362, kPanelHeight = 262;
constexpr Range kJumps{-2.5, 1};  // in decades of a slot
constexpr double kUsual_Hz = 2;   // this point of a curve is filled
constexpr Stroke kPathStroke{internal::colour::kBlack, 2};
constexpr Stroke kPauseStroke{internal::colour::kGrey, 1.5, "6 4"};
constexpr Stroke kLineStroke{internal::colour::kOrange, 1.5, "2 3"};
constexpr Stroke kMapStrokes[]{{internal::colour::kGreen, 2},
                               {internal::colour::kVermilion, 1.5},
                               {internal::colour::kBlue, 1.5, "8 3"},
                               {internal::colour::kPurple, 1.5, "3 2"}};

Point on(const Panel& panel, const FrontPoint& point) {
  const double x = std::clamp(std::log10(std::max(point.jump, 1e-9)), kJumps.low, kJumps.high);
  return panel.at(x, std::log10(point.latency_ms));
}

/// From the least to the largest latency of the maps, and of any path with jumps like theirs, with some room.
Range latencies_of(const Fronts& fronts) {
  std::vector<double> all{std::log10(fronts.pause_ms)};
  for (const MapFront& map : fronts.maps)
    for (const FrontPoint& point : map.points) all.push_back(std::log10(point.latency_ms));
  for (const FrontPoint& point : fronts.any_path)
    if (std::log10(point.jump) >= kJumps.low && point.jump < 0.3) all.push_back(std::log10(point.latency_ms));
  const auto [least, most] = std::minmax_element(all.begin(), all.end());
  const double middle = (*least + *most) / 2, half = std::max((*most - *least) / 2 + 0.06, 0.15);
  return {middle - half, middle + half};
}

/// Draws lines and numbers at decades of the jump and at round latencies.
void draw_grid(Svg& svg, const Panel& panel, const Box& box, Range latencies) {
  const auto number = [](double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", value);
    return std::string(text);
  };
  const std::vector<double> wide{1, 2, 5}, narrow{1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8};
  for (double decade = -2; decade <= 4; ++decade) {
    for (const double mantissa : latencies.high - latencies.low > 0.6 ? wide : narrow) {
      const double value = mantissa * std::pow(10.0, decade), y = panel.y_at(std::log10(value));
      if (y < box.top || y > box.bottom) continue;
      svg.line({box.left, y}, {box.right, y}, {internal::colour::kGrid, 1});
      svg.text({box.left - 6, y + 4}, number(value), Svg::Anchor::end, 11);
    }
    const double x = panel.x_at(decade);
    if (decade > kJumps.high) continue;
    svg.line({x, box.top}, {x, box.bottom}, {internal::colour::kGrid, 1});
    svg.text({x, box.bottom + 15}, number(std::pow(10.0, decade)), Svg::Anchor::middle, 11);
  }
  svg.rect(box, "none", internal::colour::kGrey);
}

void draw_map(Svg& svg, const Panel& panel, const MapFront& map, const Stroke& stroke) {
  std::vector<Point> points;
  for (const FrontPoint& point : map.points) points.push_back(on(panel, point));
  svg.polyline(points, stroke);
  for (const Point& point : points) {
    svg.dot(point, 3, stroke.colour);
    svg.dot(point, 1.8, "#ffffff");
  }
  svg.dot(on(panel, at_bandwidth(map, kUsual_Hz)), 5, stroke.colour);
}

void draw_panel(Svg& svg, const Fronts& fronts, double left, double top) {
  const Box box{left + 44, top + 24, left + kPanelWidth - 10, top + kPanelHeight - 40};
  const Range latencies = latencies_of(fronts);
  Panel panel(svg, box, Axis{kJumps, "", "", true}, Axis{latencies, "", "", true});
  draw_grid(svg, panel, box, latencies);
  svg.text({box.left, top + 17}, fronts.recording, Svg::Anchor::start, 12, true);
  const double line = std::log10(fronts.best_line_ms), pause = std::log10(fronts.pause_ms);
  if (line <= latencies.high) {
    panel.curve({kJumps.low, kJumps.high}, {line, line}, kLineStroke);
  } else {
    char text[64];
    std::snprintf(text, sizeof text, "line: %.0f ms", fronts.best_line_ms);
    svg.text({box.right, top + 17}, text, Svg::Anchor::end, 11, false, internal::colour::kGrey);
  }
  panel.curve({kJumps.low, kJumps.high}, {pause, pause}, kPauseStroke);
  std::vector<Point> path;  // the part that is in the panel
  for (const FrontPoint& point : fronts.any_path) {
    const double jump = std::log10(point.jump);
    if (jump < kJumps.low - 1e-9 || jump > kJumps.high + 1e-9 || std::log10(point.latency_ms) < latencies.low) continue;
    path.push_back(on(panel, point));
  }
  svg.polyline(path, kPathStroke);
  for (std::size_t i = fronts.maps.size(); i-- > 0;) draw_map(svg, panel, fronts.maps[i], kMapStrokes[i]);
}

void draw_legend(Svg& svg, const Fronts& fronts, double left, double top) {
  double row = top + 34;
  const auto entry = [&](const std::string& text, const Stroke& stroke, bool dot) {
    svg.line({left, row - 4}, {left + 34, row - 4}, stroke);
    if (dot) svg.dot({left + 17, row - 4}, 5, stroke.colour);
    svg.text({left + 44, row}, text);
    row += 23;
  };
  entry("any path with that jump, knowing the whole recording", kPathStroke, false);
  entry("pause bound", kPauseStroke, false);
  entry("plain line (jump 0); its latency in the corner if it is above", kLineStroke, false);
  const char* const kMeaning[]{": the default map", ": the default map before", " on segment boundaries",
                               ": the former one without rules"};
  for (std::size_t i = 0; i < fronts.maps.size(); ++i) entry(fronts.maps[i].name + kMeaning[i], kMapStrokes[i], true);
  svg.text({left, row + 4}, "Bandwidths 0.5, 1, 2 (filled) and 4 Hz.");
  svg.text({left, row + 26}, "Down: least latency, ms. Across: largest velocity jump, slots,");
  svg.text({left, row + 43}, "after the first second. Lower left is better.");
}

}  // namespace

std::string fronts_svg(const std::vector<Fronts>& all) {
  const std::size_t rows = all.size() / kColumns + 1;  // the legend comes after the last panel
  Svg svg(kWidth, kTop + static_cast<double>(rows) * kPanelHeight, "Least latency against velocity jump, map by map");
  const auto left = [](std::size_t i) { return static_cast<double>(i % kColumns) * kPanelWidth + 6; };
  const auto top = [](std::size_t i) { return kTop + static_cast<double>(i / kColumns) * kPanelHeight; };
  for (std::size_t i = 0; i < all.size(); ++i) draw_panel(svg, all[i], left(i), top(i));
  draw_legend(svg, all.front(), left(all.size()) + 24, top(all.size()));
  return std::move(svg).finish();
}

}  // namespace evenstep::bench
