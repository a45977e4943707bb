#pragma once
/// The lines of sweep.jsonl: a header, then one line per point. A line that is read and written again has the same text.

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "evenstep/campaigns/sweep.h"
#include "src/shards/format.h"
#include "src/shards/json.h"

namespace evenstep::internal {

/// A line without its line end. If `shard` is one of one, it is the whole sweep, whose header does not mention shards.
std::string header_line(const SweepHeader& header, Shard shard);
std::string point_line(const SweepHeader& header, const SweepPoint& point);

struct HeaderLine {
  SweepHeader header;
  Shard shard;
};
/// These throw std::runtime_error, which says what is wrong with the line.
HeaderLine read_header_line(const std::string& line);
SweepPoint read_point_line(const SweepHeader& header, const std::string& line);

struct SweepItem : PartItem {
  SweepPoint point;
};
class SweepParts : public PartFormat {
 public:
  explicit SweepParts(SweepHeader header) : header_(std::move(header)), summarizer_(header_) {}
  SweepParts(const SweepParts&) = delete;
  SweepParts& operator=(const SweepParts&) = delete;

  const SweepHeader& header() const { return header_; }
  SweepSummary summary() const { return summarizer_.summary(); }
  std::int64_t items() const override { return header_.points(); }
  std::string header_line(Shard shard) const override { return internal::header_line(header_, shard); }
  std::unique_ptr<PartItem> read(const std::string& line) const override;
  void take(const PartItem& item) override;
  std::optional<std::int64_t> stop_after() const override { return header_.stop_after; }

 private:
  SweepHeader header_;
  SweepSummarizer summarizer_;
};

/// The exit code of a whole sweep. With `find` only the value that is found counts, because failures on the other side of it
/// are expected.
ExitCode exit_of(const SweepSummary& summary);

}  // namespace evenstep::internal
