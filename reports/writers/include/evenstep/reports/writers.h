#pragma once
/// The contents of the files in a run folder. These functions are pure: a record in, a text out; those whose length grows
/// with the run write it to a stream row by row. The harness writes the files to a temporary folder and renames it. Numbers
/// are printed by fmt with the shortest text that reads back to the same double; there are no locale and no dates.

#include <cstdint>
#include <iosfwd>
#include <span>
#include <string>
#include <vector>

#include "evenstep/reports/measures.h"
#include "evenstep/reports/run_record.h"
#include "evenstep/reports/verdict.h"

namespace evenstep {

std::string summary_json(const RunRecord& run, const Metrics& metrics, const std::vector<ExpectationResult>& results,
                         const std::string& version, const std::string& verdict, const std::string& failure = "");
/// The JSON Schema (draft 4) of every summary.json: docs/schema/summary-1.json.
std::string summary_schema();
/// One run for JUnit: a test suite with a test case per expectation. The verdict on the run as a whole is one more test
/// case, "run".
struct JunitSuite {
  enum class Whole : std::uint8_t { silent, passed, failed, broken };  ///< broken: an error, not a failure
  std::string scenario, file;
  std::uint64_t seed = 1;
  std::string clock;  ///< empty: no run, so no seed and no trace
  std::uint64_t trace_hash = 0;
  std::vector<ExpectationResult> results;
  Whole whole = Whole::silent;
  std::string why;        ///< of `whole`
  std::string reproduce;  ///< the command that runs it again; empty: not said
};
/// One document with these suites, as Jenkins' schema for xUnit (junit-10) wants it.
std::string junit_xml(std::span<const JunitSuite> suites);
/// First column t[s]; then one block per strategy and device (docs/reference/metrics.md). Without RunRecord::keep_rows only
/// the bins.
void series_csv(const RunRecord& run, std::ostream& out);
/// strategy,device,side,step,lateness_ns,policy: one row per UnderrunRow of the whole run, including the warm-up.
void underruns_csv(const RunRecord& run, std::ostream& out);
/// What a run on the wall clock has to say about itself, for people: how long it ran, how late its ticks were, and what was
/// missed, missing, late, cut or limited. Empty for a run in virtual time.
std::string live_lines(const RunRecord& run, const Metrics& metrics);
/// For people: the devices that did not tell their driver what it asked, a line each.
std::string device_notes(const RunRecord& run);
/// How the errors of each signal that was asserted grow over the judged time; one line per signal, for people.
std::string growth_lines(const Metrics& metrics, const std::vector<ExpectationResult>& results);
/// A line per strategy, for people: its latency ("~": it has none, and this is the mean age of what its forces answer,
/// played_age), the largest jump of the hand (velocity_jump of the interaction, per step) and of the force
/// (jump_max, between two ticks), and how many forces were late, samples missing, and samples and forces saturated. Of
/// several devices the largest value ("-": none has one), and the sum of the counts. Empty if nothing was measured, as of a
/// run that failed.
std::string strategy_table(const RunRecord& run, const Metrics& metrics);
/// "left.force.direct velocity_jump: 5.4 step, limit <= 4 step: …": why and where an expectation does not hold.
std::string failure_message(const ExpectationResult& result);
/// value, limit, margin, line; one row per expectation. `colour`: ANSI on a terminal.
std::string verdict_table(const std::vector<ExpectationResult>& results, bool colour);

// events.bin (docs/reference/metrics.md): magic "EVSTEP01", per strategy its name, event names and rows; little endian.
void events_bin(const RunRecord& run, std::ostream& out);
/// Of each record: name, event_names, events and trace_hash only.
using EventFile = std::vector<StrategyRecord>;
/// Throws std::runtime_error with the byte offset of the fault. The input is not trusted: sizes are checked before use.
EventFile read_events_bin(const std::vector<std::byte>& bytes);
struct Difference {
  std::string strategy;
  std::int64_t index = -1;
  std::string text;
};
/// The first event that differs (by binary search over the chained hashes); empty if all are equal. Strategies are matched
/// by name. For records of runs as for those read from their files.
std::optional<Difference> first_difference(const std::vector<StrategyRecord>& a, const std::vector<StrategyRecord>& b);

}  // namespace evenstep
