#pragma once
/// What a sweep found: its points as they stand in sweep.jsonl, and what they add up to. docs/sweep.md.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/reports/rate_bound.h"

namespace evenstep {

enum class SweepVerdict {
  pass,
  fail,   ///< an expectation failed
  error,  ///< the run stopped, or an expectation could not be judged: never a pass
};
const char* name_of(SweepVerdict verdict);

/// The first line of the file. The same for every shard of a sweep.
struct SweepHeader {
  std::string name, file;           ///< of the scenario; its file as it was given, which two parts may call by different names
  std::string scenario, build;      ///< digests: two files belong together only if these are equal
  std::vector<std::uint64_t> seeds;
  struct Axis { std::string path; std::vector<std::string> values; };  ///< values as TOML
  std::vector<Axis> grid;           ///< the first varies slowest
  struct Expect { std::string signal, metric, unit; };
  std::vector<Expect> expectations;
  std::optional<std::int64_t> stop_after;
  int keep_worst = 5;
  struct Find { std::size_t axis = 0; bool smallest = true; std::string gate; std::size_t allowed = 0; };
  std::optional<Find> find;         ///< as SweepFind of the scenario

  /// Points are numbered combination * seeds + position of the seed.
  std::int64_t combinations() const;
  std::int64_t points() const { return combinations() * static_cast<std::int64_t>(seeds.size()); }
  std::uint64_t seed_of(std::int64_t point) const;
  /// Which value of an axis a point has.
  std::size_t value_of(std::int64_t point, std::size_t axis) const;
};

/// One run.
struct SweepPoint {
  std::int64_t index = 0;
  SweepVerdict verdict = SweepVerdict::pass;
  struct Value {
    std::optional<double> value, min, max;  ///< in the unit of the header
    SweepVerdict verdict = SweepVerdict::pass;
  };
  std::vector<Value> expect;                ///< as the header's; empty where the run stopped
  std::uint64_t trace_hash = 0;
  std::string failure;                      ///< why it stopped or could not be judged
};

struct SweepRecord {
  SweepHeader header;
  std::vector<SweepPoint> points;           ///< by index, without a gap from 0 on unless it is a shard
};

struct SweepTally {
  std::int64_t passed = 0, failed = 0, errors = 0;
  std::int64_t runs() const { return passed + failed + errors; }
  /// At 95 %. Where a sweep stopped after its last failure it is a little too high, never too low.
  double failure_rate_at_most() const { return rate_at_most(failed + errors, runs()); }
};

struct SweepSummary {
  SweepTally all;
  std::vector<std::vector<SweepTally>> values;  ///< per axis and value
  bool stopped = false;                         ///< by stop_after: later points were not run or left out
  struct Worst {
    std::size_t point = 0;                      ///< of SweepRecord::points
    double excess = 0;                          ///< over the limit, as a share of it; below 0: within
    std::optional<std::size_t> expectation;     ///< none: it stopped
  };
  std::vector<Worst> worst;  ///< largest excess first, then by index; with `find`, of the value next to it, which failed
  struct Find {
    std::optional<std::size_t> value;           ///< of the axis; none: not even the value at the safe end passes
    bool within_gate = false;
    std::int64_t beyond = 0;                    ///< values on the failing side that pass all the same
  };
  std::optional<Find> find;
};
SweepSummary summarize(const SweepRecord& record);

/// `command`: what runs a point again.
using SweepCommand = std::function<std::string(const SweepPoint&)>;
std::string sweep_text(const SweepRecord& record, const SweepSummary& summary, const SweepCommand& command);
std::string sweep_json(const SweepRecord& record, const SweepSummary& summary, const SweepCommand& command);

/// A value of the grid as people write it: 5 ms for "5 ms".
std::string shown_value(const std::string& toml);

}  // namespace evenstep
