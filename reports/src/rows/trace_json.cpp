#include "evenstep/reports/trace_json.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include "evenstep/reports/json.h"
#include "src/judged.h"
#include "writers/texts/text.h"

namespace evenstep {
namespace {

// Tracks of a strategy; a device has two more.
constexpr int kSegments = 1, kVisualization = 2, kSteps = 3, kSlots = 4, kFirstDevice = 10, kPerDevice = 2;

int ticks_track(std::size_t device) { return kFirstDevice + kPerDevice * static_cast<int>(device); }
int forces_track(std::size_t device) { return ticks_track(device) + 1; }

/// Microseconds: "12.345".
std::string us(std::int64_t ns) {
  const std::uint64_t size = ns < 0 ? -static_cast<std::uint64_t>(ns) : static_cast<std::uint64_t>(ns);
  return fmt::format("{}{}.{:03}", ns < 0 ? "-" : "", size / 1000, size % 1000);
}
std::string us(RealTime t) { return us(t.ns); }

std::string quoted(const std::string& text) { return json_text(Json(text)); }

class Events {
 public:
  explicit Events(std::ostream& out) : out_(out) { out_ << "{\"displayTimeUnit\":\"ms\",\"traceEvents\":["; }
  ~Events() { out_ << "\n]}\n"; }
  Events(const Events&) = delete;
  Events& operator=(const Events&) = delete;

  void start_strategy(const std::string& name) {
    ++pid_;
    put("\"ph\":\"M\",\"pid\":{},\"name\":\"process_name\",\"args\":{{\"name\":{}}}", pid_, quoted(name));
    put("\"ph\":\"M\",\"pid\":{0},\"name\":\"process_sort_index\",\"args\":{{\"sort_index\":{0}}}", pid_);
  }
  void track(int tid, const std::string& name) {
    put("\"ph\":\"M\",\"pid\":{},\"tid\":{},\"name\":\"thread_name\",\"args\":{{\"name\":{}}}", pid_, tid, quoted(name));
    put("\"ph\":\"M\",\"pid\":{0},\"tid\":{1},\"name\":\"thread_sort_index\",\"args\":{{\"sort_index\":{1}}}", pid_, tid);
  }
  void slice(int tid, const char* name, std::int64_t index, RealTime from, RealTime to) {
    put("\"ph\":\"X\",\"pid\":{},\"tid\":{},\"ts\":{},\"dur\":{},\"name\":\"{} {}\"", pid_, tid, us(from),
        us((to - from).ns), name, index);
  }
  /// `values` as JSON: "x":1.
  void counter(const std::string& name, RealTime at, const std::string& values) {
    put("\"ph\":\"C\",\"pid\":{},\"ts\":{},\"name\":{},\"args\":{{{}}}", pid_, us(at), name, values);
  }
  /// A point of a flow: 's' its start, 't' a step, 'f' its end. It belongs to the slice of the track at this time.
  void flow(char phase, std::int64_t id, int tid, RealTime at) {
    put("\"ph\":\"{}\",\"pid\":{},\"tid\":{},\"ts\":{},\"id\":{},\"cat\":\"path\",\"name\":\"path of a sample\"{}", phase,
        pid_, tid, us(at), id, phase == 's' ? "" : ",\"bp\":\"e\"");
  }

 private:
  template <class... Values>
  void put(fmt::format_string<Values...> text, Values&&... values) {
    out_ << (first_ ? "\n{" : ",\n{");
    first_ = false;
    internal::print(out_, text, std::forward<Values>(values)...);
    out_ << '}';
  }
  std::ostream& out_;
  int pid_ = 0;
  bool first_ = true;
};

/// Where each of the slices that begin at these times ends: where the next one begins, and the last one at `end`. A slice
/// that begins after a later one (the map stepped back) has no length, so that no two slices overlap in part.
Rows<RealTime> ends_of(Rows<RealTime> begins, RealTime end) {
  RealTime next = end;
  for (std::size_t i = begins.size(); i-- > 0;) {
    const RealTime begin = begins[i];
    begins[i] = std::max(begin, next);
    next = std::min(next, begin);
  }
  return begins;
}

template <class Row, class Begin>
Rows<RealTime> ends_of(const Rows<Row>& rows, RealTime end, Begin begin) {
  Rows<RealTime> begins(rows.get_allocator());
  for (const Row& row : rows) begins.push_back(begin(row));
  return ends_of(std::move(begins), end);
}

/// When the force of a step can first be felt.
RealTime ready(const StepRow& step) { return std::max(step.emission, step.end + step.transport); }

class Strategy {
 public:
  Strategy(const RunRecord& run, const StrategyRecord& strategy, Events& events, std::int64_t& flows)
      : strategy_(strategy), end_(run.nominal.end), events_(events), flows_(flows) {}

  void write() {
    events_.start_strategy(strategy_.name);
    write_segments();
    write_steps();
    for (std::size_t device = 0; device < strategy_.devices.size(); ++device) {
      write_ticks(device);
      write_forces(device);
      write_buffers(strategy_.devices[device]);
      for (std::size_t n = 0; n < strategy_.steps.size(); ++n) write_path(device, n);
    }
  }

 private:
  void write_segments() {
    events_.track(kSegments, "segments");
    events_.track(kVisualization, "visualization");
    const Rows<RealTime> ends = ends_of(strategy_.segments, end_, [](const SegmentRow& row) { return row.begin; });
    for (std::size_t i = 0; i < strategy_.segments.size(); ++i) {
      const SegmentRow& row = strategy_.segments[i];
      events_.slice(kSegments, "segment", row.index, row.begin, std::min(std::max(row.end, row.begin), ends[i]));
    }
    RealTime busy = RealTime{INT64_MIN};
    for (const SegmentRow& row : strategy_.segments) {
      if (!row.visualization) continue;
      const auto [begin, end] = *row.visualization;
      if (begin < busy || end < begin) continue;  // not on one lane
      events_.slice(kVisualization, "visualization", row.index, begin, end);
      busy = end;
    }
  }

  void write_steps() {
    events_.track(kSteps, "steps");
    events_.track(kSlots, "slots, at the time that the step reads");
    const Rows<RealTime> ends = ends_of(strategy_.steps, end_, [](const StepRow& row) { return row.read; });
    for (std::size_t n = 0; n < strategy_.steps.size(); ++n) {
      const StepRow& step = strategy_.steps[n];
      events_.slice(kSteps, "step", static_cast<std::int64_t>(n), step.begin, step.end);
      if (step.mapped) events_.slice(kSlots, "slot", static_cast<std::int64_t>(n), step.read, ends[n]);
    }
  }

  void write_ticks(std::size_t index) {
    const DeviceRecord& device = strategy_.devices[index];
    events_.track(ticks_track(index), device.name + ": ticks");
    const std::string force = quoted(device.name + " force, N"), position = quoted(device.name + " position, m");
    const Rows<RealTime> ends = ends_of(device.ticks, end_, internal::sent_at);
    for (std::size_t k = 0; k < device.ticks.size(); ++k) {
      const TickRow& tick = device.ticks[k];
      const RealTime at = internal::sent_at(tick);
      events_.slice(ticks_track(index), "tick", static_cast<std::int64_t>(k), at, ends[k]);
      vector_counter(position, at, tick.position_m);
      vector_counter(force, at, tick.force_N);
    }
  }

  void vector_counter(const std::string& name, RealTime at, const Vec3& v) {
    if (!std::isfinite(v[0]) || !std::isfinite(v[1]) || !std::isfinite(v[2])) return;  // JSON has no such number
    events_.counter(name, at, fmt::format("\"x\":{},\"y\":{},\"z\":{}", v[0], v[1], v[2]));
  }

  void write_forces(std::size_t index) {
    events_.track(forces_track(index), strategy_.devices[index].name + ": forces, from when they are felt");
    const Rows<RealTime> ends = ends_of(strategy_.steps, end_, ready);
    for (std::size_t n = 0; n < strategy_.steps.size(); ++n)
      events_.slice(forces_track(index), "force", static_cast<std::int64_t>(n), ready(strategy_.steps[n]), ends[n]);
  }

  /// When each step begins, how many samples are newer than the one it reads; when it ends, how many forces wait for their
  /// time, its own included.
  void write_buffers(const DeviceRecord& device) {
    const std::string samples = quoted(device.name + " interaction buffer: newer samples");
    const std::string forces = quoted(device.name + " force schedule: waiting");
    std::size_t sent = 0;
    for (std::size_t n = 0; n < strategy_.steps.size(); ++n) {
      const StepRow& step = strategy_.steps[n];
      const auto newer = ticks_until(device, step.begin) - ticks_until(device, std::min(step.read, step.begin));
      events_.counter(samples, step.begin, fmt::format("\"count\":{}", newer));
      while (sent <= n && strategy_.steps[sent].emission <= step.end) ++sent;
      events_.counter(forces, step.end, fmt::format("\"count\":{}", n + 1 - sent));
    }
  }

  /// The number of ticks up to this instant.
  static std::ptrdiff_t ticks_until(const DeviceRecord& device, RealTime at) {
    const auto later = std::upper_bound(device.ticks.begin(), device.ticks.end(), at,
                                        [](RealTime t, const TickRow& tick) { return t < internal::sent_at(tick); });
    return later - device.ticks.begin();
  }

  /// From the sample before R(n) to the slot, the step and the force. A read that lies after the begin of its step
  /// (`predict`) is not shown on the way.
  void write_path(std::size_t index, std::size_t n) {
    const StepRow& step = strategy_.steps[n];
    const DeviceRecord& device = strategy_.devices[index];
    const bool by_slot = step.mapped && step.read <= step.begin;
    const std::ptrdiff_t ticks = ticks_until(device, by_slot ? step.read : step.begin);
    const std::int64_t id = ++flows_;
    char phase = 's';
    const auto station = [&](int track, RealTime at) {
      events_.flow(phase, id, track, at);
      phase = 't';
    };
    if (ticks > 0) station(ticks_track(index), internal::sent_at(device.ticks[static_cast<std::size_t>(ticks - 1)]));
    if (by_slot) station(kSlots, step.read);
    station(kSteps, step.begin);
    events_.flow('f', id, forces_track(index), ready(step));
  }

  const StrategyRecord& strategy_;
  RealTime end_;
  Events& events_;
  std::int64_t& flows_;
};

}  // namespace

void trace_json(const RunRecord& run, std::ostream& out) {
  Events events(out);
  std::int64_t flows = 0;
  for (const StrategyRecord& strategy : run.strategies) Strategy(run, strategy, events, flows).write();
}

}  // namespace evenstep
