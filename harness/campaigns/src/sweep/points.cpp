#include "points.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <set>
#include <stdexcept>

#include "evenstep/format/load.h"
#include "evenstep/format/reader.h"
#include "evenstep/harness/run.h"
#include "lines.h"
#include "src/shards/json_parts.h"
#include "swarm.h"

namespace evenstep::internal {
namespace {

/// The header of the sweep that the scenario describes.
SweepHeader header_of(const Scenario& scenario) {
  const SweepSpec& spec = *scenario.sweep;
  SweepHeader header;
  header.name = scenario.name;
  header.file = scenario.file;
  header.build = build_id();
  header.seeds = spec.seeds;
  for (const SweepAxis& axis : spec.grid) header.grid.push_back({axis.path, axis.values});
  for (const Expectation& expectation : scenario.expectations) {
    const Limit& limit = expectation.max ? *expectation.max : *expectation.min;
    header.expectations.push_back({expectation.signal, expectation.metric, limit.unit});
  }
  for (const Sometimes& state : scenario.sometimes)
    header.sometimes.push_back({state.name, state.condition.signal, state.condition.metric});
  if (spec.swarm) {
    for (const ProgrammedFault& fault : scenario.faults) header.swarm.push_back(fault.name);
  }
  header.stop_after = spec.stop_after;
  header.keep_worst = spec.keep_worst;
  if (spec.find) header.find = {spec.find->axis, spec.find->smallest, spec.find->gate, spec.find->allowed};
  return header;
}

SweepVerdict verdict_of(ExpectationResult::Verdict verdict) {
  return verdict == ExpectationResult::Verdict::pass      ? SweepVerdict::pass
         : verdict == ExpectationResult::Verdict::fail    ? SweepVerdict::fail
         : verdict == ExpectationResult::Verdict::skipped ? SweepVerdict::skipped
                                                          : SweepVerdict::error;
}

SweepPoint point_of(std::int64_t index, const RunOutcome& outcome) {
  SweepPoint point;
  point.index = index;
  point.verdict = outcome.exit == ExitCode::pass                 ? SweepVerdict::pass
                  : outcome.exit == ExitCode::expectation_failed ? SweepVerdict::fail
                                                                 : SweepVerdict::error;
  point.trace_hash = outcome.record.trace_hash;
  point.failure = outcome.failure;
  point.reached = outcome.reached;
  for (const ExpectationResult& result : outcome.results) {
    point.expect.push_back(
        {.value = result.value, .min = result.min, .max = result.max, .verdict = verdict_of(result.verdict)});
    if (point.failure.empty() && result.verdict != ExpectationResult::Verdict::skipped) point.failure = result.detail;
  }
  return point;
}

std::string joined(const std::vector<Diagnostic>& errors) {
  std::string out;
  for (const Diagnostic& error : errors) out += (out.empty() ? "" : "\n") + text(error);
  return out;
}

}  // namespace

SweepPoints::SweepPoints(const std::string& path, const ReadOptions& options, std::vector<Diagnostic>& errors)
    : path_(path), registry_(options.registry) {
  Errors of_files;
  document_ = load_with_overrides(path, options, of_files);
  if (of_files.any()) {
    errors = of_files.sorted(path);
    return;
  }
  const ReadResult base = read_document(document_, path, registry_);
  if (!base) {
    errors = base.error();
    return;
  }
  if (!base->sweep) {
    errors.push_back({path, 0, 0, "has no [sweep]; write one, with seeds = \"0..1000\" or a [sweep.grid]"});
    return;
  }
  if (base->expectations.empty() && !base->expect_stop) {
    errors.push_back({path, 1, 1, "has no [[expect]], so every point would pass; say what must hold"});
    return;
  }
  if (base->sweep->swarm && base->has_faults_off) {
    const Place& place = base->sweep->swarm_place;
    errors.push_back({place.file, place.line, place.column,
                      "'swarm' does not go with [run] faults_off, which it writes itself; remove one"});
  }
  for (const Expectation& expectation : base->expectations) {
    const Place& place = expectation.place;
    if (expectation.clock == "wall")
      errors.push_back(
          {place.file, place.line, place.column, "a sweep runs on the virtual clock only; remove clock = \"wall\""});
  }
  if (!errors.empty()) return;
  header_ = header_of(*base);
  std::copy_if(options.set.begin(), options.set.end(), std::back_inserter(header_.set),
               [](const std::string& assignment) { return !assignment.starts_with("sweep."); });
  header_.scenario = digest_of_scenario(document_);
  for (const SweepAxis& axis : base->sweep->grid) {
    axis_places_.push_back(axis.place);
    set_by_points_.push_back(indexed_path(document_, axis.path));
  }
  Value& sweep = *document_.find("sweep");
  if (sweep.find("seeds") != nullptr) set_by_points_.emplace_back("run.seed");
  sweep.table.clear();  // [[sometimes]] needs one
}

std::vector<Diagnostic> SweepPoints::without_effect(const std::vector<std::string>& set) const {
  std::vector<Diagnostic> errors;
  for (const std::string& assignment : set) {
    const std::string key = indexed_path(document_, std::string_view(assignment).substr(0, assignment.find('=')));
    if (std::none_of(set_by_points_.begin(), set_by_points_.end(),
                     [&](const std::string& by) { return is_within(key, by); }))
      continue;
    errors.push_back({"--set " + assignment, 0, 0,
                      key == "run.seed" ? "has no effect: [sweep] has seeds; write sweep.seeds=... instead"
                                        : "has no effect: every point takes this from [sweep.grid]; write sweep.grid={...} "
                                          "instead"});
  }
  return errors;
}

ReadResult SweepPoints::read(std::int64_t point) const {
  return read(point, faults_on(header_.swarm, header_.seed_of(point)));
}

ReadResult SweepPoints::read(std::int64_t point, const std::vector<std::string>& on) const {
  Value document = document_;
  Errors errors;
  for (std::size_t axis = 0; axis < header_.grid.size(); ++axis) {
    const SweepHeader::Axis& one = header_.grid[axis];
    set_value(document, one.path, parse_toml_value(one.values[header_.value_of(point, axis)], axis_places_[axis]), errors);
  }
  const auto seed = static_cast<std::int64_t>(header_.seed_of(point));
  set_value(document, "run.seed", integer_value(seed, {path_, 1, 1}), errors);
  if (!header_.swarm.empty()) {
    Value off;
    off.kind = Value::Kind::list;
    off.place = {path_, 1, 1};
    for (const std::string& name : header_.swarm) {
      if (std::find(on.begin(), on.end(), name) == on.end()) off.list.push_back(text_value(name, off.place));
    }
    set_value(document, "run.faults_off", std::move(off), errors);
  }
  if (errors.any()) return Failure(errors.sorted(path_));
  ReadResult result = read_document(std::move(document), path_, registry_);
  if (!result) return result;
  std::vector<Diagnostic> wrong = check_expectations(*result);
  if (wrong.empty()) wrong = missing_in_build(*result);
  if (!wrong.empty()) return Failure(std::move(wrong));
  return result;
}

std::vector<Diagnostic> SweepPoints::check() const {
  std::vector<Diagnostic> errors;
  std::set<std::string> seen;
  for (std::int64_t point = 0; point < header_.points(); point += std::ssize(header_.seeds)) {
    const auto add = [&](const ReadResult& result) {
      for (const Diagnostic& error : result.error_or({})) {
        if (seen.insert(text(error)).second) errors.push_back(error);
      }
    };
    add(read(point, header_.swarm));
    if (!header_.swarm.empty()) add(read(point, {}));
  }
  return errors;
}

std::string SweepPoints::run(std::int64_t point, const std::atomic<bool>* interrupted) const {
  const ReadResult result = read(point);
  if (!result) throw std::runtime_error(joined(result.error()));
  RunOptions options;
  options.threads = 1;  // the points already keep all cores busy
  options.control.interrupted = interrupted;
  // What is about recovery does not apply to a seed that leaves no fault, and there may be nothing else to judge.
  options.allow_no_expectations = result->has_faults_off && result->faults.empty();
  const RunOutcome outcome = run_scenario(*result, options);
  if (outcome.exit == ExitCode::interrupted) return {};
  SweepPoint line = point_of(point, outcome);
  line.faults_on = faults_on(header_.swarm, header_.seed_of(point));
  return point_line(header_, line);
}

}  // namespace evenstep::internal
