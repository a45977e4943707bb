#include "notes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "evenstep/reports/limit_text.h"
#include "evenstep/reports/plain_text.h"

namespace evenstep::internal {
namespace {

constexpr std::size_t kMostLines = 6;  // of the scenarios' differences

using Key = std::pair<std::string, std::string>;  ///< signal and metric

/// The signal as written. The summary of an older evenstep has only the one that was judged; the other run then tells by the
/// expectation in the same place.
const std::string& written_signal(const ExpectationResult& result, const RunSummary& other) {
  if (!result.pattern.empty()) return result.pattern;
  const auto same = std::find_if(other.expectations.begin(), other.expectations.end(), [&](const ExpectationResult& one) {
    return !one.pattern.empty() && one.line == result.line && one.file == result.file && one.metric == result.metric;
  });
  return same == other.expectations.end() ? result.signal : same->pattern;
}

/// The expectations of a run on each signal and metric, in the order of the file.
std::map<Key, std::vector<std::size_t>> by_metric(const RunSummary& run, const RunSummary& other) {
  std::map<Key, std::vector<std::size_t>> found;
  for (std::size_t i = 0; i < run.expectations.size(); ++i)
    found[{written_signal(run.expectations[i], other), run.expectations[i].metric}].push_back(i);
  return found;
}

std::string name_of(const ExpectationResult& result) { return result.metric + ' ' + limit_text(result); }

/// Two expectations on one metric: which of A is which of B. First those with the same limits, then in order.
std::vector<std::pair<std::size_t, std::size_t>> pairs_of(const RunSummary& a, std::vector<std::size_t> in_a,
                                                          const RunSummary& b, std::vector<std::size_t> in_b) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  const auto pair_up = [&](auto alike) {
    for (auto one = in_a.begin(); one != in_a.end();) {
      const auto other = std::find_if(in_b.begin(), in_b.end(), [&](std::size_t i) { return alike(*one, i); });
      if (other == in_b.end()) {
        ++one;
        continue;
      }
      pairs.emplace_back(*one, *other);
      in_b.erase(other);
      one = in_a.erase(one);
    }
  };
  pair_up([&](std::size_t i, std::size_t j) { return name_of(a.expectations[i]) == name_of(b.expectations[j]); });
  pair_up([](std::size_t, std::size_t) { return true; });
  return pairs;
}

std::vector<std::pair<std::size_t, std::size_t>> pairs_of(const RunSummary& a, const RunSummary& b) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  const auto in_b = by_metric(b, a);
  for (const auto& [key, mine] : by_metric(a, b)) {
    const auto theirs = in_b.find(key);
    if (theirs == in_b.end()) continue;
    for (const auto& pair : pairs_of(a, mine, b, theirs->second)) pairs.push_back(pair);
  }
  return pairs;
}

/// The names, with a number behind those that another expectation on the signal has, too.
ExpectationNames numbered_names(const RunSummary& run, const RunSummary& other) {
  ExpectationNames out;
  std::map<Key, int> seen;
  for (const ExpectationResult& result : run.expectations) {
    const std::string &signal = written_signal(result, other), name = name_of(result);
    const int before = seen[{signal, name}]++;
    out.push_back({signal, before == 0 ? name : fmt::format("{} ({})", name, before + 1)});
  }
  return out;
}

/// "scene.stiffness = '200 N/m'" for each line of resolved.toml, each with its table's name.
std::set<std::string> settings_of(const std::vector<std::string>& lines) {
  std::set<std::string> settings;
  std::map<std::string, int> tables;
  std::string table;
  bool counts = true;
  for (const std::string& raw : lines) {
    const std::size_t first = raw.find_first_not_of(' ');
    if (first == std::string::npos) continue;
    const std::string line = raw.substr(first);
    if (line.front() == '[') {
      table = line.substr(line.find_first_not_of('['));
      table = table.substr(0, table.find(']'));
      const int number = line.starts_with("[[") ? ++tables[table] : 0;
      // Expectations are compared by themselves; a sweep and a study are not in a run.
      counts = !table.starts_with("expect") && !table.starts_with("sweep") && !table.starts_with("study");
      if (number > 1) table += fmt::format("#{}", number);
    } else if (counts && !table.empty() && !(table == "run" && line.starts_with("seed "))) {
      settings.insert(table + '.' + line);
    }
  }
  return settings;
}

void add_scenario_notes(const RunSummary& a, const RunSummary& b, std::vector<std::string>& notes) {
  if (a.scenario != b.scenario)
    notes.push_back(fmt::format("another scenario: A is '{}', B is '{}'", plain_text(a.scenario), plain_text(b.scenario)));
  if (a.digest.empty() || b.digest.empty()) {
    const bool in_a = a.digest.empty();
    notes.push_back(
        fmt::format("nobody can say whether the scenario is the same: the summary of {} (evenstep {}) has no "
                    "scenario_digest",
                    in_a ? "A" : "B", plain_text(in_a ? a.evenstep : b.evenstep)));
    return;
  }
  if (a.digest == b.digest) return;
  const std::set<std::string> before = settings_of(a.resolved), after = settings_of(b.resolved);
  if (before.empty() || after.empty()) {
    if (a.seed == b.seed) notes.emplace_back("the scenarios differ; a resolved.toml beside each summary would say in what");
    return;
  }
  std::vector<std::string> lines;
  for (const std::string& line : before) {
    if (!after.contains(line)) lines.push_back("A has " + plain_text(line));
  }
  for (const std::string& line : after) {
    if (!before.contains(line)) lines.push_back("B has " + plain_text(line));
  }
  if (lines.empty()) return;
  const std::size_t shown = std::min(lines.size(), kMostLines);
  for (std::size_t i = 0; i < shown; ++i) notes.push_back("the scenarios differ: " + lines[i]);
  if (shown < lines.size())
    notes.push_back(fmt::format("the scenarios differ in {} more lines of resolved.toml", lines.size() - shown));
}

void add_strategy_notes(const RunSummary& a, const RunSummary& b, std::vector<std::string>& notes) {
  for (const auto& [name, one] : a.strategies) {
    const auto found = b.strategies.find(name);
    if (found == b.strategies.end()) {
      notes.push_back(fmt::format("strategy '{}' is only in A", plain_text(name)));
      continue;
    }
    const RunSummary::Strategy& other = found->second;
    const auto differs = [&, &strategy = name](const char* what, const std::string& in_a, const std::string& in_b) {
      if (in_a != in_b)
        notes.push_back(fmt::format("strategy '{}' has another {}: A '{}', B '{}'", plain_text(strategy), what,
                                    plain_text(in_a), plain_text(in_b)));
    };
    differs("solver", one.solver, other.solver);
    differs("solver device", one.solver_device, other.solver_device);
    differs("method", one.method, other.method);
    differs("list of what its solver lacks", fmt::format("{}", fmt::join(one.lacks, ", ")),
            fmt::format("{}", fmt::join(other.lacks, ", ")));
  }
  for (const auto& [name, other] : b.strategies) {
    if (!a.strategies.contains(name)) notes.push_back(fmt::format("strategy '{}' is only in B", plain_text(name)));
  }
}

}  // namespace

const char* verdict_word(ExpectationResult::Verdict verdict) {
  constexpr std::array kWords{"skipped", "pass", "degraded", "fail", "error"};
  return kWords.at(static_cast<std::size_t>(verdict));
}

std::pair<ExpectationNames, ExpectationNames> expectation_names(const RunSummary& a, const RunSummary& b) {
  ExpectationNames of_a = numbered_names(a, b), of_b = numbered_names(b, a);
  for (const auto& [i, j] : pairs_of(a, b)) of_a[i] = of_b[j];
  return {of_a, of_b};
}

std::vector<std::string> notes_on(const RunSummary& a, const RunSummary& b) {
  std::vector<std::string> notes;
  add_scenario_notes(a, b, notes);
  if (a.seed != b.seed) notes.push_back(fmt::format("another seed: A {}, B {}", a.seed, b.seed));
  if (a.clock != b.clock)
    notes.push_back(fmt::format("another clock: A '{}', B '{}'", plain_text(a.clock), plain_text(b.clock)));
  if (a.clock == "wall" && b.clock == "wall") notes.emplace_back("on the wall clock: its figures are others in every run");
  if (a.real_time_granted != b.real_time_granted)
    notes.push_back(fmt::format("real-time priority was granted in {} only", a.real_time_granted ? "A" : "B"));
  add_strategy_notes(a, b, notes);
  if (a.left_out != b.left_out)
    notes.push_back(
        fmt::format("another list of features that were left out: A {}, B {}", a.left_out.size(), b.left_out.size()));
  for (const auto& [i, j] : pairs_of(a, b)) {
    const ExpectationResult &one = a.expectations[i], &other = b.expectations[j];
    if (name_of(one) != name_of(other))
      notes.push_back(fmt::format("another limit on {}: A {}, B {}", plain_text(written_signal(one, b)),
                                  plain_text(name_of(one)), plain_text(name_of(other))));
  }
  if (!a.failure.empty()) notes.push_back("A stopped: " + plain_text(a.failure));
  if (!b.failure.empty()) notes.push_back("B stopped: " + plain_text(b.failure));
  return notes;
}

}  // namespace evenstep::internal
