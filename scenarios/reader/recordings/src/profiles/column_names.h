#pragma once
/// What profilers call their columns: one table for all formats, with a row for each name of a quantity.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace evenstep::internal {

enum class Quantity {
  // of an interval
  name,
  begin,
  end,
  length,
  process,
  queue,   ///< runs one after the other
  stream,  ///< may run several at a time
  thread,
  event,  ///< Enter or Leave
  category,
  // of a picture
  application,
  process_id,
  swap_chain,
  frame_type,
  cpu_start,     ///< instant at which the program begins it
  present,       ///< instant at which the program hands it over
  gpu_latency,   ///< from cpu_start to the GPU's begin
  gpu_time,      ///< from the GPU's begin to its end
  render_start,  ///< from present to the GPU's begin; may be negative
  render_end,    ///< from present to the GPU's end
  to_next,       ///< from its cpu_start to that of the next one
  from_last,     ///< from the present before to this one
};

struct ColumnName {
  Quantity quantity;
  const char* name;      ///< in lower case, without a unit in brackets
  std::int64_t unit_ns;  ///< of a time; 0: the unit in brackets, without which the column is not known
  const char* tool;      ///< who writes it, if it is only one
};

/// A column of a file.
struct Column {
  std::size_t index = 0;
  std::int64_t unit_ns = 0;
  const ColumnName* known = nullptr;
};

/// All meanings that the header's columns can have for a quantity, the best first. One column may have several units.
std::vector<Column> columns_for(const std::vector<std::string>& header, Quantity quantity);
std::optional<Column> column_for(const std::vector<std::string>& header, Quantity quantity);
/// The columns that may be times.
std::vector<Column> time_columns(const std::vector<std::string>& header);
/// Where a column of just this name is.
std::optional<std::size_t> index_of(const std::vector<std::string>& header, std::string_view name);

/// Whether a row of such columns is an interval, or an event that begins or ends one.
bool are_intervals(const std::vector<std::string>& header);
/// Whether a row of such columns is a picture.
bool are_pictures(const std::vector<std::string>& header);
/// Whether it is a picture with lengths only, as Unreal's CSV profiler writes them.
bool are_picture_lengths(const std::vector<std::string>& header);
/// Why rows of such columns are neither, for those that profilers write, too; empty for others.
std::string_view why_refused(const std::vector<std::string>& header);

}  // namespace evenstep::internal
