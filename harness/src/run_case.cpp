#include "run_case.h"

#include <fmt/format.h>

#include <algorithm>

#include "evenstep/catalogue/run_trial.h"
#include "evenstep/scheduler/parallel_for.h"
#include "evenstep/time/digest.h"
#include "judge.h"

namespace evenstep::internal {
namespace {

const CaseKind& kind_of(const CaseSpec& spec) {
  const std::vector<CaseKind>& kinds = case_kinds();
  return *std::find_if(kinds.begin(), kinds.end(), [&](const CaseKind& kind) { return kind.name == spec.kind; });
}

CaseRecord run_cells(const Scenario& scenario, const RunOptions& options) {
  const CaseSpec& spec = *scenario.case_spec;
  const CaseKind& kind = kind_of(spec);
  CaseRecord record{spec.kind, std::string(kind.value_name), std::string(kind.value_unit), {}};
  for (const Method method : spec.methods) {
    for (const std::string& solver : spec.solver_names())
      record.rows.push_back({name_of(method), solver, std::vector<CaseCell>(spec.values.size())});
  }
  const std::size_t columns = spec.values.size();
  const auto cell = [&](std::size_t i) -> CaseCell& { return record.rows[i / columns].cells[i % columns]; };
  if (options.cells != nullptr) {
    for (std::size_t i = 0; i < options.cells->size(); ++i) cell(i) = (*options.cells)[i];
  } else {
    parallel_for(record.rows.size() * columns, options.threads, [&](std::size_t i) {
      cell(i) = run_case_cell(scenario, static_cast<std::int64_t>(i), options.control.interrupted);
    });
  }
  compare_devices(record);
  if (kind.compare == nullptr) return record;
  for (CaseRow& row : record.rows) kind.compare(row.cells);
  return record;
}

/// The hash of the results of all cells, in the order of the file.
std::uint64_t hash_of(const CaseRecord& record) {
  std::uint64_t hash = 0;
  for (const CaseRow& row : record.rows) {
    hash = mix(mix(hash, name_digest(row.method)), name_digest(row.solver));
    for (const CaseCell& cell : row.cells)
      hash = mix(mix(mix(hash, cell.value), static_cast<std::uint64_t>(cell.status)), cell.digest);
  }
  return hash;
}

bool ran(const CaseCell& cell) {
  return cell.status != CellStatus::unavailable && cell.status != CellStatus::refused &&
         cell.status != CellStatus::interrupted;
}

}  // namespace

void compare_devices(CaseRecord& record) {
  for (CaseRow& row : record.rows) {
    if (row.solver != name_of(SolverKind::opencl)) continue;
    const auto cpu = std::find_if(record.rows.begin(), record.rows.end(), [&](const CaseRow& other) {
      return other.method == row.method && other.solver == name_of(SolverKind::cpu_float);
    });
    if (cpu == record.rows.end()) continue;
    for (std::size_t c = 0; c < row.cells.size(); ++c) {
      if (ran(row.cells[c]) && ran(cpu->cells[c]))
        row.cells[c].metrics["device_difference"] = row.cells[c].digest != cpu->cells[c].digest;
    }
  }
}

void run_case(const Scenario& scenario, const RunOptions& options, RunOutcome& outcome) {
  outcome.case_record = run_cells(scenario, options);
  outcome.record.trace_hash = hash_of(*outcome.case_record);
  outcome.metrics = measure(*outcome.case_record);
  const auto interrupted = [&] { return options.control.is_interrupted(); };
  if (options.repeat && !interrupted()) {
    if (hash_of(run_cells(scenario, options)) != outcome.record.trace_hash)
      outcome.repeat_difference = "a second run of the same cells gave other digests; compare cells.csv of two runs";
    outcome.repeated = !interrupted();
  }
  if (!interrupted()) outcome.results = judge(scenario, *outcome.case_record);
}

}  // namespace evenstep::internal

namespace evenstep {

std::int64_t case_cells(const Scenario& scenario) {
  const CaseSpec& spec = *scenario.case_spec;
  return static_cast<std::int64_t>(spec.methods.size() * spec.solver_names().size() * spec.values.size());
}

CaseCell run_case_cell(const Scenario& scenario, std::int64_t cell, const std::atomic<bool>* interrupted) {
  const CaseSpec& spec = *scenario.case_spec;
  const auto i = static_cast<std::size_t>(cell);
  const std::size_t columns = spec.values.size(), solvers = spec.solvers.size(), row = i / columns;
  return internal::run_cell(internal::kind_of(spec),
                            {spec, spec.values[i % columns], spec.methods[row / solvers], spec.solvers[row % solvers]},
                            scenario.seed, interrupted);
}

}  // namespace evenstep
