#include "src/undelayed.h"

#include <algorithm>
#include <cmath>

#include "src/judged.h"
#include "src/vec3.h"

namespace evenstep::internal {
namespace {

constexpr Duration kAroundStop{100'000'000};  // error_at_stop: 0.2 s around the stop
constexpr double kFelt_N = 1e-6;              // the least force that a report in whole micronewtons can contain

struct Touch {
  const TickRow* sent = nullptr;
  const TickRow* due = nullptr;
};

/// The first tick that sends a force, and the first that should have; neither if judging begins in contact.
Touch first_touch(const DeviceRecord& device, const Rows<std::size_t>& ticks) {
  Touch touch;
  if (norm(*device.ticks[ticks.front()].undelayed_N) >= kFelt_N) return touch;
  for (const std::size_t k : ticks) {
    const TickRow& tick = device.ticks[k];
    if (!touch.sent && norm(tick.force_N) >= kFelt_N) touch.sent = &tick;
    if (!touch.due && norm(*tick.undelayed_N) >= kFelt_N) touch.due = &tick;
  }
  return touch;
}

}  // namespace

std::map<std::string, double> undelayed_values(const DeviceRecord& device, const Rows<std::size_t>& ticks,
                                               std::optional<RealTime> stop) {
  std::map<std::string, double> values;
  if (ticks.empty() || !device.ticks[ticks.front()].undelayed_N) return values;
  Peak worst, at_stop, ghost;
  double error_squares = 0, force_squares = 0;
  bool touched = false, near_stop = false;
  for (const std::size_t k : ticks) {
    const TickRow& tick = device.ticks[k];
    const double due_N = norm(*tick.undelayed_N), error_N = norm(minus(tick.force_N, *tick.undelayed_N));
    worst.add(error_N);
    error_squares += error_N * error_N;
    force_squares += due_N * due_N;
    touched |= due_N >= kFelt_N;
    if (touched && due_N < kFelt_N) ghost.add(norm(tick.force_N));
    if (!stop || sent_at(tick) < *stop - kAroundStop || sent_at(tick) > *stop + kAroundStop) continue;
    at_stop.add(error_N);
    near_stop = true;
  }
  const double count = static_cast<double>(ticks.size());
  values["error_max"] = worst.value;
  values["error_rms"] = std::sqrt(error_squares / count);
  if (force_squares > 0) values["error_share"] = std::sqrt(error_squares / force_squares);
  if (near_stop) values["error_at_stop"] = at_stop.value;
  if (touched) values["ghost_force"] = ghost.value;
  const Touch touch = first_touch(device, ticks);
  if (touch.sent && touch.due)
    values["onset_delay"] = static_cast<double>((sent_at(*touch.sent) - sent_at(*touch.due)).ns) / 1e9;
  return values;
}

}  // namespace evenstep::internal
