#pragma once
/// The lines of sweep.jsonl: a header, then one line per point. A line that is read and written again has the same text. The
/// last member of each line is its checksum, "check": XXH64 of the object without it. It guards against accidental damage,
/// not against attacks, so 64 bits are enough.

#include <optional>
#include <string>
#include <vector>

#include "evenstep/campaigns/sweep.h"

namespace evenstep::internal {

/// A line without its line end. If `shard` is one of one, it is the whole sweep, whose header does not mention shards.
std::string header_line(const SweepHeader& header, SweepShard shard);
std::string point_line(const SweepHeader& header, const SweepPoint& point);

/// The line, which is a JSON object, with its checksum added.
std::string with_checksum(std::string line);

struct HeaderLine {
  SweepHeader header;
  SweepShard shard;
};
/// These throw std::runtime_error, which says what is wrong with the line.
HeaderLine read_header_line(const std::string& line);
SweepPoint read_point_line(const SweepHeader& header, const std::string& line);

/// What a merge compares of a header, without reading its ten million seeds for each of ten thousand parts.
struct PartHeader {
  SweepShard shard;
  std::string file;
  std::vector<std::string> set;
  std::string scenario, build;
  std::string common;  ///< the text that all parts of a sweep share: all but shard, file and set
};
PartHeader read_part_header(const std::string& line);

/// Whether two headers are equal, except for the name of the scenario's file.
bool same_sweep(SweepHeader a, const SweepHeader& b);

inline bool failed(const SweepPoint& point) { return point.verdict != SweepVerdict::pass; }
/// The exit code of a whole sweep. With `find` only the value that is found counts, because failures on the other side of it
/// are expected.
ExitCode exit_of(const SweepSummary& summary);

}  // namespace evenstep::internal
