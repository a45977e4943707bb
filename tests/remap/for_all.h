#pragma once
/// Checks properties over many random schedules. A property returns what is wrong, or nullptr. The first failure is shrunk
/// to the fewest segments that still fail, and printed with its seed.

#include <sstream>

#include "cases.h"
#include "catch.h"
#include "schedules.h"

namespace evenstep::testing {

constexpr std::uint64_t kMany = 100'000;
constexpr std::uint64_t kVeryMany = 1'000'000;

/// Shrinks a schedule so that it ends with the first failing segment and begins as late as possible.
template <class Fails>
Schedule shrunk(Schedule schedule, Fails fails) {
  for (std::size_t count = 1; count < schedule.size(); ++count) {
    const Schedule prefix(schedule.begin(), schedule.begin() + static_cast<std::ptrdiff_t>(count));
    if (!fails(prefix)) continue;
    schedule = prefix;
    break;
  }
  while (schedule.size() > 1) {
    const Schedule later(schedule.begin() + 1, schedule.end());
    if (!fails(later)) break;
    schedule = later;
  }
  return schedule;
}

inline std::string written(const Schedule& schedule) {
  std::ostringstream text;
  for (const Segment& segment : schedule) {
    text << "\n  segment at " << segment.begin.ns << ", steps [begin, end):";
    for (const StepTimes& step : segment.steps) text << " [" << step.begin.ns << ", " << step.end.ns << ")";
  }
  return text.str();
}

/// `property(schedule, draw)`: draw is for what the property chooses itself, the same on every call. Normal runs take
/// the seeds from 0 on, [million] runs those from 2^32 on.
template <class Property>
void for_all(std::uint64_t count, Property property) {
  const std::uint64_t first = count == kVeryMany ? 1ULL << 32 : 0;
  for (std::uint64_t seed = first; seed < first + share_of(count); ++seed) {
    Draw draw(seed);
    const Schedule schedule = random_schedule(draw, draw.between(2, 5));
    const Draw choices(mix(seed, std::uint64_t{1}));
    const char* wrong = property(schedule, choices);
    if (wrong == nullptr) continue;
    const Schedule least = shrunk(schedule, [&](const Schedule& s) { return property(s, choices) != nullptr; });
    FAIL("seed " << seed << ": " << property(least, choices) << written(least));
  }
}

/// The same for properties that need no schedule: `property(draw)`.
template <class Property>
void for_all_draws(std::uint64_t count, Property property) {
  const std::uint64_t first = count == kVeryMany ? 1ULL << 32 : 0;
  for (std::uint64_t seed = first; seed < first + share_of(count); ++seed) {
    const char* wrong = property(Draw(seed));
    if (wrong != nullptr) FAIL("seed " << seed << ": " << wrong);
  }
}

}  // namespace evenstep::testing
