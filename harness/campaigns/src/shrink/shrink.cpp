#include "evenstep/campaigns/shrink.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <stdexcept>

#include "document.h"
#include "evenstep/format/load.h"
#include "evenstep/format/reader.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/harness/underrun_rate.h"
#include "evenstep/recordings/timing_csv.h"
#include "evenstep/text/text_file.h"
#include "search.h"
#include "timing.h"

namespace evenstep {
namespace fs = std::filesystem;
namespace {

using internal::Value;

struct Interrupted {};

void write_text(const std::string& path, const std::string& text) {
  const std::string error = internal::write_text_file(path, text);
  if (!error.empty()) throw std::runtime_error(fmt::format("'{}' {}", path, error));
}

/// A folder for the recording of a candidate, which is removed at the end.
struct ScratchFolder {
  ScratchFolder() : path(fs::temp_directory_path() / fmt::format("evenstep-shrink-{}", ::getpid())) {
    fs::create_directories(path);
  }
  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  fs::path path;
};

/// Strategies that decide an expectation: the one its signal names, or all.
std::vector<StrategyKind> strategies_of(const Scenario& scenario, const std::string& signal) {
  for (const StrategyKind kind : scenario.strategies) {
    if (!signal.starts_with("events.") && signal.ends_with(fmt::format(".{}", name_of(kind)))) return {kind};
  }
  return scenario.strategies;
}

/// Whether the value was too high. That may come from a few late steps, whereas leaving data out only makes "too low"
/// easier.
bool too_high(const ExpectationResult& result) {
  return !result.expect_fail && result.max && result.value && (!result.min || *result.value > *result.min);
}

class Shrink {
 public:
  Shrink(Value document, const Scenario& scenario, std::size_t expectation, const ShrinkOptions& options,
         ShrinkOutcome& outcome)
      : options_(options),
        outcome_(outcome),
        shape_(scenario),
        path_(scenario.file),
        wanted_(scenario.run_duration),
        segments_(shape_.segments()) {
    document_ = internal::fixed_document(std::move(document), scenario,
                                         strategies_of(scenario, scenario.expectations[expectation].signal), expectation);
    outcome_.perturbations_before = shape_.perturbations().size();
    outcome_.duration_before = scenario.run_duration;
  }

  /// Throws std::runtime_error, Interrupted.
  void run() {
    kept_ = shape_.perturbations();
    const std::optional<ExpectationResult> whole = judged(kept_, segments_);
    if (!whole && !objection_.empty())
      throw std::runtime_error(fmt::format("the same timing cannot be replayed as a recording: {}", objection_));
    if (!whole || whole->verdict != ExpectationResult::Verdict::fail) {
      throw std::runtime_error(
          "the expectation fails, but not when the same timing is replayed as a recording: it depends on the "
          "nominal times of [timing]");
    }
    const bool cuttable = too_high(*whole);
    if (!keep_one()) {
      if (cuttable) cut();
      keep_fewest();
    }
    keep_smallest();
    if (cuttable) cut();
    outcome_.perturbations = kept_;
    outcome_.minimal = go_on();
  }

  void write(const ExpectationResult& before);

 private:
  bool go_on() const { return outcome_.runs < options_.max_runs; }
  bool fails(const std::vector<Perturbation>& perturbations, std::size_t segments) {
    const std::optional<ExpectationResult> result = judged(perturbations, segments);
    return result && result->verdict == ExpectationResult::Verdict::fail;
  }
  std::optional<ExpectationResult> judged(const std::vector<Perturbation>& perturbations, std::size_t segments);
  std::optional<ExpectationResult> judged_document(const Value& document);
  Duration duration_of(const std::vector<SegmentTiming>& timing) const;
  void cut();
  bool keep_one();
  void keep_fewest();
  bool fails_with(const std::vector<Perturbation>& all, const std::vector<std::size_t>& set);
  void keep_smallest();
  std::vector<std::pair<std::string, std::string>> take_files(Value& document, const std::string& stem) const;

  const ShrinkOptions& options_;
  ShrinkOutcome& outcome_;
  internal::TimingShape shape_;
  std::string path_;
  Value document_;
  Duration wanted_;       // duration of the original run
  std::size_t segments_;  // number of segments that are left
  std::vector<Perturbation> kept_;
  std::string objection_;  // why the last candidate could not be read; no candidate should be like that
  ScratchFolder scratch_;
};

/// The original duration of the run, or that of the timing if the run was cut.
Duration Shrink::duration_of(const std::vector<SegmentTiming>& timing) const {
  const Duration length = replay_duration(timing) - (timing.front().begin - RealTime{});
  return timing.size() < shape_.segments() ? length : std::min(wanted_, length);
}

std::optional<ExpectationResult> Shrink::judged_document(const Value& document) {
  ++outcome_.runs;
  const ReadResult read = internal::read_document(document, path_, options_.registry);
  if (!read) {
    objection_ = read.error().front().message;
    return std::nullopt;
  }
  Scenario scenario = *read;
  scenario.keep_rows = false;
  RunOptions options;
  options.control.interrupted = options_.interrupted;
  const RunOutcome outcome = run_scenario(scenario, options);
  if (outcome.exit == ExitCode::interrupted) throw Interrupted{};
  if (!outcome.failure.empty() || outcome.results.size() != 1) return std::nullopt;
  return outcome.results.front();
}

std::optional<ExpectationResult> Shrink::judged(const std::vector<Perturbation>& perturbations, std::size_t segments) {
  if (options_.progress) options_.progress(outcome_.runs, kept_.size());
  const std::vector<SegmentTiming> timing = shape_.build(perturbations, segments);
  if (timing.empty()) return std::nullopt;
  const std::string trace = (scratch_.path / "timing.csv").string();
  write_text(trace, format_timing_csv(timing));
  Value document = document_;
  internal::set_timing(document, trace, duration_of(timing));
  return judged_document(document);
}

/// Cuts the run to the shortest one that still fails, found by bisection.
void Shrink::cut() {
  const auto shorter = [&](std::int64_t segments) { return fails(kept_, static_cast<std::size_t>(segments)); };
  segments_ = static_cast<std::size_t>(
      internal::smallest(0, static_cast<std::int64_t>(segments_), shorter, [&] { return go_on(); }));
  std::erase_if(kept_, [&](const Perturbation& p) { return p.segment >= segments_; });
}

/// Whether these perturbations of `all` fail. If they do, they are kept, which also shows as progress.
bool Shrink::fails_with(const std::vector<Perturbation>& all, const std::vector<std::size_t>& set) {
  std::vector<Perturbation> candidate;
  for (const std::size_t i : set) candidate.push_back(all[i]);
  const bool failed = fails(candidate, segments_);
  if (failed) kept_ = std::move(candidate);
  return failed;
}

/// Keeps a single perturbation that fails alone, or none; the largest are tried first, with up to half of the runs. This
/// comes before the run is cut, because the first failure may need more perturbations than a later one. False if no single
/// one fails.
bool Shrink::keep_one() {
  const std::vector<Perturbation> all = kept_;
  if (fails_with(all, {})) return true;
  std::vector<std::size_t> largest_first(all.size());
  std::iota(largest_first.begin(), largest_first.end(), std::size_t{0});
  std::stable_sort(largest_first.begin(), largest_first.end(),
                   [&](std::size_t a, std::size_t b) { return std::abs(all[a].deviation) > std::abs(all[b].deviation); });
  const std::int64_t most_runs = outcome_.runs + (options_.max_runs - outcome_.runs) / 2;
  for (const std::size_t i : largest_first) {
    if (outcome_.runs >= most_runs) break;
    if (fails_with(all, {i})) return true;
  }
  return false;
}

void Shrink::keep_fewest() {
  const std::vector<Perturbation> all = kept_;
  const auto fail_with = [&](const std::vector<std::size_t>& set) { return fails_with(all, set); };
  const std::vector<std::size_t> fewest = internal::fewest(all.size(), fail_with, [&] { return go_on(); });
  kept_.clear();
  for (const std::size_t i : fewest) kept_.push_back(all[i]);
}

void Shrink::keep_smallest() {
  for (std::size_t i = 0; i < kept_.size() && go_on(); ++i) {
    const auto fail_with = [&](std::int64_t deviation) {
      std::vector<Perturbation> candidate = kept_;
      candidate[i].deviation = deviation;
      return fails(candidate, segments_);
    };
    kept_[i].deviation = internal::smallest(0, kept_[i].deviation, fail_with, [&] { return go_on(); });
  }
}

/// The other files that the scenario names, as pairs of name and contents; in the document they get these names.
std::vector<std::pair<std::string, std::string>> Shrink::take_files(Value& document, const std::string& stem) const {
  std::vector<std::pair<std::string, std::string>> files;
  for (Value* file : internal::named_files(document)) {
    const std::string path = internal::path_from(*file);
    const Result<std::string> read = internal::read_text_file(path, INT64_MAX);
    if (!read) throw std::runtime_error(fmt::format("'{}' {}", path, read.error()));
    files.emplace_back(fmt::format("{}-{}{}", stem, files.size(), fs::path(path).extension().string()), *read);
    file->text = files.back().first;
  }
  return files;
}

void Shrink::write(const ExpectationResult& before) {
  const std::string stem = fs::path(path_).stem().string() + "-shrunk";
  Value document = document_;
  auto files = take_files(document, stem);
  const std::vector<SegmentTiming> timing = shape_.build(kept_, segments_);
  outcome_.duration = duration_of(timing);
  internal::set_timing(document, stem + ".csv", outcome_.duration);
  const std::string because =
      fmt::format("{} {} fails with the timing of {} (line {}) cut down to {} length{} that {} not nominal.", before.signal,
                  before.metric, fs::path(path_).filename().string(), before.line, kept_.size(),
                  kept_.size() == 1 ? "" : "s", kept_.size() == 1 ? "is" : "are");
  const Value* name = document.find("name");
  const std::string title =
      (name == nullptr || name->text.empty() ? fs::path(path_).stem().string() : name->text) + ", shrunk";
  for (const std::string_view key : {"name", "because", "tags"}) {
    std::erase_if(document.table, [&](const internal::Entry& entry) { return entry.key == key; });
  }
  document.table.push_back({"name", {}, internal::text_value(title, {})});
  document.table.push_back({"because", {}, internal::text_value(because, {})});
  std::string toml = fmt::format("# {}\n", because);
  for (const Perturbation& perturbation : kept_) toml += fmt::format("#   {}\n", text(perturbation));
  files.emplace_back(stem + ".csv", format_timing_csv(timing));
  files.emplace_back(stem + ".toml", toml + internal::print_toml(document));
  fs::create_directories(options_.folder);
  for (const auto& [file, content] : files) write_text((fs::path(options_.folder) / file).string(), content);
  outcome_.file = (fs::path(options_.folder) / (stem + ".toml")).string();

  const ReadResult read = read_scenario(outcome_.file, {{}, std::nullopt, options_.registry});
  if (!read) throw std::runtime_error(fmt::format("the written scenario does not read: {}", text(read.error().front())));
  RunOptions options;
  options.control.interrupted = options_.interrupted;
  const RunOutcome again = run_scenario(*read, options);
  if (again.exit == ExitCode::interrupted) throw Interrupted{};
  if (again.results.size() != 1 || again.results.front().verdict != ExpectationResult::Verdict::fail)
    throw std::runtime_error(fmt::format("{} was written, but its expectation does not fail", outcome_.file));
  outcome_.after = again.results.front();
}

/// A recovery from faults that the recording would not have.
bool is_about_timing_faults(const Scenario& scenario, const std::string& metric) {
  return metric.starts_with("recover") && std::any_of(scenario.faults.begin(), scenario.faults.end(),
                                                      [](const auto& fault) { return fault.name.starts_with("timing."); });
}

/// Which expectation to shrink for, or why there is none.
std::optional<std::size_t> failing(const Scenario& scenario, const RunOutcome& run, const ShrinkOptions& options,
                                   std::vector<Diagnostic>& errors) {
  const std::string stopped =
      run.failure.empty() ? "" : fmt::format("the run stopped ({}); only a failed expectation can be shrunk", run.failure);
  bool line_known = false;
  for (std::size_t i = 0; i < run.results.size() && stopped.empty(); ++i) {
    const ExpectationResult& result = run.results[i];
    if (options.expect_line && result.line != *options.expect_line) continue;
    line_known = true;
    if (result.verdict != ExpectationResult::Verdict::fail) continue;
    if (!is_about_timing_faults(scenario, result.metric)) return i;
    errors.push_back({scenario.file, result.line, 1,
                      "its faults are in [timing], and of a shrunk run the timing is a recording, in which no fault is "
                      "programmed; shrink another expectation, with --expect"});
    return std::nullopt;
  }
  const std::int64_t line = options.expect_line.value_or(0);
  errors.push_back({scenario.file, line, line > 0 ? 1 : 0,
                    !stopped.empty()                     ? stopped
                    : options.expect_line && !line_known ? "--expect: no expectation begins in this line"
                    : options.expect_line                ? "this expectation does not fail, so there is nothing to shrink"
                                                         : "no expectation fails, so there is nothing to shrink"});
  return std::nullopt;
}

/// A rate of underruns over many seeds is shrunk as that of the run's own seed, because a recording has no other. If that
/// seed alone is within the limit, this says so, and which seed to use instead.
std::optional<std::string> why_not_this_seed(const Scenario& scenario, const Expectation& expectation,
                                             const std::string& signal_name) {
  if (!expectation.confidence || expectation.expect_fail) return std::nullopt;
  const std::vector<internal::RateSignal> signals = internal::rate_signals(scenario);
  const auto signal = std::find_if(signals.begin(), signals.end(), [&](const auto& one) { return one.name == signal_name; });
  const std::vector<StrategyPlan> plans = plan(scenario);
  const auto with = std::find_if(plans.begin(), plans.end(), [&](const StrategyPlan& p) { return p.kind == signal->kind; });
  const std::int64_t seeds =
      internal::seeds_judged(scenario, expectation, signal->kind, internal::rate_basis(scenario, signal->kind));
  const double most = *in_base(*expectation.max, "1", 0, scenario.nominal);
  const auto rate = [](const internal::RateCount& count) {
    return static_cast<double>(count.hit) / static_cast<double>(std::max<std::int64_t>(count.segments, 1));
  };
  internal::RateCount own, worst;
  std::uint64_t worst_seed = 0;
  Scenario one = scenario;
  for (std::int64_t i = 0; i < seeds; ++i) {
    one.timing.programmed.seed = scenario.timing.programmed.seed + static_cast<std::uint64_t>(i);
    const internal::RateCount count = internal::count_underrun_segments(one, *signal, with->lead, with->latency, 1);
    if (i == 0) own = count;
    if (i > 0 && rate(count) <= rate(worst)) continue;
    worst = count;
    worst_seed = one.timing.programmed.seed;
  }
  if (rate(own) > most) return std::nullopt;
  if (rate(worst) <= most) {
    return fmt::format(
        "of {} seeds none underruns more often than {:.6g} allows: they are too few to be sure, and no timing is at fault; "
        "let "
        "more be run with 'seeds'",
        seeds, most);
  }
  return fmt::format(
      "it fails over {} seeds, of which a recording has one, and seed {} alone keeps the limit ({} of {} segments "
      "underrun); "
      "seed {} has most ({} of {}): add --seed {}",
      seeds, scenario.timing.programmed.seed, own.hit, own.segments, worst_seed, worst.hit, worst.segments, worst_seed);
}

}  // namespace

std::string text(const Perturbation& p) {
  const std::int64_t value = p.nominal + p.deviation;
  switch (p.kind) {
    case Perturbation::Kind::count:
      return fmt::format("segment {}: {} steps instead of {}", p.segment, value, p.nominal);
    case Perturbation::Kind::visualization:
      return fmt::format("visualization of segment {}: {} ns instead of {}", p.segment, value, p.nominal);
    case Perturbation::Kind::visualization_gap:
      return fmt::format("pause before the visualization of segment {}: {} ns instead of {}", p.segment, value, p.nominal);
    case Perturbation::Kind::step:
      return fmt::format("step {} of segment {}: {} ns instead of {}", p.step, p.segment, value, p.nominal);
    case Perturbation::Kind::step_gap:
      return fmt::format("pause before step {} of segment {}: {} ns instead of {}", p.step, p.segment, value, p.nominal);
    case Perturbation::Kind::dropped:
      return fmt::format("simulated time dropped before step {} of segment {}: {} steps", p.step, p.segment, value);
  }
  return "";
}

ShrinkOutcome shrink_scenario(const std::string& path, const ShrinkOptions& options) {
  ShrinkOutcome outcome;
  const auto refuse = [&](std::vector<Diagnostic> errors) {
    outcome.errors = std::move(errors);
    outcome.exit = ExitCode::usage;
    return outcome;
  };
  internal::Errors of_files;
  Value document = internal::load_with_overrides(path, {options.set, options.seed}, of_files);
  if (of_files.any()) return refuse(of_files.sorted(path));
  const ReadResult read = internal::read_document(document, path, options.registry);
  if (!read) return refuse(read.error());
  if (read->timing.elsewhere)
    return refuse(
        {{path, 0, 0, "the forces of a [source] are not only late by its timing, which is all that shrink takes apart"}});
  if (read->case_spec) return refuse({{path, 0, 0, "a [case] has no timing to shrink"}});
  RunOptions run_options;
  run_options.control.interrupted = options.interrupted;
  try {
    const RunOutcome run = run_scenario(*read, run_options);
    if (!run.errors.empty()) return refuse(run.errors);
    if (run.exit == ExitCode::interrupted) throw Interrupted{};
    const std::optional<std::size_t> expectation = failing(*read, run, options, outcome.errors);
    if (!expectation) return refuse(outcome.errors);
    outcome.before = run.results[*expectation];
    const std::optional<std::string> reason =
        why_not_this_seed(*read, read->expectations[*expectation], outcome.before.signal);
    if (reason) return refuse({{read->file, outcome.before.line, 1, *reason}});
    Shrink shrink(std::move(document), *read, *expectation, options, outcome);
    shrink.run();
    shrink.write(outcome.before);
  } catch (const Interrupted&) {
    outcome.exit = ExitCode::interrupted;
  } catch (const std::exception& error) {
    outcome.failure = error.what();
    outcome.exit = ExitCode::run_failed;
  }
  return outcome;
}

}  // namespace evenstep
