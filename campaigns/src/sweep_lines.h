#pragma once
/// The lines of sweep.jsonl: a header, then one point each. What is written reads back to the same text. The last member of
/// each is its checksum, "check": XXH64 of the object without it. Bits that flip are no attack, and 64 of them suffice.

#include <optional>
#include <string>

#include "evenstep/campaigns/sweep.h"

namespace evenstep::internal {

/// One line without its end. `shard` of one: the whole sweep, whose header says nothing of shards.
std::string header_line(const SweepHeader& header, SweepShard shard);
std::string point_line(const SweepHeader& header, const SweepPoint& point);

/// A line, which is an object, with its checksum.
std::string with_checksum(std::string line);

struct HeaderLine {
  SweepHeader header;
  SweepShard shard;
};
/// Throw std::runtime_error that says what is wrong with the line.
HeaderLine read_header_line(const std::string& line);
SweepPoint read_point_line(const SweepHeader& header, const std::string& line);

/// Equal but for the name that the scenario's file was called by.
bool same_sweep(SweepHeader a, const SweepHeader& b);

inline bool failed(const SweepPoint& point) { return point.verdict != SweepVerdict::pass; }
/// Of a whole sweep. With `find` only what is found counts: failures on the other side of it are what it looks for.
ExitCode exit_of(const SweepSummary& summary);

}  // namespace evenstep::internal
