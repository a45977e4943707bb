#include "evenstep/scheduler/event.h"

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
  // Compares the two front events, as a scheduler does when it takes its next event. std::merge would not do, because a log
  // need not be sorted: a device event at t may ask for a completion at t.
  auto from_a = a.begin();
  auto from_b = b.begin();
  while (from_a != a.end() && from_b != b.end()) {
    const bool b_first = std::tie(from_b->time, from_b->lane) < std::tie(from_a->time, from_a->lane);
    merged.push_back(b_first ? *from_b++ : *from_a++);
  }
  merged.insert(merged.end(), from_a, a.end());
  merged.insert(merged.end(), from_b, b.end());
  return merged;
}

}  // namespace evenstep
