#pragma once
/// What the shards of a campaign need to know of it (evenstep/campaigns/parts.h): its first line, and a line for each item.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "evenstep/campaigns/parts.h"

namespace evenstep::internal {

/// An item as its line says it; a kind of campaign adds what it wants to keep.
struct PartItem {
  std::int64_t index = 0;
  bool failed = false;  ///< such items are counted, and are what stop_after counts
  virtual ~PartItem() = default;
};

class PartFormat {
 public:
  virtual ~PartFormat() = default;
  virtual std::int64_t items() const = 0;
  /// The first line, without its end. That of the whole, one shard of one, does not mention shards.
  virtual std::string header_line(Shard shard) const = 0;
  /// Reads the line of an item; throws std::runtime_error, which says what is wrong with it.
  virtual std::unique_ptr<PartItem> read(const std::string& line) const = 0;
  /// Takes in an item, by rising index; from 0 on without a gap, unless they are of a shard.
  virtual void take(const PartItem&) {}
  virtual std::optional<std::int64_t> stop_after() const { return std::nullopt; }
};

/// Does an item and returns its line, without the line end; empty if it was interrupted. Several threads call it, unless
/// PartOptions::threads is 1.
using RunItem = std::function<std::string(std::int64_t item)>;
/// Does the part that `options` ask for. Its lines are written in order of the items to a file beside its own that ends in
/// ".partial", which is renamed when it is complete. If it is interrupted, that file remains for `resume`, which keeps its
/// complete lines. At the end `format` has taken in all lines, kept and new. Sets exit, file, items and done, or an error or
/// a failure.
void run_part(PartFormat& format, const RunItem& run, std::string_view kind, const PartOptions& options,
              PartOutcome& outcome);

/// The format of a part with this first line. Throws std::runtime_error, which says what is wrong with it.
std::unique_ptr<PartFormat> format_of(const std::string& header_line);
/// As merge_parts. `format`, which has taken in all items, stays empty if the parts do not belong together.
PartOutcome merge_into(const std::vector<std::string>& parts, const std::string& out, std::unique_ptr<PartFormat>& format);
/// As parts_status. Throws std::runtime_error.
void read_status(const std::string& folder, std::string_view kind, PartsStatus& status, std::unique_ptr<PartFormat>& format);

}  // namespace evenstep::internal
