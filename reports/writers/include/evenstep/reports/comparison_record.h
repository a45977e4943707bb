#pragma once
/// What `evenstep compare` found between two sides, A (before) and B (after). The record is filled in by
/// evenstep/campaigns/compare.h; the writers here turn it into text, Markdown and JSON. docs/begin/compare.md says what
/// counts.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/reports/measures.h"

namespace evenstep {

/// What was compared: a run, or all runs of a folder.
struct ComparedSide {
  std::string given;  ///< as it was typed
  std::size_t runs = 0;
  std::vector<std::string> dates, commits, versions;  ///< of these runs, each once, in order; runs without one add none
};

struct ComparedRun {
  std::string name;      ///< its place below the folder, or its scenario's file
  std::string scenario;  ///< the scenario's name
  enum class In : std::uint8_t { both, only_a, only_b } in = In::both;
  std::vector<std::string> notes;  ///< why the two are not the same thing measured twice: another seed, another solver, ...
  std::size_t figures = 0, equal = 0;  ///< how many figures were compared, and how many are the same to the last bit
  std::string trace_hash;              ///< of both runs, if it is the same and nothing else differs; otherwise empty
};

/// A figure (a metric, the margin or the verdict of an expectation) that differs or cannot be compared.
struct ComparedFigure {
  std::size_t run = 0;  ///< index into ComparisonRecord::runs
  std::string signal, metric;
  std::string of;              ///< of a margin or a verdict: the expectation, "velocity_jump <= 1e-06 step"
  std::string unit;            ///< SI base unit, "count" or "1"; empty for verdicts
  std::optional<double> a, b;  ///< empty: no number, and the word says what stands there instead
  std::string a_word, b_word;
  enum class Change : std::uint8_t { incomparable, worse, better, other } change = Change::other;
  bool minor = false;  ///< not shown unless a condition is broken: margins, rounding, and what the machine's clock says
  std::vector<std::size_t> breaks = {};  ///< indices into ComparisonRecord::conditions
  bool rounding = false;  ///< both numbers are below 1e-12 of the largest of their signal with this unit: no change at all

  bool has_numbers() const { return a && b; }
  double difference() const { return *b - *a; }
  /// (b - a) / |a|: 0.05 for 5 % more; infinite if a is 0. Only if both are numbers that differ.
  double relative() const;
};

/// A condition of --fail-if.
struct ComparedCondition {
  std::string text;
  std::size_t judged = 0;  ///< figures that it was checked on; 0: it says nothing, so it does not hold
  std::size_t broken = 0;
  bool holds() const { return judged > 0 && broken == 0; }
};

struct ComparisonRecord {
  ComparedSide a, b;
  std::vector<ComparedRun> runs;
  std::vector<ComparedFigure> figures;  ///< those that differ: broken conditions first, then what is worse
  std::vector<ComparedCondition> conditions;
  bool holds() const;  ///< every condition does
};

/// For a terminal: conditions, notes, and a table of at most `most_rows` figures. `colour`: ANSI. `minor`: minor figures,
/// too.
std::string comparison_text(const ComparisonRecord& record, bool colour, std::size_t most_rows, bool minor);
/// For a pull request, at most 60,000 bytes (a comment on GitHub may have 65,536).
std::string comparison_markdown(const ComparisonRecord& record);
/// For other programs, everything.
std::string comparison_json(const ComparisonRecord& record);

// Parts of these texts, which the page uses, too (evenstep/pages/comparison_page.h).

/// "12.8422 ms", "3", or what stands there instead of a number.
std::string value_a(const ComparedFigure& figure);
std::string value_b(const ComparedFigure& figure);
/// "+1.3 ms, +10.2 %"; without a percentage for words and for a change from 0.
std::string change_text(const ComparedFigure& figure);
/// "worse", "better", "changed", "cannot be compared".
const char* name_of(ComparedFigure::Change change);
/// "velocity_jump", "margin of velocity_jump <= 1e-06 step"
std::string figure_name(const ComparedFigure& figure);
/// "runs/a: 12 runs, 2026-11-23T11:05:13Z, commit 0123456789ab, evenstep 0.2.0"
std::string side_text(const ComparedSide& side);
/// "2 of 8 conditions do not hold" or "all conditions hold", and what was equal, in one sentence.
std::string headline(const ComparisonRecord& record);
/// "latency > +5 %: broken by 2 of 12 figures"
std::string condition_text(const ComparedCondition& condition);
/// The figures to show: those that are not minor or break a condition.
std::vector<const ComparedFigure*> shown_figures(const ComparisonRecord& record, bool minor);

}  // namespace evenstep
