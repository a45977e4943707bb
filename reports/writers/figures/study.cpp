// Work-precision figure: one line per solver, method and iterations.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "evenstep/reports/study_record.h"
#include "writers/figures/svg.h"
#include "writers/texts/study_table.h"

namespace evenstep {
namespace {

using internal::Axis;
using internal::Panel;
using internal::Point;
using internal::Range;
using internal::Stroke;
using internal::Svg;

// High enough for a legend with every method on every solver, each with cells of every state.
constexpr double kWidth = 1060, kHeight = 790;
constexpr internal::Box kPlot{90, 50, 690, 690};
constexpr double kLegend = 712;  // left edge

struct Look {
  const char* name;
  const char* value;
};
constexpr std::array kColours = std::to_array<Look>({{"symplectic-euler", internal::colour::kBlack},
                                                     {"velocity-verlet", internal::colour::kBlue},
                                                     {"rk4", internal::colour::kGreen},
                                                     {"implicit-euler", internal::colour::kVermilion},
                                                     {"implicit-midpoint", internal::colour::kPurple},
                                                     {"vertex-block-descent", internal::colour::kOrange}});
constexpr std::array kDashes = std::to_array<Look>({{"cpu", ""}, {"cpu-double", "7 3"}, {"opencl", "2 3"}});

template <class Looks>
const char* look(const Looks& looks, const std::string& name) {
  for (const Look& one : looks) {
    if (name == one.name) return one.value;
  }
  return looks.front().value;
}

struct Line {
  std::string solver, method;
  int iterations = 0;
  std::vector<const StudyCell*> cells;  // measured, with an error and a cost
};

bool shown(const StudyCell& cell, StudyQuantity q) {
  return cell.state == StudyCell::State::measured && cell.error[q] > 0 && std::isfinite(cell.error[q]) &&
         cell.cpu.median > 0;
}

std::vector<Line> lines_of(const StudyRecord& study, StudyQuantity q) {
  std::vector<Line> lines;
  for (const StudyCell& cell : study.cells) {
    if (!shown(cell, q)) continue;
    const bool same = !lines.empty() && lines.back().solver == cell.solver && lines.back().method == cell.method &&
                      lines.back().iterations == cell.iterations;
    if (!same) lines.push_back({cell.solver, cell.method, cell.iterations, {}});
    lines.back().cells.push_back(&cell);
  }
  return lines;
}

Range decades(double least, double most) {
  return {std::floor(std::log10(least) - 0.05), std::ceil(std::log10(most) + 0.05)};
}

/// The ranges of all points, including real time (1 CPU second per simulated second).
std::pair<Range, Range> ranges_of(const std::vector<Line>& lines, StudyQuantity q) {
  double least_error = INFINITY, most_error = 0, least_cost = 1, most_cost = 1;
  for (const Line& line : lines) {
    for (const StudyCell* cell : line.cells) {
      least_error = std::min(least_error, cell->error[q]);
      most_error = std::max(most_error, cell->error[q]);
      least_cost = std::min(least_cost, cell->cpu.min);
      most_cost = std::max(most_cost, cell->cpu.max);
    }
  }
  if (most_error == 0) return {{-6, 0}, {-2, 1}};
  return {decades(least_error, most_error), decades(least_cost, most_cost)};
}

void draw(Svg& svg, Panel& panel, const Line& line, StudyQuantity q, const StudyValues& estimate) {
  const char* colour = look(kColours, line.method);
  std::vector<double> x, y;
  for (const StudyCell* cell : line.cells) {
    x.push_back(std::log10(cell->error[q]));
    y.push_back(std::log10(cell->cpu.median));
  }
  panel.curve(x, y, {colour, 1.8, look(kDashes, line.solver), 1});
  for (std::size_t i = 0; i < x.size(); ++i) {
    const StudyCell& cell = *line.cells[i];
    svg.line(panel.at(x[i], std::log10(cell.cpu.min)), panel.at(x[i], std::log10(cell.cpu.max)), {colour, 1, "", 0.6});
    svg.dot(panel.at(x[i], y[i]), 4, colour);
    if (cell.at_floor(q, estimate)) svg.dot(panel.at(x[i], y[i]), 2.4, "#ffffff");
  }
  if (line.iterations > 0) {
    const Point at = panel.at(x.front(), y.front());
    svg.text({at.x + 6, at.y + 4}, fmt::format("{} it", line.iterations), Svg::Anchor::start, 10);
  }
}

/// Which cells have no point, and why: "rk4: cpu, opencl" per method.
struct Pointless {
  StudyCell::State state = StudyCell::State::refused;
  std::ptrdiff_t cells = 0;
  std::vector<std::string> methods;
};

std::vector<Pointless> without_points(const StudyRecord& study) {
  std::vector<Pointless> out;
  for (const StudyCell::State state :
       {StudyCell::State::refused, StudyCell::State::unavailable, StudyCell::State::diverged}) {
    Pointless list{state, 0, {}};
    std::vector<std::pair<std::string, std::vector<std::string>>> solvers;  // per method
    for (const StudyCell& cell : study.cells) {
      if (cell.state != state) continue;
      ++list.cells;
      auto method = std::find_if(solvers.begin(), solvers.end(), [&](const auto& m) { return m.first == cell.method; });
      if (method == solvers.end()) method = solvers.insert(method, {cell.method, {}});
      std::vector<std::string>& names = method->second;
      if (std::find(names.begin(), names.end(), cell.solver) == names.end()) names.push_back(cell.solver);
    }
    for (const auto& [method, names] : solvers)
      list.methods.push_back(fmt::format("{}: {}", method, fmt::join(names, ", ")));
    if (list.cells > 0) out.push_back(std::move(list));
  }
  return out;
}

/// Draws the legend of the lines, and lists the cells that have no point.
void draw_legend(Svg& svg, const StudyRecord& study, const std::vector<Line>& lines) {
  Point at{kLegend, kPlot.top + 10};
  std::vector<std::string> named;
  for (const Line& line : lines) {
    const std::string name = fmt::format("{}, {}", line.method, line.solver);
    if (std::find(named.begin(), named.end(), name) != named.end()) continue;
    named.push_back(name);
    svg.line(at, {at.x + 34, at.y}, {look(kColours, line.method), 1.8, look(kDashes, line.solver), 1});
    svg.text({at.x + 40, at.y + 4}, name);
    at.y += 17;
  }
  at.y += 6;
  svg.dot({at.x + 17, at.y}, 4, internal::colour::kGrey);
  svg.dot({at.x + 17, at.y}, 2.4, "#ffffff");
  svg.text({at.x + 40, at.y + 4}, "at the reference's floor", Svg::Anchor::start, 11);
  svg.text({at.x, at.y += 20}, "Bars: least to greatest of the repeats.", Svg::Anchor::start, 11);
  for (const Pointless& list : without_points(study)) {
    svg.text({at.x, at.y += 24}, fmt::format("{} ({}):", name_of(list.state), list.cells), Svg::Anchor::start, 11, true);
    for (const std::string& method : list.methods) svg.text({at.x + 10, at.y += 15}, method, Svg::Anchor::start, 11);
  }
}

const char* axis_name(StudyQuantity q) {
  switch (q) {
    case StudyQuantity::position:
      return "position error, rms";
    case StudyQuantity::force:
      return "force error, rms, share of the rms force";
    case StudyQuantity::energy:
      return "energy error, rms, share of the rms energy";
  }
  return "";
}

}  // namespace

std::string study_svg(const StudyRecord& study, StudyQuantity quantity) {
  const std::vector<Line> lines = lines_of(study, quantity);
  const auto [error, cost] = ranges_of(lines, quantity);
  Svg svg(kWidth, kHeight, fmt::format("Error against run time: {}", study.scenario.empty() ? study.file : study.scenario));
  Panel panel(svg, kPlot, {error, axis_name(quantity), quantity == StudyQuantity::position ? "m" : "1", true},
              {cost, "CPU time per simulated time", "s/s", true});
  panel.draw_axes(true, true);
  svg.line(panel.at(error.low, 0), panel.at(error.high, 0), {internal::colour::kGrey, 1.2, "8 4", 1});
  svg.text({kPlot.right - 6, panel.y_at(0) - 5}, "real time", Svg::Anchor::end, 11);
  const double floor = std::log10(study.reference.estimate[quantity]);
  if (floor > error.low && floor < error.high) {
    svg.line({panel.x_at(floor), kPlot.top}, {panel.x_at(floor), kPlot.bottom}, {internal::colour::kGrey, 1.2, "2 3", 1});
    svg.text({panel.x_at(floor) + 4, kPlot.top + 14}, "reference's own error", Svg::Anchor::start, 11);
  }
  for (const Line& line : lines) draw(svg, panel, line, quantity, study.reference.estimate);
  draw_legend(svg, study, lines);
  svg.text({kPlot.left, kPlot.bottom + 62},
           fmt::format("{} particles, {:.6g} N/m, {:.6g} ms of motion. {}.", study.particles, study.stiffness_N_per_m,
                       study.duration_s * 1e3, internal::machine_text(study.machine, study.cpus)),
           Svg::Anchor::start, 10);
  svg.text({kPlot.left, kPlot.bottom + 76},
           fmt::format("{}{}, evenstep {}.", study.compiler,
                       study.opencl_device.empty() ? "" : ", OpenCL " + study.opencl_device, study.version),
           Svg::Anchor::start, 10);
  return std::move(svg).finish();
}

}  // namespace evenstep
