// CSV with a row for each interval, or two: rocprofv3, Nsight Systems' statistics, Perfetto's trace_processor, Tracy's
// csvexport, and any other whose columns are known (column_names.cpp) or named by the user.
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "column_names.h"
#include "decimal_time.h"
#include "profile_formats.h"

namespace evenstep::internal {
namespace {

/// Which columns the file has.
struct Layout {
  std::optional<Column> name, begin, end, length, process, queue, stream, thread, event, category;
};

Layout layout_of(const std::vector<std::string>& header) {
  const auto find = [&](Quantity quantity) { return column_for(header, quantity); };
  return {find(Quantity::name),    find(Quantity::begin),   find(Quantity::end),    find(Quantity::length),
          find(Quantity::process), find(Quantity::queue),   find(Quantity::stream), find(Quantity::thread),
          find(Quantity::event),   find(Quantity::category)};
}

/// The layout that the user's columns make; nothing after an error.
std::optional<Layout> layout_of(const CsvColumns& columns, const CsvTable& table, ProfileBuilder& builder) {
  const std::optional<std::int64_t> unit = time_unit_ns(columns.unit);
  const auto find = [&](const std::string& name, std::int64_t unit_ns) -> std::optional<Column> {
    if (name.empty()) return std::nullopt;
    const std::optional<std::size_t> index = table.column(name);
    if (!index) builder.fail(fmt::format("there is no column '{}'; it has {}", name, table.columns_text()), table.line(), 1);
    return Column{index.value_or(0), unit_ns, nullptr};
  };
  Layout layout;
  layout.name = find(columns.name, 0);
  layout.begin = find(columns.begin, unit.value_or(1));
  layout.end = find(columns.end, unit.value_or(1));
  layout.length = find(columns.duration, unit.value_or(1));
  layout.process = find(columns.process, 0);
  if (columns.begin.empty() || columns.end.empty() == columns.duration.empty())
    builder.fail("a CSV needs --begin COLUMN and one of --end COLUMN and --duration COLUMN");
  if (!unit) builder.fail(fmt::format("'{}' is no unit for the times of a CSV; write --unit ns, us, ms or s", columns.unit));
  if (builder.failed()) return std::nullopt;
  return layout;
}

/// What rocprofv3 calls the kinds of its rows, in the words of other readers.
std::string_view category_of_kind(std::string_view kind) {
  if (kind.find("KERNEL") != std::string_view::npos) return "kernel";
  if (kind.find("MEMORY_COPY") != std::string_view::npos) return "copy";
  if (kind.find("MARKER") != std::string_view::npos) return "range";
  return "";
}

class RowReader {
 public:
  RowReader(CsvTable& table, const Layout& layout, ProfileBuilder& builder)
      : table_(table), layout_(layout), builder_(builder) {}

  void read_all() {
    while (!builder_.failed() && table_.next()) layout_.event ? read_event() : read_row();
    if (!table_.error().empty()) builder_.fail(table_.error());
    for (const auto& [key, lane] : lanes_) {
      for (std::size_t i = 0; i < lane.begins.size(); ++i)
        builder_.leave_out("rows that enter and never leave", builder_.profile().names[key.second].text);
    }
    if (table_.rows_of_others() > 0)
      builder_.leave_out("rows of another recording behind the first one", "", false, table_.rows_of_others());
  }

 private:
  std::string_view cell(const std::optional<Column>& column) const {
    return column ? table_.cell(column->index) : std::string_view();
  }
  std::string_view name() const { return layout_.name ? cell(layout_.name) : "interval"; }
  /// "process 7", "agent 2": a cell may say itself what its number is.
  static std::string labelled(std::string_view label, std::string_view cell) {
    const bool number = cell.find_first_not_of("0123456789") == std::string_view::npos;
    return number ? fmt::format("{} {}", label, cell) : std::string(cell);
  }
  std::uint32_t track() {
    std::string source;
    if (layout_.process) {
      const std::string_view known = layout_.process->known == nullptr ? "" : layout_.process->known->name;
      const bool agent = known == "agent_id" || known == "gpu-id";
      source = agent ? labelled("Agent", cell(layout_.process)) : fmt::format("process {}", cell(layout_.process));
    }
    const std::string_view queue = cell(layout_.queue), thread = cell(layout_.thread);
    if (!queue.empty()) return builder_.track(source, labelled("queue", queue), TrackOrder::follow);
    if (!thread.empty()) return builder_.track(source, labelled("thread", thread), TrackOrder::nest);
    return builder_.track(source);
  }
  std::optional<std::int64_t> time(const std::optional<Column>& column) const {
    return column ? decimal_time_ns(table_.number(column->index), column->unit_ns) : std::nullopt;
  }
  std::string here() const { return fmt::format("line {}: {}", table_.line(), name()); }

  void read_row() {
    const std::optional<std::int64_t> begin = time(layout_.begin), length = time(layout_.length);
    std::optional<std::int64_t> end = time(layout_.end);
    if (!end && begin && length) end = *begin + *length;
    if (!begin || !end) return builder_.leave_out(begin ? "rows without an end" : "rows without times", here());
    if (!layout_.end && *length < 0) return builder_.leave_out("rows that have not ended", here());
    if (*end > kFurthestTime_ns) return builder_.leave_out("rows without an end", here());
    builder_.add(builder_.name(name(), category_of_kind(cell(layout_.category))), track(), *begin, *end);
  }

  /// Rows of one lane nest by name.
  void read_event() {
    const std::optional<std::int64_t> at = time(layout_.begin);
    if (!at) return builder_.leave_out("rows without times", here());
    const std::uint32_t name_index = builder_.name(name(), "");
    const std::string key = fmt::format("{},{},{}", cell(layout_.process), cell(layout_.stream), cell(layout_.thread));
    Lane& lane = lanes_[{key, name_index}];
    if (lanes_.size() > kMostNames) return builder_.fail(fmt::format("more than {} lanes and names", kMostNames));
    const std::string_view event = cell(layout_.event);
    if (*at < lane.last_ns) return builder_.leave_out("rows whose time goes back", here());
    lane.last_ns = *at;
    if (event == "Enter") {
      if (++entered_ > kMostIntervals) return builder_.fail(fmt::format("more than {} intervals", kMostIntervals));
      lane.begins.push_back(*at);
    } else if (event != "Leave") {
      builder_.leave_out("rows that neither enter nor leave", here());
    } else if (lane.begins.empty()) {
      builder_.leave_out("rows that leave what was not entered", here());
    } else {
      builder_.add(name_index, track(), lane.begins.back(), *at);
      lane.begins.pop_back();
    }
  }

  struct Lane {
    std::vector<std::int64_t> begins;
    std::int64_t last_ns = INT64_MIN;
  };

  CsvTable& table_;
  const Layout& layout_;
  ProfileBuilder& builder_;
  std::map<std::pair<std::string, std::uint32_t>, Lane> lanes_;  ///< by lane and name
  std::size_t entered_ = 0;
};

}  // namespace

bool is_interval_csv(const ProfileInput& input) { return are_intervals(input.head.cells); }

void read_interval_csv(ProfileInput& input, const ProfileOptions& options, ProfileBuilder& builder) {
  CsvTable table(input.bytes, input.head);
  const bool named = !options.columns.begin.empty() || !are_intervals(input.head.cells);
  const std::optional<Layout> layout =
      named ? layout_of(options.columns, table, builder) : std::optional(layout_of(input.head.cells));
  if (!layout) return;
  const std::string_view tool = named ? "" : layout->begin->known->tool;
  builder.profile().format = !tool.empty()                     ? tool
                             : layout->event                   ? "CSV with Enter and Leave"
                             : layout->begin->known != nullptr ? "CSV of intervals"
                                                               : "CSV";
  builder.profile().time_base = fmt::format("{}, as the {} of its columns says", time_unit_text(layout->begin->unit_ns),
                                            named ? "unit given" : "header");
  if (input.head.decimal == ',') builder.profile().time_base += "; with decimal commas";
  RowReader(table, *layout, builder).read_all();
}

}  // namespace evenstep::internal
