#pragma once
/// The contents of the files in a run folder. These functions are pure: a record in, a string (or bytes) out. The harness
/// writes the files to a temporary folder and renames it. Numbers are printed by fmt with the shortest text that reads back
/// to the same double; there are no locale and no dates.

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
std::string junit_xml(const RunRecord& run, const std::vector<ExpectationResult>& results, const std::string& error,
                      const std::string& reproduce);
/// First column t[s]; then one block per strategy and device (docs/metrics.md). Without RunRecord::keep_rows only the bins.
std::string series_csv(const RunRecord& run);
/// strategy,device,side,step,lateness_ns,policy: one row per UnderrunRow of the whole run, including the warm-up.
std::string underruns_csv(const RunRecord& run);
/// What a run on the wall clock has to say about itself, for people: how long it ran, how late its ticks were, and what was
/// missed, missing, late, cut or limited. Empty for a run in virtual time.
std::string live_lines(const RunRecord& run, const Metrics& metrics);
/// For people: the devices that did not say what their driver asked of them, a line each.
std::string device_notes(const RunRecord& run);
/// How the errors of each signal that was asserted grow over the judged time; one line per signal, for people.
std::string growth_lines(const Metrics& metrics, const std::vector<ExpectationResult>& results);
/// "left.force.direct velocity_jump: 5.4 step, limit <= 4 step: …": of an expectation, why and where it does not hold.
std::string failure_message(const ExpectationResult& result);
/// value, limit, margin, line; one row per expectation. `colour`: ANSI on a terminal.
std::string verdict_table(const std::vector<ExpectationResult>& results, bool colour);

// events.bin (docs/metrics.md): magic "EVSTEP01", per strategy its name, event names and rows; little endian.
std::vector<std::byte> events_bin(const RunRecord& run);
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
/// by name. Of runs, or of what has been read of their files.
std::optional<Difference> first_difference(const std::vector<StrategyRecord>& a, const std::vector<StrategyRecord>& b);

}  // namespace evenstep
