// A study as a table, as CSV and as JSON.
#include <fmt/format.h>

#include <iterator>

#include "writers/texts/study_table.h"
#include "writers/texts/text.h"

namespace evenstep {
namespace {

std::string error_text(const StudyCell& cell, StudyQuantity q, const StudyValues& estimate) {
  if (!std::isfinite(cell.error[q])) return "-";
  return fmt::format("{:.2g}{}{}", cell.error[q], q == StudyQuantity::position ? " m" : "",
                     cell.at_floor(q, estimate) ? "*" : "");
}

internal::StudyRow row_of(const StudyCell& cell, const StudyValues& estimate, const std::vector<std::string>& machines) {
  internal::StudyRow row{cell.solver, cell.method, cell.iterations > 0 ? fmt::format("{}", cell.iterations) : "",
                         internal::step_text(cell.substep_s)};
  if (cell.state == StudyCell::State::unavailable) row[2] = row[3] = "";  // it is unavailable at any step
  if (cell.state != StudyCell::State::measured) {
    row[4] = fmt::format("{}: {}", name_of(cell.state), cell.reason);
    return row;
  }
  for (const StudyQuantity q : kStudyQuantities) row[4 + static_cast<std::size_t>(q)] = error_text(cell, q, estimate);
  const double order = cell.order[StudyQuantity::position];
  row[7] = std::isfinite(order) ? fmt::format("{:.2f}", order) : "";
  row[8] = internal::cost_text(cell.cpu, machines, cell.machine);
  return row;
}

/// Whether an earlier row already says that the solver does not have this method; it is said once, not for every step.
bool said_before(const StudyRecord& study, const StudyCell& cell) {
  if (cell.state != StudyCell::State::unavailable || &cell == &study.cells.front()) return false;
  const StudyCell& before = *(&cell - 1);
  return before.solver == cell.solver && before.method == cell.method && before.reason == cell.reason;
}

Json json_of(const StudyValues& values) {
  Json out = Json::object();
  for (const StudyQuantity q : kStudyQuantities) out[name_of(q)] = json_number(values[q]);
  return out;
}

Json json_of(const StudyCell& cell, const StudyValues& estimate) {
  Json out = {{"solver", cell.solver}, {"method", cell.method}};
  if (cell.iterations > 0) out["iterations"] = cell.iterations;
  out["substep_s"] = json_number(cell.substep_s);
  out["substeps"] = cell.substeps;
  out["state"] = name_of(cell.state);
  if (cell.state != StudyCell::State::measured) {
    out["reason"] = cell.reason;
    return out;
  }
  out["error"] = json_of(cell.error);
  out["order"] = json_of(cell.order);
  for (const StudyQuantity q : kStudyQuantities) out["at_floor"][name_of(q)] = cell.at_floor(q, estimate);
  out["cpu_s_per_s"] = internal::json_of(cell.cpu);
  out["wall_s_per_s"] = internal::json_of(cell.wall);
  out["repeats"] = cell.repeats;
  if (!cell.machine.empty()) out["machine"] = cell.machine;
  return out;
}

Json json_of(const StudyReference& reference) {
  return {{"method", reference.method},
          {"method_order", reference.method_order},
          {"coarsest_substep_s", json_number(reference.coarsest_substep_s)},
          {"scale", json_of(reference.scale)},
          {"estimate", json_of(reference.estimate)},
          {"order", json_of(reference.order)}};
}

std::string csv_number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

}  // namespace

const char* name_of(StudyQuantity quantity) {
  switch (quantity) {
    case StudyQuantity::position:
      return "position";
    case StudyQuantity::force:
      return "force";
    case StudyQuantity::energy:
      return "energy";
  }
  return "";
}

const char* name_of(StudyCell::State state) {
  switch (state) {
    case StudyCell::State::measured:
      return "measured";
    case StudyCell::State::refused:
      return "refused";
    case StudyCell::State::unavailable:
      return "unavailable";
    case StudyCell::State::diverged:
      return "diverged";
  }
  return "";
}

std::string warning_of(const std::vector<std::string>& machines) {
  if (machines.size() < 2) return {};
  std::string names;
  for (std::size_t i = 0; i < machines.size(); ++i) names += fmt::format("{}#{} {}", i == 0 ? "" : "; ", i + 1, machines[i]);
  return fmt::format(
      "warning: the costs were measured on {} machines ({}), and only those of one machine can be compared; measure all of "
      "them on one",
      machines.size(), names);
}

namespace {

std::string text_of(const StudyReference& reference) {
  if (reference.method.empty()) return "none: it was interrupted\n\n";
  const auto estimate = [&](StudyQuantity q) { return fmt::format("{:.2g}", reference.estimate[q]); };
  return fmt::format(
      "{}, cpu-double, steps of {} and its half and quarter, extrapolated by its order {}; orders seen: "
      "position {:.2f}, force {:.2f}, energy {:.2f}\n"
      "               its own error: position {} m, force {}, energy {} (of {:.3g} m, {:.3g} N, {:.3g} J rms)\n\n",
      reference.method, internal::step_text(reference.coarsest_substep_s), reference.method_order,
      reference.order[StudyQuantity::position], reference.order[StudyQuantity::force],
      reference.order[StudyQuantity::energy], estimate(StudyQuantity::position), estimate(StudyQuantity::force),
      estimate(StudyQuantity::energy), reference.scale[StudyQuantity::position], reference.scale[StudyQuantity::force],
      reference.scale[StudyQuantity::energy]);
}

}  // namespace

std::string study_table(const StudyRecord& study) {
  const StudyReference& reference = study.reference;
  std::string out = fmt::format(
      "  machine      {}, load {:.2g}; {}{}\n"
      "  scene        {} particles, {:.6g} N/m; explicit limit {} in every configuration\n"
      "  motion       {:.6g} ms, {} samples, tools move every {}\n"
      "  reference    {}",
      internal::machine_text(study.machine, study.cpus), study.load, study.compiler,
      study.opencl_device.empty() ? "" : fmt::format("; OpenCL {}", study.opencl_device), study.particles,
      study.stiffness_N_per_m, internal::step_text(study.step_limit_s), study.duration_s * 1e3, study.samples,
      internal::step_text(study.step_s), text_of(reference));
  std::vector<internal::StudyRow> rows{
      {"solver", "method", "iterations", "step", "position", "force", "energy", "order", "CPU s per s (min .. max)"}};
  bool any_at_floor = false, any_backwards = false;
  for (const StudyCell& cell : study.cells) {
    if (said_before(study, cell)) continue;
    rows.push_back(row_of(cell, reference.estimate, study.machines));
    any_backwards |= cell.order[StudyQuantity::position] < 0;
    for (const StudyQuantity q : kStudyQuantities)
      any_at_floor |= cell.state == StudyCell::State::measured && cell.at_floor(q, reference.estimate);
  }
  out += internal::aligned(rows);
  if (any_at_floor) out += "  * at the reference's floor: not above the reference's own error\n";
  if (any_backwards)
    out += "  a negative order: the shorter step has the larger error; in float rounding adds up, step by step\n";
  if (const std::string warning = warning_of(study.machines); !warning.empty()) out += "  " + warning + '\n';
  if (study.interrupted) out += "  interrupted: cells are missing\n";
  return out;
}

std::string study_csv(const StudyRecord& study) {
  std::string csv =
      "solver,method,iterations,substep_s,substeps,state,position_m,force,energy,position_order,force_order,energy_order,"
      "at_floor,cpu_min_s_per_s,cpu_median_s_per_s,cpu_max_s_per_s,wall_min_s_per_s,wall_median_s_per_s,wall_max_s_per_s,"
      "repeats,reason,machine\n";
  for (const StudyCell& cell : study.cells) {
    fmt::format_to(std::back_inserter(csv), "{},{},{},{},{},{}", cell.solver, cell.method,
                   cell.iterations > 0 ? fmt::format("{}", cell.iterations) : "", cell.substep_s, cell.substeps,
                   name_of(cell.state));
    const bool measured = cell.state == StudyCell::State::measured;
    for (const StudyValues* values : {&cell.error, &cell.order}) {
      for (const StudyQuantity q : kStudyQuantities) csv += ',' + (measured ? csv_number((*values)[q]) : "");
    }
    std::string floor;
    for (const StudyQuantity q : kStudyQuantities) {
      if (measured && cell.at_floor(q, study.reference.estimate))
        floor += (floor.empty() ? "" : " ") + std::string(name_of(q));
    }
    csv += ',' + floor;
    for (const StudyCost* cost : {&cell.cpu, &cell.wall}) {
      for (const double value : {cost->min, cost->median, cost->max}) csv += ',' + (measured ? csv_number(value) : "");
    }
    fmt::format_to(std::back_inserter(csv), ",{},{},{}\n", cell.repeats, internal::csv_field(cell.reason),
                   internal::csv_field(cell.machine));
  }
  return csv;
}

std::string study_json(const StudyRecord& study) {
  Json out = {{"format", 1},
              {"evenstep", study.version},
              {"scenario", study.scenario},
              {"file", study.file},
              {"machine", study.machine},
              {"cpus", study.cpus},
              {"load", json_number(study.load)},
              {"compiler", study.compiler},
              {"opencl_device", study.opencl_device},
              {"repeats", study.repeats},
              {"particles", study.particles},
              {"stiffness_N_per_m", json_number(study.stiffness_N_per_m)},
              {"step_limit_s", json_number(study.step_limit_s)},
              {"step_s", json_number(study.step_s)},
              {"rest_s", json_number(study.rest_s)},
              {"duration_s", json_number(study.duration_s)},
              {"samples", study.samples},
              {"interrupted", study.interrupted},
              {"reference", json_of(study.reference)},
              {"cells", Json::array()}};
  if (!study.machines.empty()) {
    out["machines"] = study.machines;
    out["warning"] = warning_of(study.machines);
  }
  for (const StudyCell& cell : study.cells) out["cells"].push_back(json_of(cell, study.reference.estimate));
  return json_text(out, "cells") + '\n';
}

}  // namespace evenstep
