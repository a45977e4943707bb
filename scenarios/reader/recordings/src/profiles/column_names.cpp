#include "column_names.h"

#include <algorithm>
#include <utility>

#include "decimal_time.h"

namespace evenstep::internal {
namespace {

constexpr std::int64_t kNs = 1, kUs = 1000, kTick = 100, kMs = 1'000'000, kSecond = 1'000'000'000, kInBrackets = 0;

// Better names of a quantity come first. Whose they are is in docs/timings/recordings.md.
constexpr ColumnName kNames[] = {
    {Quantity::name, "kernel_name", 0, ""},
    {Quantity::name, "kernelname", 0, ""},
    {Quantity::name, "timername", 0, ""},
    {Quantity::name, "function", 0, ""},
    {Quantity::name, "direction", 0, ""},
    {Quantity::name, "name", 0, ""},
    {Quantity::begin, "start_timestamp", kNs, "rocprofv3 CSV"},
    {Quantity::begin, "beginns", kNs, "rocprof CSV"},
    {Quantity::begin, "ns_since_start", kNs, "Tracy CSV"},
    {Quantity::begin, "ts", kNs, "trace_processor CSV"},
    {Quantity::begin, "starttime", kSecond, "Unreal Insights CSV"},
    {Quantity::begin, "start", kInBrackets, ""},
    {Quantity::begin, "begin", kInBrackets, ""},
    {Quantity::begin, "beginn", kInBrackets, ""},
    {Quantity::begin, "timestamp", kInBrackets, ""},
    {Quantity::begin, "start_ns", kNs, ""},
    {Quantity::begin, "begin_ns", kNs, ""},
    {Quantity::end, "end_timestamp", kNs, ""},
    {Quantity::end, "endns", kNs, ""},
    {Quantity::end, "endtime", kSecond, ""},
    {Quantity::end, "end", kInBrackets, ""},
    {Quantity::end, "ende", kInBrackets, ""},
    {Quantity::end, "end_ns", kNs, ""},
    {Quantity::length, "exec_time_ns", kNs, ""},
    {Quantity::length, "dur", kNs, ""},
    {Quantity::length, "duration", kInBrackets, ""},
    {Quantity::length, "dauer", kInBrackets, ""},
    {Quantity::length, "duration_ns", kNs, ""},
    {Quantity::process, "agent_id", 0, ""},
    {Quantity::process, "gpu-id", 0, ""},
    {Quantity::process, "process", 0, ""},
    {Quantity::process, "process_id", 0, ""},
    {Quantity::process, "pid", 0, ""},
    {Quantity::process, "upid", 0, ""},
    {Quantity::queue, "queue_id", 0, ""},
    {Quantity::queue, "queue-id", 0, ""},
    {Quantity::thread, "thread_id", 0, ""},
    {Quantity::thread, "threadname", 0, ""},
    {Quantity::thread, "threadid", 0, ""},
    {Quantity::thread, "track_id", 0, ""},
    {Quantity::thread, "thread", 0, ""},
    {Quantity::thread, "tid", 0, ""},
    {Quantity::stream, "streamid", 0, ""},
    {Quantity::stream, "strm", 0, ""},
    {Quantity::event, "event type", 0, ""},
    {Quantity::category, "kind", 0, ""},
    {Quantity::category, "domain", 0, ""},
    {Quantity::application, "application", 0, ""},
    {Quantity::process_id, "processid", 0, ""},
    {Quantity::swap_chain, "swapchainaddress", 0, ""},
    {Quantity::frame_type, "frametype", 0, ""},
    {Quantity::cpu_start, "cpustartqpc", kTick, ""},
    {Quantity::cpu_start, "cpustarttimeinms", kMs, ""},
    {Quantity::cpu_start, "cpustartqpctimeinms", kMs, ""},
    {Quantity::cpu_start, "cpustartqpctime", kMs, ""},
    {Quantity::cpu_start, "cpustarttime", kMs, ""},
    {Quantity::cpu_start, "cpustarttime", kSecond, ""},
    {Quantity::cpu_start, "cpustarttimeinseconds", kSecond, ""},
    {Quantity::cpu_start, "cpustartdatetime", kSecond, ""},
    {Quantity::present, "qpctime", kTick, ""},
    {Quantity::present, "qpctime", kMs, ""},
    {Quantity::present, "qpctime", kSecond, ""},
    {Quantity::present, "timeinqpc", kTick, ""},
    {Quantity::present, "timeinms", kMs, ""},
    {Quantity::present, "timeinseconds", kSecond, ""},
    {Quantity::present, "timeindatetime", kSecond, ""},
    {Quantity::present, "elapsed", kNs, "MangoHud log"},
    {Quantity::gpu_latency, "msgpulatency", kMs, ""},
    {Quantity::gpu_latency, "gpulatency", kMs, ""},
    {Quantity::gpu_time, "msgputime", kMs, ""},
    {Quantity::gpu_time, "gputime", kMs, ""},
    {Quantity::render_start, "msuntilrenderstart", kMs, ""},
    {Quantity::render_end, "msuntilrendercomplete", kMs, ""},
    {Quantity::render_end, "msrenderpresentlatency", kMs, ""},
    {Quantity::to_next, "msbetweenappstart", kMs, ""},
    {Quantity::to_next, "frametime", kMs, ""},
    {Quantity::from_last, "msbetweenpresents", kMs, ""},
    {Quantity::from_last, "frametime", kMs, ""},
    {Quantity::from_last, "frametime", kUs, ""},
};

/// Columns that tell what a file is, where it is no recording.
struct Refused {
  const char* column;
  const char* why;
};
constexpr const char* kTotals =
    "it has totals of each name, not single intervals; export the trace instead of its statistics";
constexpr const char* kSamples = "it is a log of samples, taken at times of its own, not a recording of pictures";
constexpr Refused kRefused[] = {
    {"totaldurationns", kTotals},
    {"total time", kTotals},
    {"calls", kTotals},
    {"hardware monitoring log", kSamples},
    {"0.1% min fps", "it is MangoHud's summary; its log is the file without '_summary'"},
    {"framerate", kSamples},
    {"gpu temperature", kSamples},
};

/// A cell of a header without blanks around it, in lower case, and the unit behind it in brackets.
struct Plain {
  std::string text, unit;
};

Plain plain(std::string_view cell) {
  const auto trim = [&](std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t");
    return first == std::string_view::npos ? std::string_view()
                                           : text.substr(first, text.find_last_not_of(" \t") - first + 1);
  };
  Plain all;
  for (const char c : trim(cell)) all.text += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  const std::size_t open = all.text.find_last_of("([");
  if (open == std::string::npos || open == 0 || (!all.text.ends_with(')') && !all.text.ends_with(']'))) return all;
  all.unit = all.text.substr(open + 1, all.text.size() - open - 2);
  all.text = trim(std::string_view(all.text).substr(0, open));
  return all;
}

bool is_time(Quantity quantity) {
  switch (quantity) {
    case Quantity::begin:
    case Quantity::end:
    case Quantity::length:
    case Quantity::cpu_start:
    case Quantity::present:
    case Quantity::gpu_latency:
    case Quantity::gpu_time:
    case Quantity::render_start:
    case Quantity::render_end:
    case Quantity::to_next:
    case Quantity::from_last:
      return true;
    default:
      return false;
  }
}

}  // namespace

std::vector<Column> columns_for(const std::vector<std::string>& header, Quantity quantity) {
  std::vector<Plain> cells;
  for (const std::string& cell : header) cells.push_back(plain(cell));
  std::vector<Column> all;
  for (const ColumnName& known : kNames) {
    if (known.quantity != quantity) continue;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (cells[i].text != known.name) continue;
      const std::optional<std::int64_t> unit = time_unit_ns(cells[i].unit);
      if (!is_time(quantity) || unit || known.unit_ns != kInBrackets)
        all.push_back({i, is_time(quantity) ? unit.value_or(known.unit_ns) : 0, &known});
    }
  }
  return all;
}

std::optional<Column> column_for(const std::vector<std::string>& header, Quantity quantity) {
  const std::vector<Column> all = columns_for(header, quantity);
  return all.empty() ? std::nullopt : std::optional(all.front());
}

std::vector<Column> time_columns(const std::vector<std::string>& header) {
  std::vector<Column> all;
  std::optional<Quantity> last;  // the names of a quantity stand together
  for (const ColumnName& known : kNames) {
    if (!is_time(known.quantity) || std::exchange(last, known.quantity) == known.quantity) continue;
    for (const Column& column : columns_for(header, known.quantity)) all.push_back(column);
  }
  return all;
}

std::optional<std::size_t> index_of(const std::vector<std::string>& header, std::string_view name) {
  const auto found = std::find(header.begin(), header.end(), name);
  if (found == header.end()) return std::nullopt;
  return static_cast<std::size_t>(found - header.begin());
}

bool are_intervals(const std::vector<std::string>& header) {
  const auto has = [&](Quantity quantity) { return column_for(header, quantity).has_value(); };
  return has(Quantity::name) && has(Quantity::begin) &&
         (has(Quantity::end) || has(Quantity::length) || has(Quantity::event));
}

bool are_pictures(const std::vector<std::string>& header) {
  const auto has = [&](Quantity quantity) { return column_for(header, quantity).has_value(); };
  return has(Quantity::swap_chain) ||
         (has(Quantity::cpu_start) && (has(Quantity::to_next) || (has(Quantity::gpu_latency) && has(Quantity::gpu_time)))) ||
         (has(Quantity::present) && (has(Quantity::from_last) || has(Quantity::render_end)));
}

bool are_picture_lengths(const std::vector<std::string>& header) {
  return index_of(header, "FrameTime") && (index_of(header, "GameThreadTime") || index_of(header, "EVENTS"));
}

std::string_view why_refused(const std::vector<std::string>& header) {
  for (const Refused& one : kRefused) {
    for (const std::string& cell : header) {
      if (plain(cell).text.starts_with(one.column)) return one.why;
    }
  }
  return "";
}

}  // namespace evenstep::internal
