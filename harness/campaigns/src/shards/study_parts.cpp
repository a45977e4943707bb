#include "evenstep/campaigns/study_parts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

#include <algorithm>
#include <array>

#include "evenstep/campaigns/felt_study.h"
#include "evenstep/campaigns/stiffness_limit.h"
#include "evenstep/campaigns/study.h"
#include "evenstep/loop/solver_step.h"
#include "evenstep/sim/solver.h"
#include "json_parts.h"
#include "src/felt/cells.h"
#include "src/study/cells.h"
#include "src/study/machine.h"
#include "src/study/stiffness_cells.h"

namespace evenstep {
namespace {

using internal::exact;
using internal::item_line;
using internal::read_exact;
using internal::refuse_line;

Json json_of(const StudyValues& values) {
  Json out = Json::array();
  for (const StudyQuantity q : kStudyQuantities) out.push_back(exact(values[q]));
  return out;
}
StudyValues values_of(const Json& json) {
  StudyValues values;
  for (const StudyQuantity q : kStudyQuantities) values[q] = read_exact(json.at(static_cast<std::size_t>(q)));
  return values;
}

Json json_of(const StudyCost& cost) { return {exact(cost.min), exact(cost.median), exact(cost.max)}; }
StudyCost cost_of_json(const Json& json) { return {read_exact(json.at(0)), read_exact(json.at(1)), read_exact(json.at(2))}; }

Json json_of(const FeltError& error) { return {exact(error.rms_N), exact(error.max_N)}; }
FeltError felt_error_of(const Json& json) { return {read_exact(json.at(0)), read_exact(json.at(1))}; }

template <class State>
State state_of(const Json& json) {
  for (int i = 0; i < 4; ++i) {
    const auto state = static_cast<State>(i);
    if (json.get<std::string>() == name_of(state)) return state;
  }
  refuse_line(fmt::format("has an unknown state {}", json_text(json)));
}

/// What a cell's costs were measured on.
Json machine_json() {
  const internal::StudyMachine machine = internal::study_machine();
  return {{"machine", machine.name}, {"cpus", machine.cpus}, {"load", exact(machine.load)}, {"compiler", machine.compiler}};
}

/// The machines of all lines, in the record that they belong to. A cell names its own only if costs come from several.
template <class Record, class Cell>
class Machines {
 public:
  /// `has_costs`: whether anything was measured; what was refused says nothing about a machine.
  void add(const Json& measured, bool has_costs) {
    const auto cpus = measured.at("cpus").get<std::int64_t>();
    own_ = fmt::format("{}, {} processors", measured.at("machine").get<std::string>(), cpus);
    if (first_.empty() || (has_costs && all_.empty())) {
      first_ = measured.at("machine").get<std::string>();
      compiler_ = measured.at("compiler").get<std::string>();
      cpus_ = cpus;
    }
    if (has_costs && std::find(all_.begin(), all_.end(), own_) == all_.end()) all_.push_back(own_);
    load_ = std::max(load_, read_exact(measured.at("load")));
  }
  /// Of the line that was added last.
  const std::string& own() const { return own_; }
  void put(Record& record, std::vector<Cell*> cells) const {
    record.machine = first_;
    record.compiler = compiler_;
    record.cpus = cpus_;
    record.load = load_;
    if (all_.size() <= 1) {
      for (Cell* cell : cells) cell->machine.clear();
      return;
    }
    record.machine = fmt::format("{} machines: {}", all_.size(), fmt::join(all_, "; "));
    record.cpus = 0;
    record.machines = all_;
  }

 private:
  std::string own_, first_, compiler_;
  std::vector<std::string> all_;  // of costs
  std::int64_t cpus_ = 0;
  double load_ = 0;
};

internal::CampaignId id_of(const Scenario& scenario, const std::string& path, const StudyPartsOptions& options,
                           std::vector<Diagnostic>& errors) {
  return {"study", scenario.name, path, options.set,
          internal::scenario_digest(path, {options.set, std::nullopt, options.registry}, errors)};
}

bool is_interrupted(const PartOptions& options) { return options.interrupted && *options.interrupted; }

// The state of a tissue.

Json json_of(const StudyReference& reference) {
  return {{"method", reference.method},
          {"method_order", reference.method_order},
          {"coarsest_substep_s", exact(reference.coarsest_substep_s)},
          {"scale", json_of(reference.scale)},
          {"estimate", json_of(reference.estimate)},
          {"order", json_of(reference.order)}};
}
StudyReference reference_of(const Json& json) {
  return {
      json.at("method").get<std::string>(), json.at("method_order").get<int>(), read_exact(json.at("coarsest_substep_s")),
      values_of(json.at("scale")),          values_of(json.at("estimate")),     values_of(json.at("order"))};
}

Json json_of(const StudyCell& cell, const std::string& opencl_device) {
  Json out = {{"solver", cell.solver},         {"method", cell.method},
              {"iterations", cell.iterations}, {"substep_s", exact(cell.substep_s)},
              {"substeps", cell.substeps},     {"state", name_of(cell.state)},
              {"reason", cell.reason},         {"error", json_of(cell.error)}};
  Json measured = {{"cpu_s_per_s", json_of(cell.cpu)}, {"wall_s_per_s", json_of(cell.wall)}, {"repeats", cell.repeats}};
  measured.update(machine_json());
  measured["opencl_device"] = opencl_device;
  return {{"cell", out}, {"measured", measured}};
}
StudyCell cell_of(const Json& json) {
  const Json &cell = json.at("cell"), &measured = json.at("measured");
  StudyCell out{.solver = cell.at("solver").get<std::string>(),
                .method = cell.at("method").get<std::string>(),
                .iterations = cell.at("iterations").get<int>(),
                .substep_s = read_exact(cell.at("substep_s")),
                .substeps = cell.at("substeps").get<int>(),
                .state = state_of<StudyCell::State>(cell.at("state")),
                .reason = cell.at("reason").get<std::string>(),
                .error = values_of(cell.at("error")),
                .order = {},
                .cpu = cost_of_json(measured.at("cpu_s_per_s")),
                .wall = cost_of_json(measured.at("wall_s_per_s")),
                .repeats = measured.at("repeats").get<int>()};
  return out;
}

/// Runs the parts of any kind, and makes its record if they are the whole.
template <class Finish>
void run_items(const internal::CampaignId& id, std::int64_t items, const char* kind, internal::JsonParts::Take take,
               const internal::RunItem& run, const PartOptions& options, StudyPartsOutcome& outcome, Finish finish) {
  internal::JsonParts parts(id, items, {{"kind", kind}}, std::move(take));
  internal::run_part(parts, run, id.kind, options, outcome);
  if (outcome.exit == ExitCode::pass && options.shard.of == 1) finish();
}

void state_parts(const Scenario& scenario, const internal::CampaignId& id, const StudyPartsOptions& options,
                 StudyPartsOutcome& outcome) {
  StudyControl control;
  control.interrupted = options.interrupted;
  internal::StudyCells cells(scenario, control);
  StudyRecord record = cells.description();
  Machines<StudyRecord, StudyCell> machines;
  const auto take = [&](const Json& json) {
    if (json.contains("reference")) {
      record.reference = reference_of(json.at("reference"));
      return;
    }
    record.cells.push_back(cell_of(json));
    const bool has_costs = record.cells.back().state == StudyCell::State::measured;
    machines.add(json.at("measured"), has_costs);
    if (has_costs) record.cells.back().machine = machines.own();
    if (const auto device = json.at("measured").at("opencl_device").get<std::string>(); !device.empty())
      record.opencl_device = device;
  };
  const auto run = [&](std::int64_t item) -> std::string {
    try {
      if (item == 0) return item_line(0, {{"reference", json_of(cells.reference().info)}});
      const StudyCell cell = cells.cell(static_cast<std::size_t>(item - 1));
      return item_line(item, json_of(cell, cell.solver == name_of(SolverKind::opencl) ? cells.opencl_device() : ""));
    } catch (const internal::StudyInterrupted&) {
      return {};
    }
  };
  run_items(id, static_cast<std::int64_t>(cells.count()) + 1, "state", take, run, options, outcome, [&] {
    std::vector<StudyCell*> all;
    for (StudyCell& cell : record.cells) all.push_back(&cell);
    machines.put(record, all);
    internal::put_orders(record);
    outcome.record = std::move(record);
  });
}

// The felt force.

Json json_of(const FeltReferenceInfo& reference, std::int64_t ticks) {
  Json measured = {{"cpu_s", exact(reference.cpu_s)}, {"stored", reference.stored}};
  measured.update(machine_json());
  return {{"reference",
           {{"method", reference.method},
            {"method_order", reference.method_order},
            {"coarsest_step_s", exact(reference.coarsest_step_s)},
            {"scale_N", exact(reference.scale_N)},
            {"estimate_N", exact(reference.estimate_N)},
            {"ticks", ticks}}},
          {"measured", measured}};
}

Json json_of(const std::vector<FeltPoint>& cell) {
  Json points = Json::array();
  for (const FeltPoint& point : cell) {
    points.push_back({{"strategy", point.strategy},
                      {"solver", point.solver},
                      {"method", point.method},
                      {"iterations", point.iterations},
                      {"substep_s", exact(point.substep_s)},
                      {"substeps", point.substeps},
                      {"state", name_of(point.state)},
                      {"reason", point.reason},
                      {"total", json_of(point.total)},
                      {"discretisation", json_of(point.discretisation)},
                      {"remap", json_of(point.remap)},
                      {"device", json_of(point.device)},
                      {"latency_s", exact(point.latency_s)},
                      {"device_latency_s", exact(point.device_latency_s)},
                      {"saturated", point.saturated}});
  }
  Json measured = {{"cpu_s_per_s", json_of(cell.front().cpu)}, {"repeats", cell.front().repeats}};
  measured.update(machine_json());
  return {{"points", points}, {"measured", measured}};
}

std::vector<FeltPoint> points_of(const Json& json) {
  const Json& measured = json.at("measured");
  std::vector<FeltPoint> points;
  for (const Json& one : json.at("points")) {
    points.push_back({.strategy = one.at("strategy").get<std::string>(),
                      .solver = one.at("solver").get<std::string>(),
                      .method = one.at("method").get<std::string>(),
                      .iterations = one.at("iterations").get<int>(),
                      .substep_s = read_exact(one.at("substep_s")),
                      .substeps = one.at("substeps").get<int>(),
                      .state = state_of<StudyCell::State>(one.at("state")),
                      .reason = one.at("reason").get<std::string>(),
                      .total = felt_error_of(one.at("total")),
                      .discretisation = felt_error_of(one.at("discretisation")),
                      .remap = felt_error_of(one.at("remap")),
                      .device = felt_error_of(one.at("device")),
                      .latency_s = read_exact(one.at("latency_s")),
                      .device_latency_s = read_exact(one.at("device_latency_s")),
                      .saturated = one.at("saturated").get<std::int64_t>(),
                      .cpu = cost_of_json(measured.at("cpu_s_per_s")),
                      .repeats = measured.at("repeats").get<int>()});
  }
  return points;
}

void felt_parts(const Scenario& scenario, const internal::CampaignId& id, const StudyPartsOptions& options,
                StudyPartsOutcome& outcome) {
  FeltStudyControl control;
  control.interrupted = options.interrupted;
  control.cache_folder = options.cache_folder;
  control.announce = options.announce;
  internal::FeltCells study(scenario, control);
  FeltStudyRecord record = study.description();
  std::vector<std::vector<FeltPoint>> cells;
  Machines<FeltStudyRecord, FeltPoint> machines;
  const auto take = [&](const Json& json) {
    const Json& measured = json.at("measured");
    if (json.contains("reference")) {
      const Json& reference = json.at("reference");
      record.reference.method = reference.at("method").get<std::string>();
      record.reference.method_order = reference.at("method_order").get<int>();
      record.reference.coarsest_step_s = read_exact(reference.at("coarsest_step_s"));
      record.reference.scale_N = read_exact(reference.at("scale_N"));
      record.reference.estimate_N = read_exact(reference.at("estimate_N"));
      record.ticks = reference.at("ticks").get<std::int64_t>();
      record.reference.cpu_s = read_exact(measured.at("cpu_s"));
      record.reference.stored = measured.at("stored").get<bool>();
      return;
    }
    cells.push_back(points_of(json));
    if (cells.back().size() != study.strategies()) refuse_line("has another number of strategies");
    const auto has_costs = [](const FeltPoint& point) { return point.state == StudyCell::State::measured; };
    machines.add(measured, std::any_of(cells.back().begin(), cells.back().end(), has_costs));
    for (FeltPoint& point : cells.back()) {
      if (has_costs(point)) point.machine = machines.own();
    }
  };
  const auto run = [&](std::int64_t item) -> std::string {
    if (is_interrupted(options)) return {};
    study.prepare();
    if (item == 0) return study.interrupted() ? "" : item_line(0, json_of(study.reference(), study.ticks()));
    const std::vector<FeltPoint> cell = study.cell(static_cast<std::size_t>(item - 1));
    return study.interrupted() ? "" : item_line(item, json_of(cell));
  };
  run_items(id, static_cast<std::int64_t>(study.count()) + 1, "felt-force", take, run, options, outcome, [&] {
    internal::put_points(record, cells);
    std::vector<FeltPoint*> all;
    for (FeltPoint& point : record.points) all.push_back(&point);
    machines.put(record, all);
    outcome.record = std::move(record);
  });
}

// The largest stable stiffness.

void stiffness_parts(const Scenario& scenario, const internal::CampaignId& id, const StudyPartsOptions& options,
                     StudyPartsOutcome& outcome) {
  StudyControl control;
  control.interrupted = options.interrupted;
  StiffnessLimits study = internal::stiffness_description(scenario);
  const auto take = [&](const Json& json) {
    study.limits.push_back({json.at("strategy").get<std::string>(), state_of<StiffnessLimit::State>(json.at("state")),
                            read_exact(json.at("stable_N_per_m")), read_exact(json.at("unstable_N_per_m")),
                            read_exact(json.at("latency_s")), json.at("runs").get<int>()});
  };
  const auto run = [&](std::int64_t item) -> std::string {
    const std::optional<StiffnessLimit> limit =
        internal::stiffness_limit_of(scenario, static_cast<std::size_t>(item), control);
    if (!limit) return {};
    return item_line(item, {{"strategy", limit->strategy},
                            {"state", name_of(limit->state)},
                            {"stable_N_per_m", exact(limit->stable_N_per_m)},
                            {"unstable_N_per_m", exact(limit->unstable_N_per_m)},
                            {"latency_s", exact(limit->latency_s)},
                            {"runs", limit->runs}});
  };
  run_items(id, static_cast<std::int64_t>(scenario.strategies.size()), "stiffness-limit", take, run, options, outcome,
            [&] { outcome.record = std::move(study); });
}

}  // namespace

StudyPartsOutcome run_study_parts(const Scenario& scenario, const std::string& path, const StudyPartsOptions& options) {
  StudyPartsOutcome outcome;
  const internal::CampaignId id = id_of(scenario, path, options, outcome.errors);
  if (!outcome.errors.empty()) {
    outcome.exit = ExitCode::usage;
    return outcome;
  }
  StudyPartsOptions one_by_one = options;
  if (!scenario.study.stiffness_limit) one_by_one.threads = 1;
  try {
    if (scenario.study.stiffness_limit)
      stiffness_parts(scenario, id, one_by_one, outcome);
    else if (scenario.study.error == StudyError::felt_force)
      felt_parts(scenario, id, one_by_one, outcome);
    else
      state_parts(scenario, id, one_by_one, outcome);
  } catch (const SolverError& error) {
    throw run_failure(error);
  }
  return outcome;
}

}  // namespace evenstep
