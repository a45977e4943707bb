#include "evenstep/scheduler/event.h"

#include <algorithm>
#include <tuple>

namespace evenstep {

std::uint64_t chain(const std::vector<Event>& events) {
  std::uint64_t hash = 0;
  for (const Event& event : events) hash = chain(hash, event);
  return hash;
}

std::vector<Event> merge(const std::vector<Event>& a, const std::vector<Event>& b) {
  std::vector<Event> merged;
  merged.reserve(a.size() + b.size());
  EventMerge merging([&](const Event& event) { merged.push_back(event); });
  merging.add_a(a, RealTime{INT64_MIN});
  merging.add_b(b, RealTime{INT64_MIN});
  merging.finish();
  return merged;
}

void EventMerge::take_front(Log& log) {
  take_(log.events.front());
  log.events.pop_front();
}

/// Compares the two front events, as a scheduler does when it takes its next event. std::merge would not do, because a log
/// need not be sorted: a device event at t may ask for a completion at t.
void EventMerge::add(Log& log, std::span<const Event> events, RealTime until) {
  log.events.insert(log.events.end(), events.begin(), events.end());
  log.until = std::max(log.until, until);
  while (!a_.events.empty() && !b_.events.empty()) {
    const Event &a = a_.events.front(), &b = b_.events.front();
    take_front(std::tie(b.time, b.lane) < std::tie(a.time, a.lane) ? b_ : a_);
  }
  while (b_.events.empty() && !a_.events.empty() && a_.events.front().time < b_.until) take_front(a_);
  while (a_.events.empty() && !b_.events.empty() && b_.events.front().time < a_.until) take_front(b_);
}

void EventMerge::finish() {
  while (!a_.events.empty()) take_front(a_);
  while (!b_.events.empty()) take_front(b_);
}

}  // namespace evenstep
