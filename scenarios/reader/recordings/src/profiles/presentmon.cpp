// PresentMon's three encodings of a capture. A row is a picture; rows of several processes and swap chains are mixed, in no
// order. What a row says of the GPU is turned into the interval in which it drew the picture:
//   default and --v2_metrics   begin = CPU start + GPU latency, end = begin + GPU time
//   --v1_metrics               begin = present + time until render start, end = present + time until render complete
// QPC ticks are taken to be 100 ns (10 MHz); the times between rows must agree.
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "decimal_time.h"
#include "profile_formats.h"

namespace evenstep::internal {
namespace {

constexpr std::int64_t kMs = 1'000'000, kTick = 100, kSecond = 1'000'000'000;

std::string lower(std::string_view text) {
  std::string all;
  for (const char c : text) all += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return all;
}

/// A column, whatever its case, and the unit of its times.
struct TimeColumn {
  std::optional<std::size_t> index;
  std::int64_t unit_ns = kMs;
};

class PresentMonReader {
 public:
  PresentMonReader(CsvTable& table, ProfileBuilder& builder) : table_(table), builder_(builder) {
    for (const std::string& column : table.header()) columns_.push_back(lower(column));
  }

  void read() {
    if (!find_columns()) return;
    while (!builder_.failed() && table_.next()) read_row();
    if (!table_.error().empty()) builder_.fail(table_.error());
    check_ticks();
  }

 private:
  std::optional<std::size_t> column(std::initializer_list<const char*> names) const {
    for (const char* const name : names) {
      const auto found = std::find(columns_.begin(), columns_.end(), name);
      if (found != columns_.end()) return static_cast<std::size_t>(found - columns_.begin());
    }
    return std::nullopt;
  }
  std::optional<std::int64_t> time(const TimeColumn& column) const {
    return decimal_time_ns(table_.cell(column.index), column.unit_ns);
  }

  bool find_columns();
  bool find_v1();
  void read_row();
  void add_picture(std::uint32_t source, std::int64_t start_ns);
  void compare(std::uint32_t source, std::int64_t start_ns);
  void check_ticks();

  CsvTable& table_;
  ProfileBuilder& builder_;
  std::vector<std::string> columns_;
  TimeColumn start_, begin_, end_, period_;
  bool end_from_begin_ = true;      ///< `end_` counts from the picture's begin, not from `start_`
  bool period_of_this_row_ = true;  ///< `period_` is the time to the next row, not from the last one
  std::map<std::uint32_t, std::pair<std::int64_t, std::int64_t>> last_;  ///< of a source: start and period
  std::map<std::uint32_t, std::int64_t> done_;                           ///< of a source: end of its last picture
  std::int64_t agree_ = 0, compared_ = 0;
};

bool PresentMonReader::find_v1() {
  start_ = {column({"qpctime"}), kTick};
  if (!start_.index) start_ = {column({"timeinseconds"}), kSecond};
  begin_ = {column({"msuntilrenderstart"})};
  end_ = {column({"msuntilrendercomplete"})};
  period_ = {column({"msbetweenpresents"})};
  end_from_begin_ = period_of_this_row_ = false;
  return start_.index && end_.index;
}

bool PresentMonReader::find_columns() {
  begin_ = {column({"msgpulatency", "gpulatency"})};
  end_ = {column({"msgputime", "gputime"})};
  start_ = {column({"cpustartqpc"}), kTick};
  if (!start_.index) start_ = {column({"cpustarttime", "cpustartqpctime"}), kMs};
  const bool v2 = column({"gpulatency"}).has_value();
  period_ = {column({v2 ? "frametime" : "msbetweenappstart"})};
  if (start_.index && begin_.index && end_.index) {
    builder_.profile().format = v2 ? "PresentMon CSV (v2 metrics)" : "PresentMon CSV";
  } else if (find_v1()) {
    builder_.profile().format = "PresentMon CSV (v1 metrics)";
  } else {
    builder_.fail(
        fmt::format("a CSV of PresentMon without the times of each picture (CPUStartQPC or CPUStartTime, MsGPULatency, "
                    "MsGPUTime; or TimeInSeconds and MsUntilRenderComplete); it has {}",
                    table_.columns_text()),
        table_.line(), 1);
    return false;
  }
  const std::string_view unit = start_.unit_ns == kTick ? "QPC ticks of 10 MHz" : start_.unit_ns == kMs ? "ms" : "s";
  builder_.profile().time_base = fmt::format("{} and ms", unit);
  if (!begin_.index)
    builder_.profile().time_base +=
        "; no begin of the GPU's work: it is taken to begin at the present, or when the picture before it was done";
  builder_.profile().only_visualizations = true;
  return true;
}

void PresentMonReader::read_row() {
  const std::string here = fmt::format("line {}", table_.line());
  const std::string_view type = table_.cell(column({"frametype"}));
  if (!type.empty() && type != "Application" && type != "NA")
    return builder_.leave_out("pictures that a driver or display made up", here);
  const std::optional<std::int64_t> start = time(start_);
  if (!start) return builder_.leave_out("rows without a time", here);
  const std::uint32_t source =
      builder_.source(fmt::format("{}, process {}, swap chain {}", table_.cell(column({"application"})),
                                  table_.cell(column({"processid"})), table_.cell(column({"swapchainaddress"}))));
  compare(source, *start);
  add_picture(source, *start);
}

void PresentMonReader::add_picture(std::uint32_t source, std::int64_t start_ns) {
  const std::string here = fmt::format("line {}", table_.line());
  const std::optional<std::int64_t> after = begin_.index ? time(begin_) : 0;
  const std::optional<std::int64_t> length = time(end_);
  if (!after || !length) return builder_.leave_out("pictures without times of the GPU", here);
  std::int64_t begin_ns = start_ns + *after;
  if (!begin_.index && done_.contains(source)) begin_ns = std::max(begin_ns, done_[source]);
  if (begin_ns > kFurthestTime_ns || begin_ns < -kFurthestTime_ns || *length > kFurthestTime_ns / 2 ||
      *length < -kFurthestTime_ns / 2)
    return builder_.leave_out("rows without a time", here);
  const std::int64_t end_ns = *length + (end_from_begin_ ? begin_ns : start_ns);
  if (end_ns > kFurthestTime_ns) return builder_.leave_out("rows without a time", here);
  done_[source] = end_ns;
  builder_.add(builder_.name(table_.cell(column({"application"})), "frame"), source, begin_ns, end_ns);
}

/// Whether the time from one row to the next is what the row says, within 1 %: then the unit of the start is right.
void PresentMonReader::compare(std::uint32_t source, std::int64_t start_ns) {
  const std::optional<std::int64_t> period = period_.index ? time(period_) : std::nullopt;
  const auto [last, is_first] = last_.try_emplace(source, start_ns, period.value_or(0));
  if (is_first) return;
  const std::int64_t said = period_of_this_row_ ? last->second.second : period.value_or(0);
  const std::int64_t gap = start_ns - last->second.first;
  last->second = {start_ns, period.value_or(0)};
  if (said <= 0 || gap <= 0) return;
  ++compared_;
  agree_ += std::abs(gap - said) <= said / 100 + 1000;
}

void PresentMonReader::check_ticks() {
  if (compared_ == 0 || builder_.failed()) return;
  builder_.profile().time_base += fmt::format("; {} of {} times between rows agree", agree_, compared_);
  if (start_.unit_ns == kTick && 2 * agree_ < compared_)
    builder_.fail("its QPC ticks are not those of 10 MHz; record with --qpc_time_ms, which writes milliseconds");
}

}  // namespace

bool is_presentmon(std::string_view first_bytes) {
  for (const std::string& column : csv_header(first_bytes)) {
    if (lower(column) == "swapchainaddress") return true;
  }
  return false;
}

void read_presentmon(ProfileInput& input, const ProfileOptions&, ProfileBuilder& builder) {
  CsvTable table(input.bytes);
  PresentMonReader(table, builder).read();
}

}  // namespace evenstep::internal
