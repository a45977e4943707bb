#pragma once
/// The results of a sweep: its points as they are in sweep.jsonl, and their summary. See docs/timings/sweep.md.

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
  fail,    ///< an expectation failed
  error,   ///< the run stopped, or an expectation could not be judged: never a pass
  skipped  ///< of an expectation only: it does not apply to this point
};
const char* name_of(SweepVerdict verdict);

/// The first line of the file, which is the same for every shard of a sweep.
struct SweepHeader {
  std::string name, file;        ///< the scenario's name, and its file as given (two shards may have different paths)
  std::vector<std::string> set;  ///< what --set changed in it, but for [sweep]
  std::string scenario, build;   ///< digests: two files belong together only if these are equal
  std::vector<std::uint64_t> seeds;
  struct Axis {
    std::string path;
    std::vector<std::string> values;
  };                       ///< values as TOML
  std::vector<Axis> grid;  ///< the first varies slowest
  struct Expect {
    std::string signal, metric, unit;
  };
  std::vector<Expect> expectations;
  struct Sometimes {
    std::string name, signal, metric;
  };
  std::vector<Sometimes> sometimes;  ///< states that a point must reach
  std::vector<std::string> swarm;    ///< faults, some of which each seed switches off; empty: it is no swarm
  std::optional<std::int64_t> stop_after;
  int keep_worst = 5;
  struct Find {
    std::size_t axis = 0;
    bool smallest = true;
    std::string gate;
    std::size_t allowed = 0;
  };
  std::optional<Find> find;  ///< the scenario's SweepFind

  /// Points have the numbers combination * number of seeds + position of the seed.
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
  std::vector<Value> expect;           ///< in the order of the header; empty if the run stopped
  std::vector<bool> reached;           ///< for each state of the header; empty if the run stopped
  std::vector<std::string> faults_on;  ///< of a swarm, in the order of the header
  std::uint64_t trace_hash = 0;
  std::string failure;  ///< why it stopped or could not be judged
};

struct SweepTally {
  std::int64_t passed = 0, failed = 0, errors = 0;
  std::int64_t runs() const { return passed + failed + errors; }
  /// With 95 % confidence. If a sweep stopped after its last failure, it is a little too high, never too low.
  double failure_rate_at_most() const { return rate_at_most(failed + errors, runs()); }
};

struct SweepSummary {
  SweepTally all;
  std::vector<std::vector<SweepTally>> values;  ///< per axis and value
  bool stopped = false;                         ///< stopped by stop_after: later points were not run, or are left out
  struct Worst {
    SweepPoint point;
    double excess = 0;                       ///< by how much the limit is exceeded, as a share of it; below 0: within it
    std::optional<std::size_t> expectation;  ///< empty: the run stopped
  };
  /// Largest excess first, then by index. With `find`: only points of the value next to the one found, which is a value that
  /// failed.
  std::vector<Worst> worst;
  struct Find {
    std::optional<std::size_t> value;  ///< position on the axis; empty: not even the safe end passes
    bool within_gate = false;
    std::int64_t beyond = 0;  ///< number of values on the failing side that pass nevertheless
  };
  std::optional<Find> find;
  /// Those that did not pass, by index, at most kMostListed; none with `find`, where failures are expected.
  std::vector<Worst> not_passed;
  std::vector<std::int64_t> reached;  ///< for each state: the points that reached it
  std::vector<std::int64_t> judged;   ///< for each expectation: the points to which it applied
  bool complete = false;              ///< whether all points are there: not in a shard, nor in a sweep that stopped
  /// Whether it is complete, and there is a state that no point reached, or an expectation that applied to none.
  bool untested() const;
};
inline constexpr std::size_t kMostListed = 1000;

/// Adds points up to their summary, in memory that does not grow with their number.
class SweepSummarizer {
 public:
  explicit SweepSummarizer(const SweepHeader& header);  ///< which must outlive it
  /// Points by rising index; from 0 on without a gap, unless they are of a shard.
  void add(const SweepPoint& point);
  SweepSummary summary() const;

 private:
  const SweepHeader* header_;
  SweepSummary so_far_;                                  // without its find and worst
  std::vector<std::vector<SweepSummary::Worst>> worst_;  // with `find` of each of its values, else of all points
};

/// The command that runs a point again.
using SweepCommand = std::function<std::string(const SweepPoint&)>;
std::string sweep_text(const SweepHeader& header, const SweepSummary& summary, const SweepCommand& command);
std::string sweep_json(const SweepHeader& header, const SweepSummary& summary, const SweepCommand& command);

/// As JUnit's XML: one testcase for all points that pass, which says how many, and one for each point that does not, with
/// its command. Above kMostListed the others are one testcase, which says how many. With `find` there is one testcase in
/// place of these: what was found. Each state, and each expectation that applied to no point, is a testcase, too.
std::string sweep_junit(const SweepHeader& header, const SweepSummary& summary, const SweepCommand& command);

/// A value of the grid without TOML's quotes: 5 ms for "5 ms".
std::string shown_value(const std::string& toml);

}  // namespace evenstep
