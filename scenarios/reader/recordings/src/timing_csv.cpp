#include "evenstep/recordings/timing_csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <sstream>

#include "evenstep/text/csv_rows.h"
#include "evenstep/text/text_file.h"

namespace evenstep {
namespace {

using internal::CsvRows;

constexpr std::string_view kHeader = "segment,kind,index,begin_ns,end_ns";
constexpr std::string_view kClockedHeader = "segment,kind,index,begin_ns,end_ns,simulated_ns";
enum Column : std::size_t { kSegment, kKind, kIndex, kBegin, kEnd, kSimulated };
constexpr std::int64_t kLongest_ns = 1'000'000'000'000'000;  // 1e6 s, the limit for every time that a user gives
/// A clock may have its zero anywhere, also within the recording. So far either way (127 years) no difference of two times
/// overflows.
constexpr std::int64_t kFurthest_ns = 4'000'000'000'000'000'000;
constexpr std::string_view kTooLong = "the recording is longer than 1e6 s; are these nanoseconds?";

struct Row {
  std::int64_t segment = 0, index = 0;
  std::string_view kind;
  Interval interval;
  std::optional<SimTime> simulated;
};

/// The state of reading: what the rows so far have said.
struct State {
  std::vector<SegmentTiming>& segments;
  std::int64_t number = -1;                       ///< of the open segment, as written
  std::int64_t step_index = -1, idle_index = -1;  ///< last ones of the open segment
  bool only_idle = true;                          ///< so far in the open segment
  bool is_given = false;                          ///< a row says where the open segment begins and ends
  RealTime last_step_end{-kFurthest_ns}, last_visualization_end{-kFurthest_ns};
  std::optional<SimTime> first_simulated, last_simulated;
};

bool take_interval(CsvRows& rows, Interval& interval) {
  return rows.take_signed(interval.begin.ns) && rows.take_signed(interval.end.ns) && rows.row_done();
}

/// The interval of a split row, whose begin is in this cell and whose end is in the next one.
bool read_interval(CsvRows& rows, std::size_t begin, Interval& interval) {
  return rows.whole(begin, interval.begin.ns, -kFurthest_ns, kFurthest_ns) &&
         rows.whole(begin + 1, interval.end.ns, -kFurthest_ns, kFurthest_ns);
}

bool read_cells(CsvRows& rows, Row& row, bool clocked) {
  if (!rows.split(clocked ? 6 : 5)) return false;
  row.kind = rows.cell(kKind);
  row.simulated.reset();
  if (clocked && !rows.cell(kSimulated).empty() &&
      !rows.whole(kSimulated, row.simulated.emplace().ns, -kFurthest_ns, kFurthest_ns))
    return false;
  return rows.whole(kSegment, row.segment) && rows.whole(kIndex, row.index) && read_interval(rows, kBegin, row.interval);
}

bool read_row(CsvRows& rows, Row& row, bool clocked) {
  const bool quickly = !clocked && rows.take_whole(row.segment) && rows.take_word(row.kind) && rows.take_whole(row.index) &&
                       take_interval(rows, row.interval);
  if (!quickly && !read_cells(rows, row, clocked)) return false;
  if (row.interval.end >= row.interval.begin) return true;
  rows.error(kEnd, fmt::format("ends at {} ns, before it begins at {} ns", row.interval.end.ns, row.interval.begin.ns));
  return false;
}

/// Opens the row's segment if it is not the open one.
bool open_segment(CsvRows& rows, const Row& row, State& state) {
  if (row.segment == state.number) return true;
  if (state.number >= 0 && row.segment != state.number + 1) {
    rows.error(kSegment,
               fmt::format("segment {} follows segment {}; segments are numbered one by one", row.segment, state.number));
    return false;
  }
  SegmentTiming segment;
  segment.index = static_cast<std::int64_t>(state.segments.size());
  segment.begin = row.interval.begin;
  segment.end = row.interval.end;
  if (!state.segments.empty()) segment.steps.reserve(state.segments.back().steps.size());
  state.segments.push_back(std::move(segment));
  state.number = row.segment;
  state.step_index = state.idle_index = -1;
  state.only_idle = true;
  state.is_given = false;
  return true;
}

bool increasing(CsvRows& rows, std::int64_t index, std::int64_t& last) {
  if (index > last) {
    last = index;
    return true;
  }
  rows.error(kIndex, fmt::format("index {} follows {} in the same segment", index, last));
  return false;
}

bool not_before(CsvRows& rows, std::size_t cell, Interval interval, RealTime& last_end, std::string_view what) {
  if (interval.begin < last_end) {
    rows.error(cell,
               fmt::format("begins at {} ns, before the {} before it ended at {} ns", interval.begin.ns, what, last_end.ns));
    return false;
  }
  last_end = interval.end;
  return true;
}

/// Widens begin and end of the open segment to include a visualization or a step.
void widen(SegmentTiming& segment, const Interval& interval, State& state) {
  if (state.is_given) return;
  segment.begin = state.only_idle ? interval.begin : std::min(segment.begin, interval.begin);
  state.only_idle = false;
}

bool add_simulated(CsvRows& rows, const Row& row, State& state) {
  if (!row.simulated) return rows.error(kSimulated, "a step has its own simulation time here, in whole ns"), false;
  if (row.simulated < state.last_simulated) {
    rows.error(kSimulated, fmt::format("simulation time {} ns follows {} ns", row.simulated->ns, state.last_simulated->ns));
    return false;
  }
  if (!state.first_simulated) state.first_simulated = row.simulated;
  if (row.simulated->ns - state.first_simulated->ns > kLongest_ns)
    return rows.error(kSimulated, std::string(kTooLong)), false;
  state.last_simulated = row.simulated;
  state.segments.back().simulated.push_back(*row.simulated);
  return true;
}

void add_row(CsvRows& rows, const Row& row, State& state, bool clocked) {
  const bool is_first = row.segment != state.number;
  if (!open_segment(rows, row, state)) return;
  SegmentTiming& segment = state.segments.back();
  if (state.is_given && row.interval.begin < segment.begin) {
    return rows.error(
        kBegin, fmt::format("begins at {} ns, before its segment begins at {} ns", row.interval.begin.ns, segment.begin.ns));
  }
  if (row.kind == "segment") {
    if (!is_first || row.index != 0) return rows.error(kKind, "a segment has one row 'segment', its first, of index 0");
    state.is_given = true;
  } else if (row.kind == "step") {
    if (!increasing(rows, row.index, state.step_index)) return;
    if (!not_before(rows, kBegin, row.interval, state.last_step_end, "step")) return;
    segment.steps.push_back(row.interval);
    widen(segment, row.interval, state);
    if (clocked && !add_simulated(rows, row, state)) return;
  } else if (row.kind == "idle") {
    if (!increasing(rows, row.index, state.idle_index)) return;
  } else if (row.kind == "visualization") {
    if (segment.visualization || row.index != 0) return rows.error(kIndex, "a segment has one visualization, of index 0");
    if (!not_before(rows, kBegin, row.interval, state.last_visualization_end, "visualization")) return;
    segment.visualization = row.interval;
    widen(segment, row.interval, state);
  } else {
    return rows.error(kKind, fmt::format("kind '{}' must be segment, visualization, step or idle", row.kind));
  }
  segment.end = std::max(segment.end, row.interval.end);
  if (state.segments.size() > 1) {
    // One from which a governor has left everything out takes no time.
    const SegmentTiming& before = state.segments[state.segments.size() - 2];
    const bool is_nothing = before.steps.empty() && !before.visualization && before.end == before.begin;
    if (segment.begin < before.begin || (segment.begin == before.begin && !is_nothing)) {
      rows.error(kBegin,
                 fmt::format("segment {} begins at {} ns, not after the segment before it", row.segment, segment.begin.ns));
    }
  }
  if (segment.end - state.segments.front().begin > Duration{kLongest_ns}) rows.error(kBegin, std::string(kTooLong));
}

void shift(Interval& interval, Duration by) {
  interval.begin = interval.begin - by;
  interval.end = interval.end - by;
}

void shift_to_zero(std::vector<SegmentTiming>& segments) {
  if (segments.empty()) return;
  const Duration origin = segments.front().begin - RealTime{};
  if (origin == Duration{}) return;
  for (SegmentTiming& segment : segments) {
    segment.begin = segment.begin - origin;
    segment.end = segment.end - origin;
    if (segment.visualization) shift(*segment.visualization, origin);
    for (Interval& step : segment.steps) shift(step, origin);
  }
}

constexpr std::string_view kStepsHeader = "begin_ns,end_ns";

bool read_step(CsvRows& rows, Row& row) {
  const bool fine = take_interval(rows, row.interval) || (rows.split(2) && read_interval(rows, 0, row.interval));
  if (!fine) return false;
  if (row.interval.end >= row.interval.begin) return true;
  rows.error(1, fmt::format("ends at {} ns, before it begins at {} ns", row.interval.end.ns, row.interval.begin.ns));
  return false;
}

/// Reads a plain list of steps, whose header has been read.
void read_steps(CsvRows& rows, std::vector<SegmentTiming>& segments) {
  State state{segments};
  Row row;
  while (rows.next()) {
    if (!read_step(rows, row) || !open_segment(rows, row, state)) continue;
    if (!not_before(rows, 0, row.interval, state.last_step_end, "step")) continue;
    SegmentTiming& segment = segments.front();
    segment.steps.push_back(row.interval);
    segment.end = row.interval.end;
    if (segment.end - segment.begin > Duration{kLongest_ns}) rows.error(0, std::string(kTooLong));
  }
}

void read_rows(CsvRows& rows, bool steps_too, std::vector<SegmentTiming>& segments) {
  if (steps_too && rows.begins_with(kStepsHeader)) {
    rows.header(kStepsHeader);
    return read_steps(rows, segments);
  }
  const bool clocked = rows.begins_with(kClockedHeader);
  if (!rows.header(clocked ? kClockedHeader : kHeader)) return;
  State state{segments};
  Row row;
  while (rows.next()) {
    if (read_row(rows, row, clocked)) add_row(rows, row, state, clocked);
  }
}

/// `errors`: where `rows` writes them.
TimingCsv read(CsvRows rows, const std::string& name, bool steps_too, std::vector<Diagnostic>& errors) {
  std::vector<SegmentTiming> segments;
  read_rows(rows, steps_too, segments);
  if (segments.empty() && errors.empty()) errors.push_back({name, 1, 1, "no rows"});
  if (!errors.empty()) return Failure(std::move(errors));
  shift_to_zero(segments);
  return segments;
}

TimingCsv parse(const std::string& text, const std::string& name, bool steps_too) {
  std::vector<Diagnostic> errors;
  return read(CsvRows(text, name, errors), name, steps_too, errors);
}

TimingCsv read_file(const std::string& path, bool steps_too) {
  std::vector<Diagnostic> errors;
  internal::TextPieces pieces(path, internal::kMostCsvBytes);
  TimingCsv csv = read(CsvRows([&] { return pieces.next(); }, path, errors), path, steps_too, errors);
  if (!pieces.error().empty()) return Failure(std::vector<Diagnostic>{{path, 0, 0, pieces.error()}});
  return csv;
}

/// Where the segment begins for a reader of its visualization, steps and idle rest alone; empty if it has none of them.
std::optional<RealTime> begin_by_rows(const SegmentTiming& segment) {
  std::optional<RealTime> begin;
  if (!segment.steps.empty()) begin = segment.steps.front().begin;
  if (segment.visualization) begin = std::min(begin.value_or(segment.visualization->begin), segment.visualization->begin);
  if (!begin && segment.begin < segment.end) begin = segment.begin;  // its idle row
  return begin;
}

}  // namespace

TimingCsv parse_timing_csv(const std::string& text, const std::string& name) { return parse(text, name, false); }
TimingCsv parse_timing_or_steps(const std::string& text, const std::string& name) { return parse(text, name, true); }
TimingCsv read_timing_csv(const std::string& path) { return read_file(path, false); }
TimingCsv read_timing_or_steps(const std::string& path) { return read_file(path, true); }

void write_timing_csv(std::ostream& out, const std::function<const SegmentTiming*()>& next, bool with_simulated) {
  out << (with_simulated ? kClockedHeader : kHeader) << '\n';
  const auto row = [&](std::int64_t segment, std::string_view kind, std::size_t index, RealTime begin, RealTime end,
                       std::optional<SimTime> simulated = {}) {
    out << fmt::format("{},{},{},{},{}", segment, kind, index, begin.ns, end.ns);
    if (with_simulated) out << (simulated ? fmt::format(",{}", simulated->ns) : ",");
    out << '\n';
  };
  while (const SegmentTiming* at = next()) {
    const SegmentTiming& segment = *at;
    if (begin_by_rows(segment) != segment.begin) row(segment.index, "segment", 0, segment.begin, segment.end);
    RealTime busy = segment.begin;
    const auto show = [&] {
      row(segment.index, "visualization", 0, segment.visualization->begin, segment.visualization->end);
      busy = std::max(busy, segment.visualization->end);
    };
    bool shown = !segment.visualization;
    for (std::size_t i = 0; i < segment.steps.size(); ++i) {
      const Interval& step = segment.steps[i];
      if (!shown && segment.visualization->begin <= step.begin) {
        show();
        shown = true;
      }
      row(segment.index, "step", i, step.begin, step.end, segment.simulated_at(step));
      busy = std::max(busy, step.end);
    }
    if (!shown) show();
    if (busy < segment.end) row(segment.index, "idle", 0, busy, segment.end);
  }
}

Duration usual_step_size(const std::vector<SegmentTiming>& segments) {
  std::vector<std::int64_t> sizes;
  std::optional<SimTime> before;
  for (const SegmentTiming& segment : segments) {
    for (const SimTime t : segment.simulated) {
      if (before) sizes.push_back(t.ns - before->ns);
      before = t;
    }
  }
  if (sizes.empty()) return {};
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return {*middle};
}

std::string format_timing_csv(const std::vector<SegmentTiming>& segments) {
  std::ostringstream csv;
  std::size_t at = 0;
  const auto has_clock = [](const SegmentTiming& segment) { return !segment.simulated.empty(); };
  write_timing_csv(
      csv, [&] { return at < segments.size() ? &segments[at++] : nullptr; },
      std::any_of(segments.begin(), segments.end(), has_clock));
  return std::move(csv).str();
}

}  // namespace evenstep
