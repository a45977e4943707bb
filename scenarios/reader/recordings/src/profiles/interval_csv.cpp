// CSV with a row for each interval, or two: Nsight Systems' statistics, Perfetto's trace_processor, Tracy's csvexport, and
// any other whose columns the user names.
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "decimal_time.h"
#include "profile_formats.h"

namespace evenstep::internal {
namespace {

/// Which columns a kind of CSV has. Empty: it has none.
struct Layout {
  const char* title;
  std::string name, begin, end, duration, process, lane, event;  ///< `event`: Enter or Leave
  std::string unit;
};

const std::vector<Layout>& known_layouts() {
  static const std::vector<Layout> layouts{
      {"Nsight Systems CSV", "Name", "Start (ns)", "End (ns)", "", "PID", "", "", "ns"},
      {"Nsight Systems CSV", "Name", "Start (ns)", "", "Duration (ns)", "", "", "", "ns"},
      {"CSV with Enter and Leave", "Name", "Timestamp (ns)", "", "", "Process", "streamId", "Event Type", "ns"},
      {"Tracy CSV", "name", "ns_since_start", "", "exec_time_ns", "", "thread", "", "ns"},
      {"trace_processor CSV", "name", "ts", "", "dur", "upid", "", "", "ns"},
  };
  return layouts;
}

bool has(const std::vector<std::string>& header, const std::string& column) {
  return column.empty() || std::find(header.begin(), header.end(), column) != header.end();
}

/// Process and lane need not be there.
const Layout* layout_of(const std::vector<std::string>& header) {
  for (const Layout& one : known_layouts()) {
    if (has(header, one.name) && has(header, one.begin) && has(header, one.end) && has(header, one.duration) &&
        has(header, one.event))
      return &one;
  }
  return nullptr;
}

/// The layout that the user's columns make; nothing after an error.
std::optional<Layout> layout_of(const CsvColumns& columns, const CsvTable& table, ProfileBuilder& builder) {
  for (const std::string* column : {&columns.name, &columns.begin, &columns.end, &columns.duration, &columns.process}) {
    if (!has(table.header(), *column))
      builder.fail(fmt::format("there is no column '{}'; it has {}", *column, table.columns_text()), table.line(), 1);
  }
  if (columns.begin.empty() || columns.end.empty() == columns.duration.empty())
    builder.fail("a CSV needs --begin COLUMN and one of --end COLUMN and --duration COLUMN");
  if (!time_unit_ns(columns.unit))
    builder.fail(fmt::format("'{}' is no unit for the times of a CSV; write --unit ns, us, ms or s", columns.unit));
  if (builder.failed()) return std::nullopt;
  return Layout{"CSV", columns.name, columns.begin, columns.end, columns.duration, columns.process, "", "", columns.unit};
}

class RowReader {
 public:
  RowReader(CsvTable& table, const Layout& layout, ProfileBuilder& builder)
      : table_(table),
        builder_(builder),
        name_(table.column(layout.name)),
        begin_(table.column(layout.begin)),
        end_(table.column(layout.end)),
        duration_(table.column(layout.duration)),
        process_(table.column(layout.process)),
        lane_(table.column(layout.lane)),
        event_(table.column(layout.event)),
        unit_ns_(*time_unit_ns(layout.unit)) {}

  void read_all() {
    while (!builder_.failed() && table_.next()) event_ ? read_event() : read_row();
    if (!table_.error().empty()) builder_.fail(table_.error());
    for (const auto& [key, begins] : open_) {
      for (std::size_t i = 0; i < begins.size(); ++i)
        builder_.leave_out("rows that enter and never leave", builder_.profile().names[key.second].text);
    }
  }

 private:
  std::string_view name() const { return name_ ? table_.cell(name_) : "interval"; }
  std::uint32_t source() { return builder_.source(process_ ? fmt::format("process {}", table_.cell(process_)) : ""); }
  std::optional<std::int64_t> time(std::optional<std::size_t> column) const {
    return decimal_time_ns(table_.cell(column), unit_ns_);
  }
  std::string here() const { return fmt::format("line {}: {}", table_.line(), name()); }

  void read_row() {
    const std::optional<std::int64_t> begin = time(begin_), length = time(duration_);
    std::optional<std::int64_t> end = time(end_);
    if (duration_ && begin && length) end = *begin + *length;
    if (!begin || (!end && !length)) return builder_.leave_out("rows without times", here());
    if (length && *length < 0) return builder_.leave_out("rows that have not ended", here());
    if (!end || *end > kFurthestTime_ns) return builder_.leave_out("rows without an end", here());
    builder_.add(builder_.name(name(), ""), source(), *begin, *end);
  }

  /// Rows of one lane nest by name.
  void read_event() {
    const std::optional<std::int64_t> at = time(begin_);
    if (!at) return builder_.leave_out("rows without times", here());
    const std::uint32_t name_index = builder_.name(name(), "");
    std::vector<std::int64_t>& begins = open_[{fmt::format("{},{}", table_.cell(process_), table_.cell(lane_)), name_index}];
    if (open_.size() > kMostNames) return builder_.fail(fmt::format("more than {} lanes and names", kMostNames));
    const std::string_view event = table_.cell(event_);
    if (event == "Enter") {
      if (++entered_ > kMostIntervals) return builder_.fail(fmt::format("more than {} intervals", kMostIntervals));
      begins.push_back(*at);
    } else if (event != "Leave") {
      builder_.leave_out("rows that neither enter nor leave", here());
    } else if (begins.empty()) {
      builder_.leave_out("rows that leave what was not entered", here());
    } else {
      builder_.add(name_index, source(), begins.back(), *at);
      begins.pop_back();
    }
  }

  CsvTable& table_;
  ProfileBuilder& builder_;
  std::optional<std::size_t> name_, begin_, end_, duration_, process_, lane_, event_;
  std::int64_t unit_ns_;
  std::map<std::pair<std::string, std::uint32_t>, std::vector<std::int64_t>> open_;  ///< by lane and name
  std::size_t entered_ = 0;
};

}  // namespace

bool is_interval_csv(std::string_view first_bytes) { return layout_of(csv_header(first_bytes)) != nullptr; }

void read_interval_csv(ProfileInput& input, const ProfileOptions& options, ProfileBuilder& builder) {
  CsvTable table(input.bytes);
  const bool named = !options.columns.begin.empty();
  const Layout* const known = named ? nullptr : layout_of(table.header());
  const std::optional<Layout> layout = known != nullptr ? *known : layout_of(options.columns, table, builder);
  if (!layout) return;
  builder.profile().format = layout->title;
  builder.profile().time_base =
      fmt::format("{}, as the {} of its columns says", layout->unit, named ? "unit given" : "header");
  RowReader(table, *layout, builder).read_all();
}

}  // namespace evenstep::internal
