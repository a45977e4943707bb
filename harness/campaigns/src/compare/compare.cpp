#include "evenstep/campaigns/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "notes.h"

namespace evenstep {
namespace {

using Change = ComparedFigure::Change;

/// One figure on one side. Without a number, the word says what is there instead.
struct Figure {
  std::optional<double> number;
  std::string word;
};
/// Signal, metric, expectation.
using FigureKey = std::tuple<std::string, std::string, std::string>;
using Figures = std::map<FigureKey, Figure>;

const char* const kNoNumber = "no number";
const char* const kAbsent = "absent";

Figures figures_of(const RunSummary& run, const internal::ExpectationNames& names) {
  Figures figures;
  figures[{"run", "verdict", ""}] = {{}, run.verdict};
  figures[{"run", "trace", ""}] = {{}, run.trace_hash};
  for (const auto& [signal, metrics] : run.metrics) {
    for (const auto& [metric, value] : metrics) figures[{signal, metric, ""}] = {value, kNoNumber};
  }
  for (std::size_t i = 0; i < run.expectations.size(); ++i) {
    const ExpectationResult& result = run.expectations[i];
    const auto& [signal, name] = names[i];
    figures[{signal, "verdict", name}] = {{}, internal::verdict_word(result.verdict)};
    if (const std::optional<double> margin = relative_margin(result))
      figures[{signal, "margin", name}] = {margin, kNoNumber};
  }
  return figures;
}

/// The largest size of a number by signal and unit, on both sides.
using Sizes = std::map<std::pair<std::string, std::string>, double>;

/// Below this share of the largest number that a signal has in a unit, a number is rounding: a double has 2.2e-16, and a run
/// adds up thousands of them.
constexpr double kRounding = 1e-12;

void add_sizes(const Figures& figures, Sizes& sizes) {
  for (const auto& [key, figure] : figures) {
    const auto& [signal, metric, of] = key;
    if (!figure.number || metric == "margin") continue;
    double& size = sizes[{signal, figure_unit(signal, metric)}];
    size = std::max(size, std::abs(*figure.number));
  }
}

bool is_rounding(const ComparedFigure& figure, const Sizes& sizes) {
  const auto size = sizes.find({figure.signal, figure.unit});
  if (!figure.has_numbers() || figure.metric == "margin" || figure.unit == "count" || size == sizes.end()) return false;
  return std::max(std::abs(*figure.a), std::abs(*figure.b)) < kRounding * size->second;
}

/// From good to bad; 0 for a word that is no verdict.
int badness(const std::string& verdict) {
  constexpr const char* kOrder[] = {"pass", "skipped", "none", "degraded", "fail", "error"};
  const auto found = std::find(std::begin(kOrder), std::end(kOrder), verdict);
  return found == std::end(kOrder) ? 0 : static_cast<int>(found - std::begin(kOrder)) + 1;
}

/// What happened to one figure. `a` or `b` may be missing, not both.
ComparedFigure compared(std::size_t run, const FigureKey& key, const Figure* a, const Figure* b, const Sizes& sizes) {
  ComparedFigure figure;
  figure.run = run;
  std::tie(figure.signal, figure.metric, figure.of) = key;
  figure.unit = figure_unit(figure.signal, figure.metric);
  figure.a = a ? a->number : std::optional<double>();
  figure.b = b ? b->number : std::optional<double>();
  if (!figure.a) figure.a_word = a ? a->word : kAbsent;
  if (!figure.b) figure.b_word = b ? b->word : kAbsent;
  figure.rounding = is_rounding(figure, sizes);
  figure.minor =
      figure.rounding || figure.metric == "margin" || figure.metric == "trace" || is_timed(figure.signal, figure.metric);

  if (!a) {
    figure.change = Change::other;  // new in B: there is nothing that it could be worse than
  } else if (!b) {
    figure.change = Change::incomparable;
  } else if (figure.metric == "trace") {
    figure.change = Change::other;
  } else if (figure.metric == "verdict") {
    figure.change = badness(b->word) > badness(a->word) ? Change::worse : Change::better;
  } else if (!figure.has_numbers()) {
    figure.change = Change::incomparable;
  } else if (!figure.minor || figure.metric == "margin") {
    const Better better = figure.metric == "margin" ? Better::more : better_of(figure.signal, figure.metric);
    const bool grew = figure.difference() > 0;
    if (better != Better::neither) figure.change = grew == (better == Better::more) ? Change::better : Change::worse;
  }
  return figure;
}

/// Whether the figure, which differs or cannot be compared, breaks the threshold that covers it.
bool is_broken(const Threshold& threshold, const ComparedFigure& figure, const Figure* a, const Figure* b) {
  switch (threshold.kind) {
    case Threshold::Kind::trace:
      return true;
    case Threshold::Kind::missing:
      return a && !b;
    case Threshold::Kind::verdict:
      return figure.change == Change::worse || figure.change == Change::incomparable;
    case Threshold::Kind::worse:
      if (a && a->number && (!b || !b->number)) return true;  // what was known is not known any more
      break;
    case Threshold::Kind::change:
      if (a && !figure.has_numbers()) return true;  // nobody can say that it did not change too much
      break;
  }
  if (!figure.has_numbers() || figure.rounding) return false;
  return threshold.exceeded(figure.signal, figure.metric, *figure.a, *figure.b,
                            better_of(figure.signal, figure.metric) == Better::more);
}

class Comparison {
 public:
  Comparison(const std::vector<Threshold>& thresholds, bool allow_missing)
      : thresholds_(thresholds), allow_missing_(allow_missing) {
    for (const Threshold& threshold : thresholds) record_.conditions.push_back({threshold.text});
  }

  void add_pair(const RunSummary& a, const RunSummary& b) {
    ComparedRun& run = record_.runs.emplace_back();
    run.name = b.name;
    run.scenario = b.scenario;
    const auto [names_a, names_b] = internal::expectation_names(a, b);
    run.notes = internal::notes_on(a, b);
    const Figures before = figures_of(a, names_a), after = figures_of(b, names_b);
    sizes_.clear();
    add_sizes(before, sizes_);
    add_sizes(after, sizes_);
    std::set<FigureKey> keys;
    for (const auto& [key, figure] : before) keys.insert(key);
    for (const auto& [key, figure] : after) keys.insert(key);
    bool same = true;
    std::size_t without_number = 0;
    for (const FigureKey& key : keys) {
      const auto in_a = before.find(key), in_b = after.find(key);
      const Figure* const one = in_a == before.end() ? nullptr : &in_a->second;
      const Figure* const other = in_b == after.end() ? nullptr : &in_b->second;
      const bool equal = add_figure(key, one, other);
      if (one && other && !one->number && !other->number && one->word == kNoNumber) ++without_number;
      same = same && (equal || is_timed(std::get<0>(key), std::get<1>(key)));
    }
    if (same && a.digest == b.digest && a.seed == b.seed) run.trace_hash = a.trace_hash;
    if (without_number > 0)
      run.notes.push_back(
          fmt::format("{} figures have no number on either side, so nobody can compare them", without_number));
  }

  void add_single(const RunSummary& run, ComparedRun::In in) {
    record_.runs.push_back({run.name, run.scenario, in, {}, 0, 0, {}});
    if (in == ComparedRun::In::only_b) {
      record_.runs.back().notes.emplace_back("is only in B: there is nothing to compare it with");
      return;
    }
    record_.runs.back().notes.emplace_back("is only in A: B has no such run");
    const Figure verdict{{}, run.verdict};
    ComparedFigure figure = compared(record_.runs.size() - 1, {"run", "verdict", ""}, &verdict, nullptr, {});
    figure.b_word = "no run";
    for (std::size_t i = 0; i < thresholds_.size() && !allow_missing_; ++i) mark_broken(figure, i);
    record_.figures.push_back(std::move(figure));
  }

  ComparisonRecord finish() {
    std::stable_sort(record_.figures.begin(), record_.figures.end(),
                     [](const ComparedFigure& a, const ComparedFigure& b) { return rank(a) < rank(b); });
    return std::move(record_);
  }

 private:
  /// Whether it is the same on both sides.
  bool add_figure(const FigureKey& key, const Figure* a, const Figure* b) {
    const auto& [signal, metric, of] = key;
    ComparedRun& run = record_.runs.back();
    const bool both_numbers = a && b && a->number && b->number;
    const bool both_words = a && b && !a->number && !b->number;
    const bool undefined = both_words && a->word == kNoNumber;
    const bool equal = (both_numbers && *a->number == *b->number) || (both_words && a->word == b->word);
    if (!undefined) run.figures += 1, run.equal += equal ? 1 : 0;
    ComparedFigure figure = compared(record_.runs.size() - 1, key, a, b, sizes_);
    for (std::size_t i = 0; i < thresholds_.size(); ++i) {
      const Threshold& threshold = thresholds_[i];
      if (!threshold.covers(signal, metric)) continue;
      const bool asked_by_name = threshold.kind == Threshold::Kind::change;
      if (equal && !(undefined && asked_by_name)) {
        record_.conditions[i].judged += undefined ? 0 : 1;
      } else if (is_broken(threshold, figure, a, b)) {
        mark_broken(figure, i);
      } else {
        record_.conditions[i].judged += a && b ? 1 : 0;
      }
    }
    if (!equal || !figure.breaks.empty()) record_.figures.push_back(std::move(figure));
    return equal;
  }

  void mark_broken(ComparedFigure& figure, std::size_t condition) {
    figure.breaks.push_back(condition);
    ++record_.conditions[condition].judged;
    ++record_.conditions[condition].broken;
  }

  /// First what breaks a threshold, then what cannot be compared, then what is worse. Verdicts come before numbers, and of
  /// these the relatively largest change first. A change from 0 has no relative size: that of a count comes first, and that
  /// of anything else last, because it may be as small as rounding.
  static std::tuple<bool, Change, bool, double> rank(const ComparedFigure& figure) {
    double size = 0;
    if (figure.has_numbers()) size = *figure.a == 0 && figure.unit != "count" ? 0 : std::abs(figure.relative());
    return {figure.breaks.empty(), figure.change, figure.metric != "verdict", -size};
  }

  const std::vector<Threshold>& thresholds_;
  bool allow_missing_;
  Sizes sizes_;  // of the pair that is compared
  ComparisonRecord record_;
};

ComparedSide side_of(const CompareSide& side) {
  ComparedSide out{side.given, side.runs.size(), {}, {}, {}};
  std::set<std::string> dates, commits, versions;
  for (const RunSummary& run : side.runs) {
    if (!run.date.empty()) dates.insert(run.date);
    if (!run.commit.empty()) commits.insert(run.commit);
    versions.insert(run.evenstep);
  }
  out.dates.assign(dates.begin(), dates.end());
  out.commits.assign(commits.begin(), commits.end());
  out.versions.assign(versions.begin(), versions.end());
  return out;
}

/// For each run of A its partner in B; -1: none.
std::vector<std::ptrdiff_t> partners(const std::vector<RunSummary>& a, const std::vector<RunSummary>& b) {
  std::vector<std::ptrdiff_t> partner(a.size(), -1);
  if (a.size() == 1 && b.size() == 1) return {0};
  std::vector<bool> taken(b.size(), false);
  const auto pair_by = [&](std::string RunSummary::*name) {
    std::map<std::string, std::vector<std::size_t>> free_a, free_b;
    for (std::size_t i = 0; i < a.size(); ++i) {
      if (partner[i] < 0) free_a[a[i].*name].push_back(i);
    }
    for (std::size_t i = 0; i < b.size(); ++i) {
      if (!taken[i]) free_b[b[i].*name].push_back(i);
    }
    for (const auto& [key, in_a] : free_a) {
      const auto in_b = free_b.find(key);
      if (in_a.size() != 1 || in_b == free_b.end() || in_b->second.size() != 1) continue;
      partner[in_a.front()] = static_cast<std::ptrdiff_t>(in_b->second.front());
      taken[in_b->second.front()] = true;
    }
  };
  pair_by(&RunSummary::name);
  pair_by(&RunSummary::file);
  return partner;
}

}  // namespace

ComparisonRecord compare(const CompareSide& a, const CompareSide& b, const std::vector<Threshold>& thresholds,
                         bool allow_missing) {
  Comparison comparison(thresholds, allow_missing);
  const std::vector<std::ptrdiff_t> partner = partners(a.runs, b.runs);
  std::vector<bool> paired(b.runs.size(), false);
  for (std::size_t i = 0; i < a.runs.size(); ++i) {
    if (partner[i] < 0) {
      comparison.add_single(a.runs[i], ComparedRun::In::only_a);
      continue;
    }
    const auto in_b = static_cast<std::size_t>(partner[i]);
    comparison.add_pair(a.runs[i], b.runs[in_b]);
    paired[in_b] = true;
  }
  for (std::size_t i = 0; i < b.runs.size(); ++i) {
    if (!paired[i]) comparison.add_single(b.runs[i], ComparedRun::In::only_b);
  }
  ComparisonRecord record = comparison.finish();
  record.a = side_of(a);
  record.b = side_of(b);
  return record;
}

}  // namespace evenstep
