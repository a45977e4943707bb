#include "evenstep/harness/run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

#include <algorithm>
#include <array>
#include <filesystem>
#include <glm/geometric.hpp>
#include <map>
#include <optional>

#include "culprit.h"
#include "evenstep/clock/wall_clock.h"
#include "evenstep/harness/live_run.h"
#include "evenstep/harness/run_folder.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/harness/version.h"
#include "evenstep/loop/recorder.h"
#include "evenstep/reports/balance.h"
#include "evenstep/reports/run_failure.h"
#include "evenstep/reports/writers.h"
#include "evenstep/scheduler/parallel_for.h"
#include "evenstep/text/text_file.h"
#include "judge.h"
#include "run_case.h"
#include "src/log/live_log.h"

namespace evenstep {
namespace {

/// Whether an expectation asks how far this strategy's forces are from the ideal twin's.
bool asks_for_twin(const Scenario& scenario, StrategyKind kind) {
  for (const Expectation* condition : conditions_of(scenario)) {
    if (!compares_with_twin(condition->metric)) continue;
    for (const DeviceSpec& device : scenario.devices) {
      if (internal::matches(condition->signal, device.name + ".force." + name_of(kind))) return true;
    }
  }
  return false;
}

/// The scenario of a twin that is no strategy of the run: only its forces are used.
Scenario for_twins(Scenario scenario) {
  scenario.scene.needs_energy = scenario.scene.needs_state_digest = false;
  scenario.keep_rows = scenario.needs_undelayed = false;
  return scenario;
}

/// The hash of the pairs (name, chained hash), in the order of the names.
std::uint64_t hash_of(const std::vector<StrategyRecord>& strategies) {
  std::map<std::string, std::uint64_t> chains;
  for (const StrategyRecord& strategy : strategies) chains[strategy.name] = strategy.trace_hash;
  std::uint64_t hash = 0;
  for (const auto& [name, chain_hash] : chains) hash = mix(mix(hash, name_digest(name)), chain_hash);
  return hash;
}

Rows<Vec3> forces_of(const StrategyRecord& record) {
  Rows<Vec3> forces(record.steps.get_allocator());
  for (std::size_t n = 0; n < record.steps.size(); ++n) {
    for (const DeviceRecord& device : record.devices) forces.push_back(device.steps[n].force_N);
  }
  return forces;
}

RunRecord start_run(const Scenario& scenario, const RunOptions& options) {
  RunRecord run;
  run.scenario = scenario.name;
  run.file = scenario.file;
  run.digest = subject_of(scenario);
  run.seed = scenario.seed;
  run.clock = options.clock == ClockKind::wall ? "wall" : "virtual";
  run.nominal = nominal_of(scenario);
  run.keep_rows = scenario.keep_rows;
  return run;
}

/// The failure to report: a device that still drives is worse than any other reason.
const RunFailure* worst_of(const std::vector<std::optional<RunFailure>>& failures) {
  const RunFailure* worst = nullptr;
  for (const std::optional<RunFailure>& failure : failures) {
    if (failure && (!worst || (failure->reason == kStillDriving && worst->reason != kStillDriving))) worst = &*failure;
  }
  return worst;
}

void run_virtual(const Scenario& scenario, const std::vector<StrategyPlan>& plans, const RunOptions& options,
                 RunRecord& run) {
  // Adds the twins that deviation_from_ideal needs and that the scenario does not list: one per lead, because the forces of
  // an even schedule do not depend on when they are emitted.
  std::vector<StrategyPlan> all = plans;
  std::map<std::int64_t, std::size_t> twin_of_lead;
  for (std::size_t i = 0; i < plans.size(); ++i) {
    if (traits_of(plans[i].kind).knows_motion) twin_of_lead.emplace(plans[i].lead.ns, i);
  }
  for (const StrategyPlan& plan : plans) {
    if (!traits_of(plan.kind).knows_motion && asks_for_twin(scenario, plan.kind) &&
        twin_of_lead.try_emplace(plan.lead.ns, all.size()).second)
      all.push_back(ideal_twin(scenario, plan));
  }
  const Scenario unjudged = for_twins(scenario);
  std::vector<StrategyRecord> records(all.size());
  RunControl unseen = options.control;  // without progress, because several twins have the same name
  unseen.progress = nullptr;
  std::vector<std::optional<RunFailure>> failures(all.size());
  parallel_for(all.size(), options.threads, [&](std::size_t i) {
    try {
      const bool listed = i < plans.size();
      records[i] = run_strategy(listed ? scenario : unjudged, all[i], listed ? options.control : unseen);
    } catch (const RunFailure& failure) {
      failures[i] = failure;
    }
  });
  if (const RunFailure* failure = worst_of(failures)) {
    for (std::size_t i = 0; i < plans.size(); ++i) {
      if (!failures[i])
        run.strategies.push_back(std::move(records[i]));
      else if (failures[i]->so_far)
        run.strategies.push_back(std::move(*failures[i]->so_far));
    }
    throw *failure;
  }
  for (std::size_t i = 0; i < plans.size(); ++i) {
    const auto twin = twin_of_lead.find(plans[i].lead.ns);
    if (!traits_of(plans[i].kind).knows_motion && twin != twin_of_lead.end())
      records[i].twin_force_N = forces_of(records[twin->second]);
  }
  records.resize(plans.size());
  run.strategies = std::move(records);
}

/// What to add to a difference that a part of the program's own made.
std::string culprit_of(const Scenario& scenario, const StrategyRecord& a, const StrategyRecord& b) {
  const std::string culprit = internal::foreign_culprit(scenario, a, b);
  return culprit.empty() ? "" : fmt::format("; {}: it is not reproducible", culprit);
}

InputLogHead head_of(const Scenario& scenario, const RunOptions& options) {
  return {.version = kVersion,
          .build = compiler_here(),
          .scenario_file = internal::portable_path(scenario.file),
          .scenario_text = scenario.resolved_toml,
          .files = {},
          .origin = options.origin,
          .devices = options.devices.bindings,
          .forces = options.devices.forces,
          .permute_ties = options.control.permute_ties,
          .strategy = name_of(scenario.live),
          .tools = static_cast<std::uint32_t>(scenario.devices.size())};
}

/// Null if nothing is to be recorded.
std::unique_ptr<internal::LiveLog> start_log(const Scenario& scenario, const RunOptions& options) {
  if (options.record_to.empty()) return nullptr;
  InputLogHead head = head_of(scenario, options);
  const std::vector<EmbeddedFile> files = take_files(head);
  auto writer = internal::InputLogWriter::create(options.record_to, head, files);
  if (!writer)
    throw RunFailure("disk", fmt::format("--record {}: {}", options.record_to, writer.error()),
                     "give a place that can be written");
  return std::make_unique<internal::LiveLog>(std::move(*writer));
}

/// The live run, and what its recording lacks.
LiveRecording run_and_record(const Scenario& scenario, const StrategyPlan& live, const RunOptions& options, RunRecord& run) {
  const std::unique_ptr<internal::LiveLog> log = start_log(scenario, options);
  LiveRecording recording = run_live(scenario, live, options.devices, options.control, log.get());
  if (log) run.recording_lacks = log->finish(recording, options.record_to);
  run.rights = recording.rights;
  run.real_time_granted = recording.rights.fifo();
  run.visualization = recording.visualization;
  run.drawing_png = std::move(recording.drawing_png);
  return recording;
}

/// All strategies of a run whose live one has been recorded: the others are shadows. The record of the live one moves there.
void add_strategies(const Scenario& scenario, const std::vector<StrategyPlan>& plans, LiveRecording& recording,
                    const RunOptions& options, RunRecord& run) {
  const bool interrupted = options.control.is_interrupted();
  run.live = recording.record.name;
  run.strategies.reserve(plans.size());
  for (const StrategyPlan& plan : plans) {
    if (plan.kind == scenario.live) {
      run.strategies.push_back(std::move(recording.record));
      if (!recording.ran) recording.ran = &run.strategies.back();
    } else if (interrupted) {
      continue;
    } else if (traits_of(plan.kind).knows_motion) {
      run.strategies.push_back(run_strategy(scenario, plan, options.control));
    } else {
      run.strategies.push_back(run_shadow(scenario, plan, recording, options.control));
    }
  }
}

const StrategyPlan& live_plan(const Scenario& scenario, const std::vector<StrategyPlan>& plans) {
  return *std::find_if(plans.begin(), plans.end(), [&](const StrategyPlan& p) { return p.kind == scenario.live; });
}

template <class Run>
auto& strategy_named(Run& run, const std::string& name) {
  return *std::find_if(run.strategies.begin(), run.strategies.end(), [&](const auto& one) { return one.name == name; });
}

/// Runs the live strategy first, then the shadows, then its exact twin (which proves that the recording is complete).
void run_wall(const Scenario& scenario, const std::vector<StrategyPlan>& plans, const RunOptions& options, RunRecord& run,
              std::string& difference) {
  const StrategyPlan& live = live_plan(scenario, plans);
  LiveRecording recording = run_and_record(scenario, live, options, run);
  add_strategies(scenario, plans, recording, options, run);
  if (options.control.is_interrupted()) return;
  StrategyRecord twin = replay(scenario, live, recording, options.control);
  StrategyRecord& ran = strategy_named(run, twin.name);
  ran.tissue = std::move(twin.tissue);
  if (twin.trace_hash == ran.trace_hash) return;
  const auto found = first_difference({ran}, {twin});
  difference = found ? "the recorded run and its virtual twin differ: " + found->text + culprit_of(scenario, ran, twin)
                     : "hashes differ, events do not";
}

/// The same of a recording. One that ends early is measured, and shadowed, up to where both lanes are in it.
void run_recorded(const Scenario& scenario, const std::vector<StrategyPlan>& plans, const RunOptions& options,
                  RunRecord& run, std::string& difference) {
  const InputLog& log = *options.replayed;
  LogReplay replayed = replay(scenario, live_plan(scenario, plans), log, options.control);
  run.real_time_granted = !log.end || log.end->real_time_granted;
  difference = replayed.difference;
  Scenario as_far = scenario;
  if (!log.whole()) as_far.run_duration = replayed.until - RealTime{0};
  run.nominal.end = RealTime{as_far.run_duration.ns};
  add_strategies(as_far, plans, replayed.recording, options, run);
}

void finish(RunRecord& run) {
  run.trace_hash = hash_of(run.strategies);
  for (const StrategyRecord& strategy : run.strategies) {
    if (run.left_out.empty()) run.left_out = strategy.solver.left_out;
  }
}

/// If it throws, `run` contains what was recorded until then.
void run_once(const Scenario& scenario, const RunOptions& options, RunRecord& run, std::string& difference) {
  run = start_run(scenario, options);
  const std::vector<StrategyPlan> plans = plan(scenario);
  if (options.replayed)
    run_recorded(scenario, plans, options, run, difference);
  else if (options.clock == ClockKind::wall)
    run_wall(scenario, plans, options, run, difference);
  else
    run_virtual(scenario, plans, options, run);
  finish(run);
}

std::string compare(const Scenario& scenario, const RunRecord& a, const RunRecord& b) {
  if (a.trace_hash == b.trace_hash) return {};
  const auto found = first_difference(a.strategies, b.strategies);
  if (!found || found->index < 0) return found ? found->text : "the hashes differ but no event does";
  return found->text + culprit_of(scenario, strategy_named(a, found->strategy), strategy_named(b, found->strategy));
}

int severity(ExitCode code) {
  switch (code) {
    case ExitCode::pass:
      return 0;
    case ExitCode::expectation_failed:
      return 1;
    case ExitCode::not_reproducible:
      return 2;
    case ExitCode::usage:
      return 3;
    case ExitCode::run_failed:
      return 4;
    case ExitCode::interrupted:
      return 5;
  }
  return 4;
}

/// Judges a run that stopped: it passes if the scenario expected that.
void judge_stop(const Scenario& scenario, const RunFailure& failure, RunOutcome& outcome) {
  outcome.failure = failure.what();
  outcome.remedy = failure.remedy;
  outcome.exit = ExitCode::run_failed;
  if (!scenario.expect_stop || scenario.expect_stop->reason != failure.reason) return;
  const auto& [reason, message, at_least, at_most, place] = *scenario.expect_stop;
  std::string other;
  if (outcome.failure.find(message) == std::string::npos) other += fmt::format("; it was expected to say \"{}\"", message);
  if ((at_least && failure.step < *at_least) || (at_most && failure.step > *at_most))
    other += fmt::format("; it was expected earlier or later than after {} steps", failure.step);
  outcome.failure += other;
  outcome.exit = other.empty() ? ExitCode::pass : ExitCode::expectation_failed;
}

void count_results(RunOutcome& outcome) {
  const ExpectationResult::Verdict judged = worst(outcome.results);
  if (judged == ExpectationResult::Verdict::fail) outcome.exit = worse(outcome.exit, ExitCode::expectation_failed);
  if (judged == ExpectationResult::Verdict::error) outcome.exit = worse(outcome.exit, ExitCode::usage);
}

RunVerdict verdict_of(ExitCode code) {
  switch (code) {
    case ExitCode::pass:
      return RunVerdict::pass;
    case ExitCode::expectation_failed:
    case ExitCode::not_reproducible:
      return RunVerdict::fail;
    case ExitCode::usage:
    case ExitCode::run_failed:
    case ExitCode::interrupted:
      return RunVerdict::error;
  }
  return RunVerdict::error;
}

/// Where nothing failed, whether that says anything: at least one expectation, or [expect_stop], was judged, and the machine
/// was fast enough.
void conclude(const Scenario& scenario, const RunOptions& options, RunOutcome& outcome) {
  outcome.verdict = verdict_of(outcome.exit);
  if (outcome.exit != ExitCode::pass) return;
  const ExpectationResult::Verdict judged = worst(outcome.results);
  if (judged == ExpectationResult::Verdict::skipped && !scenario.expect_stop) outcome.verdict = RunVerdict::none;
  if (judged == ExpectationResult::Verdict::degraded) outcome.verdict = RunVerdict::degraded;
  const bool allowed = outcome.verdict == RunVerdict::pass ||
                       (outcome.verdict == RunVerdict::none && options.allow_no_expectations) ||
                       (outcome.verdict == RunVerdict::degraded && options.allow_degraded);
  if (!allowed) outcome.exit = ExitCode::expectation_failed;
}

/// A run that a signal has ended is measured up to there.
void end_early(RunRecord& run) {
  RealTime reached{0};
  for (const StrategyRecord& strategy : run.strategies) {
    if (!strategy.interrupted) return;
    for (const DeviceRecord& device : strategy.devices) {
      if (!device.ticks.empty()) reached = std::max(reached, device.ticks.back().at + Duration{1});
    }
  }
  if (!run.strategies.empty()) run.nominal.end = std::min(run.nominal.end, reached);
}

/// Numbers of a run that has lost something without counting it are worth nothing.
void refuse_imbalance(const RunRecord& run) {
  const std::vector<std::string> broken = imbalances(run);
  if (broken.empty()) return;
  throw RunFailure("imbalance", fmt::format("the counts of the run do not add up: {}", fmt::join(broken, "; ")),
                   "this is a defect of evenstep, or of a driver of your own; please report it with the scenario");
}

void measure(const Scenario& scenario, const RunOptions& options, RunOutcome& outcome) {
  outcome.metrics = evenstep::measure(outcome.record);
  const std::vector<const Expectation*> conditions = conditions_of(scenario);
  const auto asks = [](const Expectation* condition) { return is_growth(condition->metric); };
  if (options.growths || std::any_of(conditions.begin(), conditions.end(), asks))
    add_growths(outcome.record, outcome.metrics);
}

void judge(const Scenario& scenario, RunOutcome& outcome) {
  outcome.results = internal::judge(scenario, outcome.record, outcome.metrics);
  for (const Sometimes& state : scenario.sometimes)
    outcome.reached.push_back(internal::reaches(state.condition, scenario, outcome.record.nominal, outcome.metrics));
}

/// If the run stopped as [expect_stop] says, the other expectations are judged by what was recorded until then. After any
/// other stop nothing is judged.
void judge_stopped(const Scenario& scenario, const RunOptions& options, RunOutcome& outcome) {
  if (outcome.exit != ExitCode::pass || scenario.case_spec) {
    outcome.record.strategies.clear();
    return;
  }
  outcome.record.trace_hash = hash_of(outcome.record.strategies);
  measure(scenario, options, outcome);
  judge(scenario, outcome);
  count_results(outcome);
}

/// The failure of a run if [run] interrupt has ended its strategies; empty if it ran to its end.
std::optional<RunFailure> interruption(const Scenario& scenario, const RunRecord& run) {
  std::size_t steps = 0;
  for (const StrategyRecord& strategy : run.strategies) {
    if (!strategy.interrupted) return std::nullopt;
    steps = std::max(steps, strategy.steps.size());
  }
  if (!scenario.interrupt || run.strategies.empty()) return std::nullopt;
  return RunFailure("interrupted", fmt::format("interrupted at {:.6g} s by [run] interrupt", seconds(*scenario.interrupt)),
                    "a scenario says with [expect_stop] reason = \"interrupted\" that this is right",
                    static_cast<std::int64_t>(steps));
}

std::string objection_to(const Scenario& scenario, const RunOptions& options) {
  if (!options.record_to.empty() && options.clock != ClockKind::wall)
    return "--record keeps the inputs of a run on the wall clock; on the virtual clock the scenario is all there is to "
           "keep: "
           "add --clock wall, or leave it out";
  if (std::error_code error; std::filesystem::is_regular_file(options.record_to, error))
    return fmt::format("--record {}: exists already; a recording is never overwritten: give another name, or remove it",
                       options.record_to);
  if (options.clock == ClockKind::wall) {
    const std::string objection = wall_clock_objection(scenario);
    return objection.empty() ? binding_objection(scenario, options.devices.bindings) : objection;
  }
  return options.devices.bindings.empty() ? ""
                                          : "a real device cannot wait for a virtual clock; --device needs --clock wall";
}

/// A recording that was asked for and is not complete is like a run folder that cannot be written: whatever was judged, the
/// run has failed.
void add_recording_failure(RunOutcome& outcome) {
  if (outcome.record.recording_lacks.empty()) return;
  outcome.failure += (outcome.failure.empty() ? "" : "\n") + outcome.record.recording_lacks;
  outcome.remedy = "free some space, or give a place on another disk; what is in the file replays";
  outcome.exit = worse(outcome.exit, ExitCode::run_failed);
}

/// Everything but the verdict of the run as a whole.
RunOutcome run_and_judge(const Scenario& scenario, const RunOptions& options) {
  RunOutcome outcome;
  outcome.ties = options.control.permute_ties;
  outcome.errors = check_expectations(scenario);
  const bool live = options.clock == ClockKind::wall && !options.replayed;
  std::vector<Diagnostic> missing =
      live ? missing_in_build(scenario, options.clock, options.devices.bindings) : missing_in_build(scenario);
  std::move(missing.begin(), missing.end(), std::back_inserter(outcome.errors));
  if (const std::string objection = objection_to(scenario, options); !objection.empty())
    outcome.errors.push_back({scenario.file, 0, 0, objection});
  outcome.record = start_run(scenario, options);
  if (!outcome.errors.empty()) {
    outcome.exit = ExitCode::usage;
    return outcome;
  }

  const auto count_seconds = [&, cpu_before = process_cpu_seconds()] {
    outcome.cpu_seconds = process_cpu_seconds() - cpu_before;
    for (const StrategyRecord& strategy : outcome.record.strategies)
      outcome.solver_seconds += strategy.solver.solver_seconds;
  };
  try {
    const auto interrupted = [&] { return options.control.is_interrupted(); };
    const bool whole = !options.replayed || options.replayed->whole();
    if (scenario.case_spec) {
      internal::run_case(scenario, options, outcome);
    } else {
      std::string& difference = outcome.repeat_difference;
      run_once(scenario, options, outcome.record, difference);
      if (options.repeat && !interrupted()) {
        RunRecord again;
        RunOptions unrecorded = options;
        unrecorded.record_to.clear();
        run_once(scenario, unrecorded, again, difference);
        difference = compare(scenario, outcome.record, again);
        outcome.repeated = !interrupted();
      }
      if (!options.replayed) end_early(outcome.record);
      if (difference.empty()) refuse_imbalance(outcome.record);  // a replay that differs from the run need not add up
      measure(scenario, options, outcome);
      if (!interrupted() && whole) judge(scenario, outcome);
    }
    add_recording_failure(outcome);
    if (interrupted()) {
      outcome.exit = ExitCode::interrupted;
      count_seconds();
      return outcome;
    }
  } catch (const RunFailure& failure) {
    judge_stop(scenario, failure, outcome);
    judge_stopped(scenario, options, outcome);
    count_seconds();
    return outcome;
  }
  count_seconds();
  if (const auto stopped = interruption(scenario, outcome.record)) {
    judge_stop(scenario, *stopped, outcome);
  } else if (scenario.expect_stop) {
    outcome.failure = fmt::format("the run was expected to stop ({}), but it ran to its end", scenario.expect_stop->reason);
    outcome.exit = ExitCode::expectation_failed;
  }
  count_results(outcome);
  if (!outcome.repeat_difference.empty()) outcome.exit = worse(outcome.exit, ExitCode::not_reproducible);
  return outcome;
}

}  // namespace

ExitCode worse(ExitCode a, ExitCode b) { return severity(a) >= severity(b) ? a : b; }

Nominal nominal_of(const Scenario& scenario) {
  Nominal nominal;
  nominal.segment = scenario.nominal.segment;
  nominal.visualization = scenario.nominal.visualization;
  nominal.step_run_time = scenario.nominal.step_run_time;
  nominal.slot_s = period_s(scenario.scene.step_rate);
  nominal.judged_from = RealTime{scenario.warmup.ns};
  nominal.end = RealTime{scenario.run_duration.ns};
  nominal.faults = scenario.faults;
  nominal.recovery_latency = scenario.recovery_latency;
  nominal.recovery_jump = scenario.recovery_jump;
  const auto* spring = std::get_if<SpringScene>(&scenario.scene.body);
  for (const DeviceSpec& device : scenario.devices) {
    Nominal::Device& named = nominal.devices.emplace_back();
    named.name = device.name;
    named.rate = device.rate;
    named.first_tick = RealTime{device.phase.ns};
    named.force_delay = device.force_delay;
    named.feels_force = device.hand.has_value();
    if (spring) named.stiffness_N_per_m = spring->stiffness_N_per_m;
    if (device.hand) continue;  // the rest is about the motion, which for a hand is only its intended path
    if (const auto* constant = std::get_if<ConstantVelocity>(&device.motion.shape))
      named.speed_m_per_s = glm::length(constant->velocity_m_per_s);
    if (const auto* turning = std::get_if<BackAndForth>(&device.motion.shape)) {
      named.speed_m_per_s = glm::length(turning->start.velocity_m_per_s);
      if (!device.is_real)
        named.turns = Nominal::Turns{device.motion.begin + turning->start.smooth_start, turning->straight, turning->turn};
    }
    if (const auto* sine = std::get_if<Sine>(&device.motion.shape)) {
      const double frequency_Hz = static_cast<double>(sine->frequency.num) / static_cast<double>(sine->frequency.den);
      named.sine = Nominal::Sine{to_vec3(sine->amplitude_m), frequency_Hz, seconds(device.motion.begin - RealTime{0})};
    }
    if (const auto* stop = std::get_if<RampStop>(&device.motion.shape))
      named.stop_at = stop->stop + (device.motion.begin - RealTime{0});
  }
  return nominal;
}

const char* name_of(RunVerdict verdict) {
  constexpr std::array kNames{"pass", "none", "degraded", "fail", "error"};
  return kNames.at(static_cast<std::size_t>(verdict));
}

RunRecord record_run(const Scenario& scenario, const std::vector<StrategyPlan>& plans, const RunOptions& options) {
  RunRecord run = start_run(scenario, options);
  run_virtual(scenario, plans, options, run);
  finish(run);
  return run;
}

RunOutcome run_scenario(const Scenario& as_read, const RunOptions& options) {
  const Scenario scenario = with_live_guards(as_read, options.devices.bindings);
  RunOutcome outcome = run_and_judge(scenario, options);
  conclude(scenario, options, outcome);
  return outcome;
}

}  // namespace evenstep
