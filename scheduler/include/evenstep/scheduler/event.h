#pragma once
/// One event of a run, and the log from which the trace hash, events.bin and `evenstep diff` are made.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "evenstep/scheduler/lane.h"
#include "evenstep/time/digest.h"
#include "evenstep/time/time.h"

namespace evenstep {

/// A name with static storage (a string literal): event names are part of the trace hash and of `events.<lane>.<name>`.
struct EventName {
  const char* text = "";
  std::uint64_t digest = 0;
  consteval EventName(const char* literal) : text(literal), digest(name_digest(literal)) {}
  constexpr EventName() = default;
};

struct Event {
  RealTime time;               ///< the key time: scheduled for a timer, the stamp for a completion
  Lane lane = Lane::completion;
  EventName name;
  std::uint64_t payload = 0;   ///< digest of what the event saw and made (Scheduler::note)
};

/// h(i) = mix over (time, lane, name, payload) of event i, chained from h(i-1); h(-1) = 0.
constexpr std::uint64_t chain(std::uint64_t previous, const Event& event) {
  return mix(mix(mix(mix(previous, static_cast<std::uint64_t>(event.time.ns)), static_cast<std::uint64_t>(event.lane)),
                 event.name.digest), event.payload);
}
std::uint64_t chain(const std::vector<Event>& events);

/// The one order of two schedulers' events (lanes on two threads): by (time, lane), then `a` before `b`, each log's own
/// order kept. Where the two never share a lane this is the order one scheduler would have run them in.
std::vector<Event> merge(const std::vector<Event>& a, const std::vector<Event>& b);

}  // namespace evenstep
