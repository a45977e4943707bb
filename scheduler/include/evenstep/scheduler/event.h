#pragma once
/// One event of a run. The log of these events is what the trace hash, events.bin and `evenstep diff` are made from.

#include <cstdint>
#include <deque>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "evenstep/scheduler/lane.h"
#include "evenstep/time/digest.h"
#include "evenstep/time/time.h"

namespace evenstep {

/// The name of an event, a string literal. It is part of the trace hash and of the metric `events.<lane>.<name>`.
struct EventName {
  const char* text = "";
  std::uint64_t digest = 0;
  consteval EventName(const char* literal) : text(literal), digest(name_digest(literal)) {}
  constexpr EventName() = default;
};

struct Event {
  RealTime time;  ///< the key time: for a timer its scheduled time, for a completion its stamp
  Lane lane = Lane::completion;
  EventName name;
  std::uint64_t payload = 0;  ///< digest of what the event read and produced (Scheduler::note)
};

/// h(i) = mix over (time, lane, name, payload) of event i, chained from h(i-1); h(-1) = 0.
constexpr std::uint64_t chain(std::uint64_t previous, const Event& event) {
  return mix(mix(mix(mix(previous, static_cast<std::uint64_t>(event.time.ns)), static_cast<std::uint64_t>(event.lane)),
                 event.name.digest),
             event.payload);
}
std::uint64_t chain(const std::vector<Event>& events);

/// Merges the events of two schedulers (lanes on two threads) into one log: by (time, lane), then `a` before `b`. The order
/// within each log is kept. If the two never share a lane, this is the order in which one scheduler would have run them.
std::vector<Event> merge(const std::vector<Event>& a, const std::vector<Event>& b);

/// The same while both logs grow: an event is passed on as soon as no event still to come can sort before it.
class EventMerge {
 public:
  explicit EventMerge(std::function<void(const Event&)> take) : take_(std::move(take)) {}
  /// Adds more events of a log; those still to come in that log have times of at least `until`.
  void add_a(std::span<const Event> events, RealTime until) { add(a_, events, until); }
  void add_b(std::span<const Event> events, RealTime until) { add(b_, events, until); }
  void finish();  ///< no more are to come
  std::size_t waiting() const { return a_.events.size() + b_.events.size(); }

 private:
  struct Log {
    std::deque<Event> events;
    RealTime until{INT64_MIN};
  };
  void add(Log& log, std::span<const Event> events, RealTime until);
  void take_front(Log& log);

  Log a_, b_;
  std::function<void(const Event&)> take_;
};

}  // namespace evenstep
