#pragma once
/// A whole run of one scenario: strategies side by side, measures, expectations, run folder.

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/format/scenario.h"
#include "evenstep/harness/input_log.h"
#include "evenstep/harness/live_devices.h"
#include "evenstep/harness/strategy_run.h"
#include "evenstep/reports/case_record.h"
#include "evenstep/reports/measures.h"
#include "evenstep/reports/run_record.h"
#include "evenstep/reports/verdict.h"

namespace evenstep {

enum class ClockKind { virtual_clock, wall };

struct RunOptions {
  ClockKind clock = ClockKind::virtual_clock;
  int threads = 0;                     ///< how many strategies run at the same time; 0 = one per core
  LiveDeviceOptions devices;           ///< wall clock only
  bool repeat = false;                 ///< run twice and compare the traces
  bool growths = false;                ///< measure how errors grow, even if no expectation asks for it
  bool allow_no_expectations = false;  ///< exit 0 for the verdict `none`
  bool allow_degraded = false;         ///< exit 0 for the verdict `degraded`
  std::string record_to;               ///< wall clock only: the recording to write meanwhile; empty: none
  RunOrigin origin;                    ///< for that recording
  const InputLog* replayed = nullptr;  ///< with the scenario of its head: run this, instead of devices on the wall clock
  const std::vector<CaseCell>* cells = nullptr;  ///< of a [case]: what other processes found (run_case_cell), not run again
  RunControl control;
};

/// Exit codes of the command line. For several files the worst one counts, in this order: 130 > 3 > 2 > 4 > 1 > 0.
enum class ExitCode : int {
  pass = 0,
  expectation_failed = 1,
  usage = 2,
  run_failed = 3,
  not_reproducible = 4,
  interrupted = 130
};
ExitCode worse(ExitCode a, ExitCode b);

/// What a run says of its scenario. none: nothing was asserted. degraded: what was tested holds, but expectations about how
/// well the machine kept real time (clock = "wall") do not.
enum class RunVerdict { pass, none, degraded, fail, error };
const char* name_of(RunVerdict verdict);  ///< "pass", "none", ...

struct RunOutcome {
  ExitCode exit = ExitCode::pass;
  RunVerdict verdict = RunVerdict::error;
  RunRecord record;
  std::optional<CaseRecord> case_record;  ///< for a scenario with a [case]; `record` then has no strategy
  Metrics metrics;
  std::vector<ExpectationResult> results;
  std::vector<bool> reached;          ///< for each state of [[sometimes]], if the run was judged
  std::vector<Diagnostic> errors;     ///< errors of the scenario that are found only now (unknown metric, no unit `step`)
  std::string failure, remedy;        ///< if the run failed: what happened and what to do
  bool repeated = false;              ///< a second run was compared with this one
  std::string repeat_difference;      ///< if it was not reproducible: the first event that differs
  std::optional<std::uint64_t> ties;  ///< the seed by which simultaneous events were put in another order
  double cpu_seconds = 0;             ///< CPU time of the process, all threads
  double solver_seconds = 0;          ///< launch + wait, summed over strategies
};
RunOutcome run_scenario(const Scenario& scenario, const RunOptions& options);
/// The record of these strategies in virtual time; nothing is measured or judged. Throws RunFailure.
RunRecord record_run(const Scenario& scenario, const std::vector<StrategyPlan>& plans, const RunOptions& options);

/// How many cells a scenario's [case] has, and one of them: by method, then solver, then value. Throws RunFailure.
std::int64_t case_cells(const Scenario& scenario);
CaseCell run_case_cell(const Scenario& scenario, std::int64_t cell, const std::atomic<bool>* interrupted);

/// Checks that the signals and metrics of the expectations exist, and that `step` has a meaning where it is used. Returns
/// all errors, by position.
std::vector<Diagnostic> check_expectations(const Scenario& scenario);
/// What the run needs and this evenstep is built without (evenstep/time/build_option.h): known before anything runs. On a
/// wall clock this includes what is done in visualizations, and the drivers of real devices.
std::vector<Diagnostic> missing_in_build(const Scenario& scenario, ClockKind clock = ClockKind::virtual_clock,
                                         const std::vector<DeviceBinding>& bindings = {});
Nominal nominal_of(const Scenario& scenario);

}  // namespace evenstep
