#include "evenstep/campaigns/catalogue_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "evenstep/reports/writers.h"
#include "evenstep/time/digest.h"
#include "json_parts.h"

namespace evenstep {
namespace {

using internal::exact;
using internal::read_exact;
using internal::refuse_line;

constexpr ExitCode kExits[] = {ExitCode::pass, ExitCode::expectation_failed, ExitCode::usage, ExitCode::run_failed,
                               ExitCode::not_reproducible};
constexpr CellStatus kStatuses[] = {CellStatus::ok,      CellStatus::damped,   CellStatus::drifting,
                                    CellStatus::refused, CellStatus::diverged, CellStatus::unavailable};

/// A scenario, and where its items are among all.
struct Entry {
  Scenario scenario;
  std::string digest;
  std::int64_t first = 0, items = 1;
};

Json json_of(const CaseCell& cell) {
  Json out = {{"value", exact(cell.value)}, {"status", name_of(cell.status)}};
  if (cell.shown) out["shown"] = exact(*cell.shown);
  if (!cell.detail.empty()) out["detail"] = cell.detail;
  out["steps"] = cell.steps;
  out["digest"] = fmt::format("{:016x}", cell.digest);
  out["schedule_differs"] = cell.schedule_differs;
  out["metrics"] = Json::object();
  for (const auto& [name, value] : cell.metrics) out["metrics"][name] = exact(value);
  return out;
}

std::uint64_t read_hash(const Json& json) {
  const auto text = json.get<std::string>();
  std::uint64_t hash = 0;
  const auto [at, error] = std::from_chars(text.data(), text.data() + text.size(), hash, 16);
  if (error != std::errc{} || at != text.data() + text.size()) refuse_line("has no digest");
  return hash;
}

CaseCell case_cell_of(const Json& json) {
  CaseCell cell;
  cell.value = read_exact(json.at("value"));
  const auto* const status = std::find_if(std::begin(kStatuses), std::end(kStatuses), [&](CellStatus one) {
    return json.at("status").get<std::string>() == name_of(one);
  });
  if (status == std::end(kStatuses)) refuse_line("has an unknown status");
  cell.status = *status;
  if (json.contains("shown")) cell.shown = read_exact(json.at("shown"));
  if (json.contains("detail")) cell.detail = json.at("detail").get<std::string>();
  cell.steps = json.at("steps").get<std::int64_t>();
  cell.digest = read_hash(json.at("digest"));
  cell.schedule_differs = json.at("schedule_differs").get<bool>();
  for (const auto& [name, value] : json.at("metrics").items()) cell.metrics[name] = read_exact(value);
  return cell;
}

/// What is known of a run without a [case].
Json json_of(const RunOutcome& outcome) {
  Json out = {{"exit", static_cast<int>(outcome.exit)}, {"trace", fmt::format("{:016x}", outcome.record.trace_hash)}};
  std::string failure = outcome.failure;
  for (const ExpectationResult& result : outcome.results) {
    if (result.verdict != ExpectationResult::Verdict::pass && failure.empty()) failure = failure_message(result);
  }
  if (!failure.empty()) out["failure"] = failure;
  return out;
}

RunOutcome outcome_of(const Json& json, const Scenario& scenario) {
  RunOutcome outcome;
  const int code = json.at("exit").get<int>();
  const auto* const exit =
      std::find_if(std::begin(kExits), std::end(kExits), [&](ExitCode one) { return static_cast<int>(one) == code; });
  if (exit == std::end(kExits)) refuse_line("has an unknown exit code");
  outcome.exit = *exit;
  outcome.verdict = outcome.exit == ExitCode::pass                 ? RunVerdict::pass
                    : outcome.exit == ExitCode::expectation_failed ? RunVerdict::fail
                                                                   : RunVerdict::error;
  outcome.record.scenario = scenario.name;
  outcome.record.file = scenario.file;
  outcome.record.trace_hash = read_hash(json.at("trace"));
  if (json.contains("failure")) outcome.failure = json.at("failure").get<std::string>();
  return outcome;
}

class Catalogue {
 public:
  Catalogue(const CatalogueOptions& options, CatalogueOutcome& outcome) : options_(options) {
    for (const std::string& file : options.files) add(file, outcome);
    if (entries_.empty() && outcome.errors.empty())
      outcome.errors.push_back({"catalogue", 0, 0, "every scenario is left out, they carry the tag \"long\"; add --long"});
  }

  std::int64_t items() const { return items_; }
  const std::vector<Entry>& entries() const { return entries_; }

  internal::CampaignId id() const {
    internal::CampaignId id{"catalogue", fmt::format("{} scenarios", entries_.size()), options_.files.front(), options_.set,
                            ""};
    std::uint64_t digest = 0;
    for (const Entry& entry : entries_) digest = mix(digest, name_digest(entry.digest));
    id.scenario = fmt::format("{:016x}", digest);
    id.own = {{"files", options_.files}, {"long", options_.long_ones}};
    return id;
  }
  Json names() const {
    Json out = Json::array();
    for (const Entry& entry : entries_) out.push_back({entry.scenario.name, entry.items});
    return {{"scenarios", out}};
  }

  /// Empty: interrupted.
  std::string run(std::int64_t item) const {
    const Entry& entry = of(item);
    if (entry.scenario.case_spec) {
      const CaseCell cell = run_case_cell(entry.scenario, item - entry.first, options_.interrupted);
      if (cell.status == CellStatus::interrupted) return {};
      return internal::item_line(item, {{"scenario", entry.scenario.name}, {"cell", json_of(cell)}});
    }
    RunOptions options;
    options.threads = 1;  // the items already keep all cores busy
    options.control.interrupted = options_.interrupted;
    RunOutcome outcome = run_scenario(entry.scenario, options);
    if (outcome.exit == ExitCode::interrupted) return {};
    // A part that this evenstep is built without; every other fault was found when the scenarios were read.
    if (!outcome.errors.empty()) outcome.failure = text(outcome.errors.front());
    Json line = {{"scenario", entry.scenario.name}, {"run", json_of(outcome)}};
    if (outcome.exit != ExitCode::pass) line["failed"] = true;
    return internal::item_line(item, line);
  }

  /// Takes the next item in.
  void take(const Json& json) {
    const auto item = json.at("index").get<std::int64_t>();
    const Entry& entry = of(item);
    if (!entry.scenario.case_spec) {
      outcome_of(json.at("run"), entry.scenario);
      runs_.push_back(json.at("run"));
      return;
    }
    cells_.push_back(case_cell_of(json.at("cell")));
    const std::vector<double>& values = entry.scenario.case_spec->values;
    if (cells_.back().value != values[static_cast<std::size_t>(item - entry.first) % values.size()])
      refuse_line("has another value than its cell");
  }

  /// Calls `judged` for each scenario. All their items must have been taken in.
  ExitCode judge(const std::function<void(CatalogueEntry&)>& judged) const {
    ExitCode worst = ExitCode::pass;
    auto cell = cells_.begin();
    auto whole = runs_.begin();
    for (const Entry& entry : entries_) {
      CatalogueEntry out{&entry.scenario, {}};
      if (entry.scenario.case_spec) {
        const std::vector<CaseCell> own(cell, cell + entry.items);
        cell += entry.items;
        RunOptions options;
        options.cells = &own;
        out.outcome = run_scenario(entry.scenario, options);
      } else {
        out.outcome = outcome_of(*whole++, entry.scenario);
      }
      judged(out);
      worst = worse(worst, out.outcome.exit);
    }
    return worst;
  }

 private:
  void add(const std::string& file, CatalogueOutcome& outcome) {
    const ReadOptions read_options{options_.set, std::nullopt, options_.registry};
    ReadResult read = read_scenario(file, read_options);
    const std::vector<Diagnostic> errors = read ? check_expectations(*read) : read.error();
    outcome.errors.insert(outcome.errors.end(), errors.begin(), errors.end());
    if (!errors.empty()) return;
    const bool is_long = std::find(read->tags.begin(), read->tags.end(), "long") != read->tags.end();
    if (is_long && !options_.long_ones) {
      ++outcome.left_out;
      return;
    }
    Entry entry{*std::move(read), internal::scenario_digest(file, read_options, outcome.errors), items_, 1};
    if (entry.scenario.case_spec) entry.items = case_cells(entry.scenario);
    items_ += entry.items;
    entries_.push_back(std::move(entry));
  }

  const Entry& of(std::int64_t item) const {
    const auto after = std::upper_bound(entries_.begin(), entries_.end(), item,
                                        [](std::int64_t i, const Entry& entry) { return i < entry.first; });
    return *std::prev(after);
  }

  const CatalogueOptions& options_;
  std::vector<Entry> entries_;
  std::int64_t items_ = 0;
  std::vector<CaseCell> cells_;
  std::vector<Json> runs_;
};

}  // namespace

CatalogueOutcome run_catalogue(const CatalogueOptions& options, const std::function<void(CatalogueEntry&)>& judged) {
  CatalogueOutcome outcome;
  Catalogue catalogue(options, outcome);
  if (!outcome.errors.empty()) {
    outcome.exit = ExitCode::usage;
    return outcome;
  }
  internal::JsonParts parts(catalogue.id(), catalogue.items(), catalogue.names(),
                            [&](const Json& json) { catalogue.take(json); });
  internal::run_part(
      parts, [&](std::int64_t item) { return catalogue.run(item); }, "catalogue", options, outcome);
  if (outcome.exit == ExitCode::pass && options.shard.of == 1) outcome.exit = catalogue.judge(judged);
  return outcome;
}

}  // namespace evenstep
