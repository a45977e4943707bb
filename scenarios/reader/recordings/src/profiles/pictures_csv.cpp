// CSV with a row for each picture: PresentMon and what has its columns (FrameView, OCAT, CapFrameX), MangoHud. Rows of
// several processes and swap chains are mixed, in no order. What a row says is turned into the interval in which the GPU
// drew the picture; what comes first of these decides:
//   - CPU start, GPU latency, GPU time: begin = CPU start + latency, end = begin + time;
//   - present, render complete: begin = present + render start, or when the picture before was done, end = present + render
//     complete;
//   - present, time since the one before, or CPU start, time to the next one: the whole frame, because nothing says how long
//     the GPU drew.
// A column may be in several units (QPC ticks, taken to be 100 ns, or ms; ms or us): the times between the first rows tell.
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "column_names.h"
#include "decimal_time.h"
#include "profile_formats.h"

namespace evenstep::internal {
namespace {

enum class GpuTimes { from_cpu_start, from_present, whole_frames };

std::optional<std::int64_t> instant_ns(const CsvTable& table, const Column& column) {
  const std::string_view cell = table.cell(column.index);
  return cell.find(':') != std::string_view::npos ? date_time_ns(cell)
                                                  : decimal_time_ns(table.number(column.index), column.unit_ns);
}

/// Compares the times between the rows of a source with those that the rows say.
class PeriodCheck {
 public:
  /// `said_next`: a row says how long it is to the next one of its source, not from the last one.
  explicit PeriodCheck(bool said_next) : said_next_(said_next) {}

  void add(const std::string& source, std::int64_t start_ns, std::int64_t period_ns) {
    const auto [last, is_first] = last_.try_emplace(source, start_ns, period_ns);
    if (is_first) return;
    const std::int64_t said = said_next_ ? last->second.second : period_ns;
    const std::int64_t gap = start_ns - last->second.first;
    last->second = {start_ns, period_ns};
    if (said <= 0 || gap <= 0) return;
    ++compared;
    agree += std::abs(gap - said) <= said / 100 + 1000;
    roughly += std::abs(gap - said) <= said / 4;
    gaps_us += gap / 1000;
  }

  std::int64_t compared = 0, agree = 0, roughly = 0;  ///< within 1 % and a microsecond, within a quarter
  std::int64_t gaps_us = 0;                           ///< in all, in microseconds

 private:
  bool said_next_;
  std::map<std::string, std::pair<std::int64_t, std::int64_t>> last_;  ///< of a source: start and period
};

class PictureReader {
 public:
  PictureReader(ProfileInput& input, CsvTable& table, ProfileBuilder& builder)
      : input_(input), table_(table), builder_(builder), check_(false) {}

  void read() {
    if (!find_columns()) return;
    choose_units();
    check_ = PeriodCheck(from_cpu_start_);
    describe();
    while (!builder_.failed() && table_.next()) read_row();
    if (!table_.error().empty()) builder_.fail(table_.error());
    if (table_.rows_of_others() > 0)
      builder_.leave_out("rows of another recording behind the first one", "", false, table_.rows_of_others());
    if (!builder_.failed()) judge();
  }

 private:
  std::vector<Column> all(Quantity quantity) const { return columns_for(table_.header(), quantity); }
  std::optional<Column> find(Quantity quantity) const { return column_for(table_.header(), quantity); }
  static std::string_view cell(const CsvTable& table, const std::optional<Column>& column) {
    return column ? table.cell(column->index) : std::string_view();
  }
  std::optional<std::int64_t> length_ns(const CsvTable& table, const std::optional<Column>& column) const {
    if (!column) return std::nullopt;
    const std::optional<std::int64_t> ns = decimal_time_ns(table.number(column->index), column->unit_ns);
    return ns && std::abs(*ns) <= kFurthestTime_ns / 4 ? ns : std::nullopt;
  }
  std::string source_of(const CsvTable& table) const;
  bool find_columns();
  void choose_units();
  void describe();
  void read_row();
  void add_picture(std::uint32_t track, std::int64_t start_ns);
  void judge();

  ProfileInput& input_;
  CsvTable& table_;
  ProfileBuilder& builder_;
  PeriodCheck check_;
  GpuTimes times_ = GpuTimes::whole_frames;
  bool from_cpu_start_ = false;  ///< `start_` is when the program begins a picture, not when it hands it over
  std::optional<Column> start_, period_, latency_, gpu_time_, render_start_, render_end_;
  std::optional<Column> application_, process_, swap_chain_, type_;
  std::map<std::uint32_t, std::int64_t> done_;  ///< of a track: end of its last picture
  std::int64_t drawn_ = 0, pictures_ = 0;
};

std::string PictureReader::source_of(const CsvTable& table) const {
  if (!application_ && !process_ && !swap_chain_) return "";
  return fmt::format("{}, process {}, swap chain {}", cell(table, application_), cell(table, process_),
                     cell(table, swap_chain_));
}

bool PictureReader::find_columns() {
  application_ = find(Quantity::application);
  process_ = find(Quantity::process_id);
  swap_chain_ = find(Quantity::swap_chain);
  type_ = find(Quantity::frame_type);
  latency_ = find(Quantity::gpu_latency);
  gpu_time_ = find(Quantity::gpu_time);
  render_start_ = find(Quantity::render_start);
  render_end_ = find(Quantity::render_end);
  const bool cpu = find(Quantity::cpu_start).has_value(), present = find(Quantity::present).has_value();
  from_cpu_start_ = true;
  if (cpu && latency_ && gpu_time_) {
    times_ = GpuTimes::from_cpu_start;
  } else if (present && render_end_) {
    times_ = GpuTimes::from_present;
    from_cpu_start_ = false;
  } else if (present && find(Quantity::from_last)) {
    from_cpu_start_ = false;
  } else if (!cpu || !find(Quantity::to_next)) {
    builder_.fail(
        fmt::format(
            "is a CSV without the times of each picture (an instant, such as CPUStartTime, TimeInMs or elapsed, and a "
            "length, such as MsGPUTime, MsBetweenPresents or frametime); it has {}",
            table_.columns_text()),
        table_.line(), 1);
    return false;
  }
  return true;
}

/// Of all meanings of the columns with the instant and the period those that agree on most of the first rows.
void PictureReader::choose_units() {
  const std::vector<Column> starts = all(from_cpu_start_ ? Quantity::cpu_start : Quantity::present);
  std::vector<Column> periods = all(from_cpu_start_ ? Quantity::to_next : Quantity::from_last);
  start_ = starts.front();
  if (periods.empty()) return;
  period_ = periods.front();
  std::int64_t most = 0;
  for (const Column& start : starts) {
    for (const Column& period : periods) {
      const std::unique_ptr<Bytes> bytes = bytes_of_memory(input_.first);
      CsvTable first(*bytes, input_.head);
      PeriodCheck check(from_cpu_start_);
      for (int row = 0; row < 500 && first.next(); ++row) {
        const std::optional<std::int64_t> at = instant_ns(first, start);
        if (at) check.add(source_of(first), *at, length_ns(first, period).value_or(0));
      }
      if (check.roughly <= most) continue;
      most = check.roughly;
      start_ = start;
      period_ = period;
    }
  }
}

void PictureReader::describe() {
  Profile& profile = builder_.profile();
  const std::string_view tool = start_->known->tool;
  profile.format = !tool.empty() ? std::string(tool) : swap_chain_ ? "PresentMon CSV" : "CSV of pictures";
  if (times_ == GpuTimes::from_present) profile.format += ", or FrameView or OCAT";
  const std::int64_t unit = start_->unit_ns;
  profile.time_base = fmt::format("{} and ms", unit == 100 ? "QPC ticks of 10 MHz" : time_unit_text(unit));
  if (period_ && period_->unit_ns == 1000) profile.time_base += ", frame times in us";
  if (times_ == GpuTimes::from_present && !render_start_)
    profile.time_base +=
        "; no begin of the GPU's work: it is taken to begin at the present, or when the picture before it was done";
  if (times_ == GpuTimes::whole_frames)
    profile.time_base +=
        "; nothing says how long the GPU drew (PresentMon does, without --no_track_gpu and --no_track_display): a "
        "picture is taken to last its whole frame";
  profile.only_visualizations = true;
  profile.whole_frames = times_ == GpuTimes::whole_frames;
}

void PictureReader::read_row() {
  const std::string here = fmt::format("line {}", table_.line());
  const std::string_view type = cell(table_, type_);
  if (!type.empty() && type != "Application" && type != "NA")
    return builder_.leave_out("pictures that a driver or display made up", here, true);
  const std::optional<std::int64_t> start = instant_ns(table_, *start_);
  if (!start || std::abs(*start) > kFurthestTime_ns / 2) return builder_.leave_out("rows without a time", here);
  const std::string source = source_of(table_);
  check_.add(source, *start, length_ns(table_, period_).value_or(0));
  add_picture(builder_.track(source), *start);
}

void PictureReader::add_picture(std::uint32_t track, std::int64_t start_ns) {
  const std::string here = fmt::format("line {}", table_.line());
  std::optional<std::int64_t> begin, end;
  if (times_ == GpuTimes::from_cpu_start) {
    const std::optional<std::int64_t> latency = length_ns(table_, latency_), time = length_ns(table_, gpu_time_);
    if (latency) begin = start_ns + *latency;
    if (begin && time) end = *begin + *time;
  } else if (times_ == GpuTimes::from_present) {
    const std::optional<std::int64_t> until = length_ns(table_, render_end_);
    const std::optional<std::int64_t> after = render_start_ ? length_ns(table_, render_start_) : 0;
    if (after) begin = start_ns + *after;
    if (begin && !render_start_ && done_.contains(track)) begin = std::max(*begin, done_[track]);
    if (until) end = start_ns + *until;
  } else if (const std::optional<std::int64_t> period = length_ns(table_, period_); period && *period > 0) {
    begin = from_cpu_start_ ? start_ns : start_ns - *period;
    end = *begin + *period;
  }
  if (!begin || !end)
    return builder_.leave_out(
        times_ == GpuTimes::whole_frames ? "pictures without a frame time" : "pictures without times of the GPU", here);
  done_[track] = *end;
  drawn_ += *end > *begin;
  ++pictures_;
  const std::string_view application = cell(table_, application_);
  builder_.add(builder_.name(application_ ? application : "picture", "frame"), track, *begin, *end);
}

/// Whether the times between the rows are what the rows say.
void PictureReader::judge() {
  if (pictures_ > 0 && drawn_ == 0)
    return builder_.fail("the GPU's times of all its pictures are 0; record without --no_track_gpu and --no_track_display");
  if (check_.compared == 0) return;
  builder_.profile().time_base += fmt::format("; {} of {} times between rows agree", check_.agree, check_.compared);
  if (start_->unit_ns == 100 && 2 * check_.agree < check_.compared)
    builder_.fail("its QPC ticks are not those of 10 MHz; record with --qpc_time_ms, which writes milliseconds");
  else if (times_ == GpuTimes::whole_frames && 2 * check_.roughly < check_.compared)
    builder_.fail(fmt::format(
        "is a log of samples, one about every {:.3g} ms, not a recording of pictures: only {} of {} times between "
        "its rows are the frame time that the row has; log each picture (MangoHud: log_interval=0)",
        static_cast<double>(check_.gaps_us) / 1000.0 / static_cast<double>(check_.compared), check_.roughly,
        check_.compared));
}

}  // namespace

bool is_pictures_csv(const ProfileInput& input) { return are_pictures(input.head.cells); }

void read_pictures_csv(ProfileInput& input, const ProfileOptions&, ProfileBuilder& builder) {
  CsvTable table(input.bytes, input.head);
  PictureReader(input, table, builder).read();
}

}  // namespace evenstep::internal
