// run, check, size, study and compare. What they find is handed to Python as the JSON documents that the program's --json
// prints, and the columns of a run's record as arrays of numpy that lie where the record does.

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>

#include "evenstep/apps/explain.h"
#include "evenstep/apps/origin.h"
#include "evenstep/campaigns/compare.h"
#include "evenstep/campaigns/felt_study.h"
#include "evenstep/campaigns/size.h"
#include "evenstep/campaigns/stiffness_limit.h"
#include "evenstep/campaigns/study.h"
#include "evenstep/clock/wall_clock.h"
#include "evenstep/harness/run_folder.h"
#include "evenstep/harness/version.h"
#include "evenstep/reports/felt_study_record.h"
#include "evenstep/reports/run_failure.h"
#include "evenstep/text/option_values.h"
#include "parts.h"

namespace evenstep::python {
namespace {

/// A finished run: what its arrays lie in.
struct Run {
  Scenario scenario;
  RunOutcome outcome;
};

/// A column of a table of rows: its name, its type in numpy's words, and where it lies in a row.
struct Column {
  const char *name, *format;
  std::size_t offset;
};
template <class Row, class Member>
Column column(const char* name, const char* format, Member Row::*member) {
  static const Row row{};
  return {name, format,
          static_cast<std::size_t>(reinterpret_cast<const char*>(&(row.*member)) - reinterpret_cast<const char*>(&row))};
}

/// The rows as an array with these fields. Nothing is copied: `owner` lives as long as the array.
template <class Row>
py::array table(const Rows<Row>& rows, const std::vector<Column>& columns, const py::object& owner) {
  py::list names, formats, offsets;
  for (const Column& one : columns) names.append(one.name), formats.append(one.format), offsets.append(one.offset);
  const py::dtype type(names, formats, offsets, sizeof(Row));
  py::array array(type, {static_cast<py::ssize_t>(rows.size())}, {static_cast<py::ssize_t>(sizeof(Row))}, rows.data(),
                  owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

constexpr const char *kInt = "<i8", *kBool = "?", *kByte = "u1", *kVector = "(3,)<f8";

py::dict series_of(const py::object& owner) {
  const RunRecord& record = py::cast<const Run&>(owner).outcome.record;
  const std::vector<Column> steps = {
      column("segment", kInt, &StepRow::segment),      column("begin_ns", kInt, &StepRow::begin),
      column("end_ns", kInt, &StepRow::end),           column("read_ns", kInt, &StepRow::read),
      column("emission_ns", kInt, &StepRow::emission), column("mapped", kBool, &StepRow::mapped)};
  const std::vector<Column> tools = {column("position_m", kVector, &StepSample::position_m),
                                     column("force_N", kVector, &StepSample::force_N),
                                     column("read", kByte, &StepSample::read)};
  const std::vector<Column> ticks = {column("at_ns", kInt, &TickRow::at), column("lateness_ns", kInt, &TickRow::lateness),
                                     column("position_m", kVector, &TickRow::position_m),
                                     column("force_N", kVector, &TickRow::force_N),
                                     column("started", kBool, &TickRow::started)};
  const std::vector<Column> segments = {column("index", kInt, &SegmentRow::index),
                                        column("begin_ns", kInt, &SegmentRow::begin),
                                        column("end_ns", kInt, &SegmentRow::end)};
  const std::vector<Column> events = {column("at_ns", kInt, &EventRow::time), column("lane", kByte, &EventRow::lane),
                                      column("name", "<u2", &EventRow::name),
                                      column("hash", "<u8", &EventRow::chained_hash)};
  py::dict all;
  for (const StrategyRecord& strategy : record.strategies) {
    py::dict devices;
    for (const DeviceRecord& device : strategy.devices)
      devices[py::str(device.name)] = py::make_tuple(table(device.steps, tools, owner), table(device.ticks, ticks, owner));
    all[py::str(strategy.name)] =
        py::make_tuple(table(strategy.steps, steps, owner), table(strategy.segments, segments, owner),
                       table(strategy.events, events, owner), strategy.event_names, devices);
  }
  return all;
}

RunOptions options_of(const Scenario& scenario, int threads, bool repeat, std::optional<std::uint64_t> permute_ties) {
  RunOptions options;
  options.threads = threads;
  options.repeat = repeat;
  options.growths = true;
  options.control.permute_ties = permute_ties;
  options.control.picture = true;
  const Result<std::string> date = date_of_run(std::getenv, unix_seconds());
  if (!date) raise({{"SOURCE_DATE_EPOCH", 0, 0, date.error()}});
  options.origin = {*date, commit_of(scenario.file, std::getenv)};
  return options;
}

std::shared_ptr<Run> run(const std::string& file, const std::vector<std::string>& set, std::optional<std::uint64_t> seed,
                         const py::dict& parts, int threads, bool repeat, std::optional<std::uint64_t> permute_ties) {
  WithParts with = read_with_parts(file, set, seed, parts);
  if (!with.scenario) {
    const py::object cause = with.error->value();
    std::string message;
    for (const Diagnostic& error : with.scenario.error()) message += (message.empty() ? "" : "\n") + text(error);
    raise("ScenarioError", message, with.scenario.error(), "", py::none(), cause);
  }
  if (const std::vector<Diagnostic> missing = missing_in_build(*with.scenario); !missing.empty()) raise(missing);
  warn(with.scenario->timing.trace_file, with.scenario->timing.trace_damage);
  auto done = std::make_shared<Run>(Run{*std::move(with.scenario), {}});
  RunOptions options = options_of(done->scenario, threads, repeat, permute_ties);
  const Interruptible interruptible;
  options.control.interrupted = interruptible.interrupted();
  {
    const py::gil_scoped_release without_gil;
    done->outcome = run_scenario(done->scenario, options);
    done->outcome.record.origin = options.origin;
  }
  interruptible.raise_if();
  const RunOutcome& outcome = done->outcome;
  if (!outcome.errors.empty()) raise(outcome.errors);
  if (outcome.exit == ExitCode::run_failed)
    raise("RunFailed", outcome.failure, {}, outcome.remedy, py::cast(done), with.error->value());
  if (outcome.exit == ExitCode::not_reproducible)
    raise("NotReproducible", outcome.repeat_difference, {}, "", py::cast(done), with.error->value());
  return done;
}

/// Takes the value of an option, written as on the command line; `parse` gives a Result or an optional.
class Options {
 public:
  explicit Options(const py::dict& given) : given_(given) {}
  std::string text(const char* name) { return take(name, std::string()); }
  template <class Value>
  Value take(const char* name, Value otherwise) {
    known_.append(name);
    return given_.contains(name) ? py::cast<Value>(given_[name]) : otherwise;
  }
  template <class Parse, class Value>
  void parsed(const char* name, Parse parse, Value& into) {
    const std::string word = text(name);
    if (word.empty()) return;
    const auto result = parse(word);
    if (!result) raise({{std::string(name) + "=", 0, 0, result.error()}});
    into = *result;
  }
  bool has(const char* name) const { return given_.contains(name); }
  /// Raises TypeError for an option that nobody has taken.
  void finish(const char* of) const {
    for (const auto& [name, value] : given_) {
      if (!py::cast<bool>(known_.attr("__contains__")(name)))
        throw py::type_error(fmt::format("{} has no option '{}'; it has {}", of, py::cast<std::string>(name),
                                         py::cast<std::string>(py::str(", ").attr("join")(known_))));
    }
  }

 private:
  py::dict given_;
  py::list known_;
};

SizeOptions size_options(Options& given) {
  SizeOptions options;
  given.parsed("sampling", parse_period_or_rate, options.sampling);
  given.parsed("step_size", parse_period_or_rate, options.step_size);
  given.parsed(
      "emission",
      [](const std::string& word) -> Result<Emission> {
        if (word == "linear" || word == "hold") return word == "linear" ? Emission::linear : Emission::hold;
        return Failure("\"" + word + "\" is neither \"hold\" nor \"linear\"");
      },
      options.emission);
  given.parsed("rate", parse_share, options.rate);
  given.parsed("confidence", parse_share, options.confidence);
  given.parsed("per", parse_span, options.per);
  given.parsed(
      "damping", [](const std::string& word) { return parse_above_zero(word, Dimension::damping, "N s/m"); },
      options.damping_N_s_per_m);
  given.parsed(
      "fits", [](const std::string& word) { return parse_fits(word); }, options.fits);
  given.parsed(
      "worst_order", [](const std::string& word) { return parse_worst_order(word); }, options.worst_order);
  for (const std::string& word : given.take("what_if", std::vector<std::string>())) {
    const Result<WhatIf> what_if = parse_what_if(word);
    if (!what_if) raise({{"what_if=", 0, 0, what_if.error()}});
    options.what_ifs.push_back(*what_if);
  }
  if (given.has("confidence") && !options.rate && !options.per)
    raise({{"confidence=", 0, 0, "goes with a rate or a span, which say of what; for example rate=\"0.1 %\""}});
  options.adaptive = given.take("adaptive", false);
  options.other_maps = given.take("other_maps", false);
  return options;
}

RecordingOptions recording_options(Options& given) {
  RecordingOptions options;
  options.roles.segment = given.text("segment");
  options.roles.visualization = given.text("visualization");
  options.roles.step = given.text("step");
  options.roles.step_begin = given.text("step_begin");
  options.roles.process = given.text("process");
  options.roles.steps = given.take("steps", std::int64_t{0});
  given.parsed(
      "step_time", [](const std::string& word) { return parse_duration(word); }, options.roles.step_time);
  if (given.has("steps") != given.has("step_time"))
    raise({{"steps=", 0, 0, "goes with step_time=: so many steps, each so long"}});
  options.preset = given.text("preset");
  options.profile.format = given.text("format");
  return options;
}

std::string size(const std::string& file, const py::dict& options, const py::dict& parts) {
  Options given(options);
  const auto set = given.take("set", std::vector<std::string>());
  const SizeOptions asked = size_options(given);
  const RecordingOptions recording = recording_options(given);
  given.finish("size");
  SizeResult result;
  if (std::filesystem::path(file).extension() == ".toml") {
    for (const char* of_recordings : {"sampling", "emission", "step_size"}) {
      if (options.contains(of_recordings))
        raise({{file, 0, 0, std::string(of_recordings) + "= belongs to a recording; a scenario says it itself"}});
    }
    const WithParts with = read_with_parts(file, set, std::nullopt, parts);
    if (!with.scenario) raise(with.scenario.error());
    const py::gil_scoped_release without_gil;
    result = size_scenario(*with.scenario, asked);
  } else {
    if (!set.empty()) raise({{"set=", 0, 0, "belongs to a scenario (*.toml); a recording has no keys to set"}});
    const py::gil_scoped_release without_gil;
    result = size_recording(file, asked, recording);
  }
  if (!result.errors.empty()) raise(result.errors);
  warn(file, result.damage);
  if (result.record.fit && !result.record.fit->refused.empty()) raise({{"fits=", 0, 0, result.record.fit->refused}});
  if (result.record.worst_order && !result.record.worst_order->refused.empty())
    raise({{"worst_order=", 0, 0, result.record.worst_order->refused}});
  return size_json(result.record);
}

std::string check(const std::string& file, const std::vector<std::string>& set, std::optional<std::uint64_t> seed,
                  const py::dict& parts) {
  ReadOptions options{set, seed};
  options.registry = registry_of(parts, std::make_shared<FirstError>());
  Explained explained;
  {
    const py::gil_scoped_release without_gil;
    explained = explain_scenario(file, options);
  }
  if (!explained.errors.empty()) raise(explained.errors);
  warn(file, explained.damage);
  return explained.json;
}

std::string study(const std::string& file, const std::vector<std::string>& set, const std::string& cache_folder,
                  const py::dict& parts) {
  WithParts with = read_with_parts(file, set, std::nullopt, parts);
  if (!with.scenario) raise(with.scenario.error());
  const Scenario& scenario = *with.scenario;
  const bool felt = scenario.study.error == StudyError::felt_force;
  std::string objection;
  if (!scenario.study.stiffness_limit && felt) objection = felt_study_objection(scenario);
  if (!scenario.study.stiffness_limit && !felt && !std::holds_alternative<TissueScene>(scenario.scene.body))
    objection = "error = \"state\" compares the steps of a tissue; write kind = \"tissue\"";
  if (!objection.empty()) raise({{file, 0, 0, objection}});
  const Interruptible interruptible;
  const std::atomic<bool>* const interrupted = interruptible.interrupted();
  std::string json;
  try {
    const py::gil_scoped_release without_gil;
    if (scenario.study.stiffness_limit)
      json = stiffness_json(run_stiffness_limits(scenario, {interrupted, {}}));
    else if (felt)
      json = felt_study_json(run_felt_study(scenario, {interrupted, {}, {}, cache_folder}));
    else
      json = study_json(run_study(scenario, {interrupted, {}}));
  } catch (const RunFailure& failure) {
    raise("RunFailed", failure.what(), {}, failure.remedy, py::none(), with.error->value());
  }
  interruptible.raise_if();
  return json;
}

CompareSide side_of(const py::object& given) {
  if (py::isinstance<Run>(given)) {
    const RunOutcome& outcome = py::cast<const Run&>(given).outcome;
    const std::string name = outcome.record.file;
    Result<std::vector<RunSummary>, std::vector<Diagnostic>> runs = parse_summaries(summary_of(outcome), name);
    if (!runs) raise(runs.error());
    return {name, *std::move(runs)};
  }
  const auto path = py::cast<std::string>(given);
  SummariesRead read = read_summaries(path);
  if (!read.errors.empty()) raise(read.errors);
  return {path, std::move(read.runs)};
}

py::tuple compare_sides(const py::object& a, const py::object& b, const std::vector<std::string>& fail_if,
                        bool allow_missing) {
  std::vector<Threshold> thresholds;
  for (const std::string& text : fail_if) {
    const Result<Threshold, Diagnostic> threshold = parse_threshold(text);
    if (!threshold) raise(std::vector{threshold.error()});
    thresholds.push_back(*threshold);
  }
  const ComparisonRecord record = compare(side_of(a), side_of(b), thresholds, allow_missing);
  return py::make_tuple(comparison_json(record), record.holds());
}

void write(const Run& run, const std::string& folder, const std::string& reproduce) {
  std::string error = run_folder_objection(folder);
  if (error.empty()) {
    const py::gil_scoped_release without_gil;
    error = write_run_folder(folder, run.scenario, run.outcome, reproduce);
  }
  if (!error.empty()) raise("Error", error);
}

std::vector<std::string> failures_of(const Run& run) {
  std::vector<std::string> failures;
  for (const ExpectationResult& result : run.outcome.results) {
    if (result.verdict > ExpectationResult::Verdict::pass)
      failures.push_back(fmt::format("{}:{}:{}: {}", result.file, result.line, result.column, failure_message(result)));
  }
  return failures;
}

}  // namespace

void define_runs(py::module_& module) {
  py::class_<Run, std::shared_ptr<Run>>(module, "Run")
      .def_property_readonly("exit", [](const Run& run) { return static_cast<int>(run.outcome.exit); })
      .def_property_readonly("verdict", [](const Run& run) { return name_of(run.outcome.verdict); })
      .def_property_readonly("trace_hash",
                             [](const Run& run) { return fmt::format("{:016x}", run.outcome.record.trace_hash); })
      .def_property_readonly("metrics", [](const Run& run) { return run.outcome.metrics; })
      .def_property_readonly("strategies",
                             [](const Run& run) {
                               std::vector<std::string> names;
                               for (const StrategyRecord& strategy : run.outcome.record.strategies)
                                 names.push_back(strategy.name);
                               return names;
                             })
      .def_property_readonly("failures", &failures_of)
      .def("summary", [](const Run& run) { return summary_of(run.outcome); })
      .def("text",
           [](const Run& run) {
             return strategy_table(run.outcome.record, run.outcome.metrics) + verdict_table(run.outcome.results, false);
           })
      .def("write", &write);
  module.def("series", &series_of);
  module.def("run", &run);
  module.def("check", &check);
  module.def("size", &size);
  module.def("study", &study);
  module.def("compare", &compare_sides);
  module.attr("version") = kVersion;
}

}  // namespace evenstep::python
