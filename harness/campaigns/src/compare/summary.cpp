#include "evenstep/campaigns/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "evenstep/harness/run_folder.h"
#include "evenstep/reports/plain_text.h"
#include "evenstep/text/text_file.h"

namespace evenstep {
namespace fs = std::filesystem;
namespace {

// Members by name, not in order: an ordered object would compare each of a million hostile names with all before it.
using Tree = nlohmann::json;

/// What is wrong with a tree, and where in it.
struct WrongSummary : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A value and its place in the file: "/expectations/3/value".
struct At {
  const Tree& tree;
  std::string place;

  [[noreturn]] void refuse(const std::string& expected) const {
    throw WrongSummary(fmt::format("{} must be {}; is this a summary.json that evenstep wrote?",
                                   place.empty() ? "the file" : plain_text(place), expected));
  }
  At operator[](const char* key) const {
    const auto found = tree.is_object() ? tree.find(key) : tree.end();
    if (found == tree.end()) refuse(fmt::format("an object with \"{}\"", key));
    return {*found, fmt::format("{}/{}", place, key)};
  }
  bool has(const char* key) const {
    const auto found = tree.find(key);
    return found != tree.end() && !found->is_null();
  }
  std::string word() const {
    if (!tree.is_string()) refuse("a string");
    return tree.get<std::string>();
  }
  /// Empty if it is null or not there.
  std::string word_or_nothing(const char* key) const { return has(key) ? (*this)[key].word() : std::string(); }
  bool truth() const {
    if (!tree.is_boolean()) refuse("true or false");
    return tree.get<bool>();
  }
  std::optional<double> number() const {
    if (tree.is_null()) return std::nullopt;
    if (!tree.is_number()) refuse("a number or null");
    return tree.get<double>();
  }
  std::int64_t whole() const {
    if (!tree.is_number_integer()) refuse("a whole number");
    return tree.get<std::int64_t>();
  }
  std::uint64_t seed() const {
    if (!tree.is_number_unsigned()) refuse("a whole number from 0 to 2^64 - 1");
    return tree.get<std::uint64_t>();
  }
  std::vector<At> list() const {
    if (!tree.is_array()) refuse("a list");
    std::vector<At> all;
    for (std::size_t i = 0; i < tree.size(); ++i) all.push_back({tree[i], fmt::format("{}/{}", place, i)});
    return all;
  }
  std::vector<std::pair<std::string, At>> members() const {
    if (!tree.is_object()) refuse("an object");
    std::vector<std::pair<std::string, At>> all;
    for (const auto& [key, value] : tree.items()) all.push_back({key, At{value, fmt::format("{}/{}", place, key)}});
    return all;
  }
  std::vector<std::string> words() const {
    std::vector<std::string> all;
    for (const At& one : list()) all.push_back(one.word());
    return all;
  }
};

ExpectationResult::Verdict verdict_at(const At& at) {
  using Verdict = ExpectationResult::Verdict;
  constexpr std::array kNames = std::to_array<std::pair<std::string_view, Verdict>>({{"skipped", Verdict::skipped},
                                                                                     {"pass", Verdict::pass},
                                                                                     {"degraded", Verdict::degraded},
                                                                                     {"fail", Verdict::fail},
                                                                                     {"error", Verdict::error}});
  const std::string word = at.word();
  for (const auto& [name, verdict] : kNames) {
    if (word == name) return verdict;
  }
  at.refuse("\"pass\", \"fail\", \"error\", \"degraded\" or \"skipped\"");
}

std::string run_verdict_at(const At& at) {
  const std::string word = at.word();
  for (const char* const known : {"pass", "none", "degraded", "fail", "error"}) {
    if (word == known) return word;
  }
  at.refuse("\"pass\", \"none\", \"degraded\", \"fail\" or \"error\"");
}

ExpectationResult expectation_at(const At& at) {
  ExpectationResult result;
  result.signal = at["signal"].word();
  result.pattern = at.word_or_nothing("pattern");
  result.file = at["file"].word();
  result.line = at["line"].whole();
  result.metric = at["metric"].word();
  result.unit = at["unit"].word();
  result.value = at["value"].number();
  result.min = at["min"].number();
  result.max = at["max"].number();
  result.expect_fail = at["expect_fail"].truth();
  result.verdict = verdict_at(at["verdict"]);
  return result;
}

RunSummary summary_at(const At& at) {
  const At format = at["format"];
  if (format.whole() != 1) {
    throw WrongSummary(
        fmt::format("is of format {}, and this evenstep reads format 1; compare with the evenstep that wrote it, or run "
                    "again with this one",
                    format.tree.dump()));
  }
  RunSummary run;
  run.evenstep = at["evenstep"].word();
  run.scenario = at["scenario"].word();
  run.name = run.file = at["file"].word();
  run.digest = at.word_or_nothing("scenario_digest");
  run.date = at.word_or_nothing("date");
  run.commit = at.word_or_nothing("commit");
  run.seed = at["seed"].seed();
  run.clock = at["clock"].word();
  run.real_time_granted = at["real_time_granted"].truth();
  run.verdict = run_verdict_at(at["verdict"]);
  run.trace_hash = at["trace_hash"].word();
  run.failure = at["failure"].word();
  run.left_out = at["left_out"].words();
  for (const At& one : at["expectations"].list()) run.expectations.push_back(expectation_at(one));
  for (const auto& [signal, metrics] : at["metrics"].members()) {
    for (const auto& [metric, value] : metrics.members()) run.metrics[signal][metric] = value.number();
  }
  for (const auto& [name, strategy] : at["strategies"].members()) {
    RunSummary::Strategy& one = run.strategies[name];
    one = {strategy["solver"].word(), strategy["solver_device"].word(), strategy["method"].word(), {}};
    if (strategy.has("solver_lacks")) one.lacks = strategy["solver_lacks"].words();
  }
  return run;
}

/// Line and column of a byte, counted from 1.
Place place_of(const std::string& text, const std::string& name, std::size_t byte) {
  const std::string_view before = std::string_view(text).substr(0, std::min(byte > 0 ? byte - 1 : 0, text.size()));
  const std::size_t line_begin = before.rfind('\n') + 1;  // npos + 1 is 0
  return {name, std::count(before.begin(), before.end(), '\n') + 1,
          static_cast<std::int64_t>(before.size() - line_begin) + 1};
}

/// Digits and words, without the library's own name and place.
std::string syntax_error_of(const std::string& what) {
  const std::size_t colon = what.find(": ");
  return "is not JSON: " + plain_text(colon == std::string::npos ? what : what.substr(colon + 2));
}

/// The run folders below a folder, in order.
std::vector<fs::path> run_folders_below(const fs::path& folder, std::vector<Diagnostic>& errors) {
  std::vector<fs::path> found;
  std::error_code error;
  fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied, error);
  for (; !error && at != fs::recursive_directory_iterator(); at.increment(error)) {
    std::error_code ignored;
    if (at->path().filename().native().starts_with('.')) {
      at.disable_recursion_pending();
    } else if (at->path().filename() == kSummaryFile && at->is_regular_file(ignored)) {
      found.push_back(at->path().parent_path());
    }
    if (found.size() > kMostSummaries) {
      errors.push_back(
          {folder.string(), 0, 0, fmt::format("has more than {} runs; name a folder below it", kMostSummaries)});
      return {};
    }
  }
  if (error) errors.push_back({folder.string(), 0, 0, fmt::format("cannot be searched: {}", error.message())});
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<std::string> lines_of(const fs::path& file) {
  std::vector<std::string> lines;
  internal::TextPieces pieces(file.string(), kMostSummaryBytes);
  for (std::string_view piece = pieces.next(); !piece.empty(); piece = pieces.next()) {
    while (!piece.empty()) {
      const std::size_t end = std::min(piece.find('\n'), piece.size());
      lines.emplace_back(piece.substr(0, end));
      piece.remove_prefix(std::min(end + 1, piece.size()));
    }
  }
  return lines;
}

void add_file(const fs::path& file, SummariesRead& read) {
  const Result<std::string> text = internal::read_text_file(file.string(), kMostSummaryBytes);
  if (!text) {
    read.errors.push_back({file.string(), 0, 0, text.error()});
    return;
  }
  auto runs = parse_summaries(*text, file.string());
  if (!runs) {
    read.errors.insert(read.errors.end(), runs.error().begin(), runs.error().end());
    return;
  }
  for (RunSummary& run : *runs) {
    run.file_read = file.string();
    if (file.filename() == kSummaryFile) run.resolved = lines_of(file.parent_path() / "resolved.toml");
    read.runs.push_back(std::move(run));
  }
}

}  // namespace

Result<std::vector<RunSummary>, std::vector<Diagnostic>> parse_summaries(const std::string& text, const std::string& name) {
  std::vector<Diagnostic> errors;
  const auto limit = [](int depth, Tree::parse_event_t, const Tree&) {
    if (depth > kMostSummaryDepth)
      throw WrongSummary(
          fmt::format("is deeper than {} levels; is this a summary.json that evenstep wrote?", kMostSummaryDepth));
    return true;
  };
  std::vector<RunSummary> runs;
  try {
    const Tree tree = Tree::parse(text, limit);
    const At whole{tree, ""};
    if (!tree.is_array()) return std::vector{summary_at(whole)};
    for (const At& one : whole.list()) runs.push_back(summary_at(one));
    if (runs.empty()) throw WrongSummary("has no runs");
  } catch (const Tree::parse_error& error) {
    const Place place = place_of(text, name, error.byte);
    errors.push_back({name, place.line, place.column, syntax_error_of(error.what())});
  } catch (const Tree::exception& error) {
    errors.push_back({name, 0, 0, syntax_error_of(error.what())});
  } catch (const WrongSummary& wrong) {
    errors.push_back({name, 0, 0, wrong.what()});
  }
  if (!errors.empty()) return Failure(errors);
  return runs;
}

SummariesRead read_summaries(const std::string& path) {
  SummariesRead read;
  std::error_code error;
  if (!fs::is_directory(path, error)) {
    add_file(path, read);
    return read;
  }
  const fs::path folder(path);
  if (fs::is_regular_file(folder / kSummaryFile, error)) {
    add_file(folder / kSummaryFile, read);
    return read;
  }
  for (const fs::path& run : run_folders_below(folder, read.errors)) {
    const std::size_t before = read.runs.size();
    add_file(run / kSummaryFile, read);
    if (read.runs.size() > before) read.runs.back().name = run.lexically_relative(folder).generic_string();
  }
  if (read.runs.empty() && read.errors.empty())
    read.errors.push_back({path, 0, 0, fmt::format("has no run ({}) in it; `evenstep run --out` writes one", kSummaryFile)});
  return read;
}

std::optional<double> relative_margin(const ExpectationResult& result) {
  if (!result.value || result.expect_fail || (result.min && result.max && *result.min == *result.max)) return std::nullopt;
  std::optional<double> least;
  const auto add = [&](const std::optional<double>& limit, double sign) {
    if (!limit || *limit == 0) return;
    const double margin = sign * (*limit - *result.value) / std::abs(*limit);
    if (!least || margin < *least) least = margin;
  };
  add(result.max, 1);
  add(result.min, -1);
  return least;
}

}  // namespace evenstep
