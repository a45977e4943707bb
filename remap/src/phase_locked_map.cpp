#include "evenstep/remap/phase_locked_map.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace evenstep {
namespace {

// Chosen by measurement on the recordings and on random schedules (docs/choose/numerics.md).
constexpr double kPull = 3;            // k N^: within a segment an error shrinks to e^-3 of its size
constexpr double kMostPull = 0.25;     // k
constexpr double kVelocityPull = 0.3;  // how much of the missing velocity a step makes up for; stable below 2
constexpr double kSlowest = 0.1;       // v / P > 0: the map is strictly monotone
constexpr double kFastest = 6;         // v / P
constexpr double kHang_segments = 4;   // a segment longer than this, and than H, says little about the pace
constexpr double kHungCounts_segments = 2;
constexpr double kStall_segments = 3;     // a segment longer than this says nothing about the usual places
constexpr double kStart_paces = 4;        // a first segment that took this much longer per step than the next is forgotten
constexpr double kLeastWeight = 1.0 / 8;  // of a segment in the usual places
constexpr double kFall = 0.9;             // if P falls below this share at one boundary, v falls with it
constexpr double kLeastPeriod_ns = 1.0;
constexpr double kMostPeriod_ns = 1e12;  // slots that advance by a tenth of it stay within the range of RealTime
// Rounded sums may put a slot slightly below a whole number of ns; it must not be floored to 1 ns less.
constexpr double kRounding_ns = 0x1p-10;

}  // namespace

void PhaseLockedMap::boundary(std::int64_t n, RealTime begin) {
  assert(!started_ || (n >= first_step_ && begin >= boundary_));
  const std::int64_t steps = started_ ? n - first_step_ : 0;
  if (steps == 0 && pace_ns_ > 0) return;
  if (steps > 0) learn(begin, steps);
  started_ = true;
  first_step_ = n;
  boundary_ = begin;
}

void PhaseLockedMap::learn(RealTime end, std::int64_t steps) {
  const double measured_ns = static_cast<double>((end - boundary_).ns);
  const double pace_before_ns = pace_ns_;
  if (past_.count == 1 && pace_ns_ > kStart_paces * measured_ns / static_cast<double>(steps)) forget_start();
  const bool acquiring = pace_ns_ == 0;
  const double mean_ns = past_.count == 0 ? measured_ns : past_.length_ns / past_.count;
  const bool hung = measured_ns > std::max(horizon_ns_, kHang_segments * mean_ns);
  const double length_ns = hung ? kHungCounts_segments * mean_ns : measured_ns;
  const double idle_ns = std::max(0.0, static_cast<double>((end - last_end_).ns));
  const double fade = horizon_ns_ / (horizon_ns_ + length_ns);
  past_ = {fade * past_.count + 1, fade * past_.length_ns + length_ns, fade * past_.steps + static_cast<double>(steps),
           fade * past_.idle_ns + idle_ns};
  pace_ns_ = std::clamp(past_.length_ns / past_.steps, kLeastPeriod_ns, kMostPeriod_ns);
  if (!hung && measured_ns <= kStall_segments * mean_ns) learn_places(length_ns, steps);
  if (acquiring) {
    // One pace further, the slot of the next step is the boundary.
    if (pace_before_ns > 0)  // there have been slots
      ahead_ns_ = std::max(0.0, static_cast<double>((origin_ - end).ns) + remainder_ns_ + ahead_ns_ + pace_ns_);
    velocity_ns_ = pace_ns_;
    origin_ = end;
    remainder_ns_ = -pace_ns_;
  } else if (pace_ns_ < kFall * pace_before_ns) {
    velocity_ns_ *= pace_ns_ / pace_before_ns;
  }
}

/// The past was a slow start: everything is acquired from the segment that ends now, as if it had been the first.
void PhaseLockedMap::forget_start() {
  past_ = {};
  known_ = 0;
  pace_ns_ = 0;
}

void PhaseLockedMap::learn_places(double length_ns, std::int64_t steps) {
  const double slot_ns = length_ns / static_cast<double>(steps);
  const std::size_t places = std::min(static_cast<std::size_t>(steps), kPlaces);
  const double weight = std::max(kLeastWeight, 1 / past_.count);
  for (std::size_t i = 0; i < places; ++i) {
    const double place_ns = begins_ns_[i] - static_cast<double>(i) * slot_ns;
    usual_ns_[i] = i < known_ ? usual_ns_[i] + weight * (place_ns - usual_ns_[i]) : place_ns;
  }
  known_ = std::max(known_, places);
}

double PhaseLockedMap::usual_ns(std::int64_t i) const {
  if (known_ == 0) return 0;
  const auto place = static_cast<std::size_t>(i);
  if (place < kPlaces) return usual_ns_[std::min(place, known_ - 1)];
  const double per_step_ns = (usual_ns_[known_ - 1] - usual_ns_[0]) / static_cast<double>(kPlaces - 1);
  return usual_ns_[0] + static_cast<double>(i) * per_step_ns;
}

void PhaseLockedMap::began(std::int64_t n, RealTime begin) {
  if (!started_) return;
  const std::int64_t i = n - first_step_;
  if (static_cast<std::size_t>(i) < kPlaces)
    begins_ns_[static_cast<std::size_t>(i)] = static_cast<double>((begin - boundary_).ns);
  if (pace_ns_ == 0) return;
  const double target_ns = this->target_ns(i, begin);
  const double error_ns = static_cast<double>((boundary_ - origin_).ns) + target_ns - remainder_ns_ - pace_ns_;
  if (error_ns > horizon_ns_) return step_over(target_ns, error_ns);
  if (runs_ahead_of_start(i, error_ns))
    velocity_ns_ = std::max(kSlowest * begun_pace_ns(i), kLeastPeriod_ns);
  else
    follow(error_ns);
  advance();
}

/// Where the slot of this step ought to be, measured from the boundary.
double PhaseLockedMap::target_ns(std::int64_t i, RealTime begin) const {
  const double even_ns = static_cast<double>(i) * pace_ns_;
  const double late_ns = static_cast<double>((begin - boundary_).ns) - even_ns - usual_ns(i);
  const double idle_ns = past_.idle_ns / past_.count;
  return even_ns + late_ns - std::clamp(late_ns, -idle_ns, idle_ns);
}

/// Used while the pace is known from one segment alone: whether that segment was a slow start (kernels compile), because
/// steps now come four times as fast and the slots are more than one of its steps ahead.
bool PhaseLockedMap::runs_ahead_of_start(std::int64_t i, double error_ns) const {
  return past_.count == 1 && i > 0 && error_ns < -pace_ns_ && begun_pace_ns(i) < pace_ns_ / kStart_paces;
}

/// The mean time from begin to begin of the steps of this segment up to step i > 0.
double PhaseLockedMap::begun_pace_ns(std::int64_t i) const {
  const std::size_t place = std::min(static_cast<std::size_t>(i), kPlaces - 1);
  return (begins_ns_[place] - begins_ns_[0]) / static_cast<double>(place);
}

double PhaseLockedMap::slowest_ns() const { return std::max(kSlowest * pace_ns_, kLeastPeriod_ns); }

void PhaseLockedMap::follow(double error_ns) {
  const double most_ns = jump_ * pace_ns_;
  const double pull = std::min(kPull * past_.count / past_.steps, kMostPull);
  const double bend_ns = most_ns / (pull * pull);  // beyond it, braking by a constant most_ns starts later than the pull
  const double size_ns = std::abs(error_ns);
  const double faster_ns = size_ns <= bend_ns ? pull * size_ns : std::sqrt(2 * most_ns * (size_ns - bend_ns / 2));
  const double slowest_ns = this->slowest_ns(), fastest_ns = kFastest * pace_ns_;
  const double wanted_ns = std::clamp(pace_ns_ + std::copysign(faster_ns, error_ns), slowest_ns, fastest_ns);
  velocity_ns_ = std::clamp(velocity_ns_, slowest_ns, fastest_ns);
  velocity_ns_ += std::clamp(kVelocityPull * (wanted_ns - velocity_ns_), -most_ns, most_ns);
}

void PhaseLockedMap::advance() {
  const double advanced_ns = remainder_ns_ + velocity_ns_;
  const double whole_ns = std::floor(advanced_ns);
  origin_ = origin_ + Duration{static_cast<std::int64_t>(whole_ns)};
  remainder_ns_ = advanced_ns - whole_ns;
  wait(velocity_ns_);
}

void PhaseLockedMap::step_over(double target_ns, double error_ns) {
  const double whole_ns = std::floor(target_ns);
  origin_ = boundary_ + Duration{static_cast<std::int64_t>(whole_ns)};
  remainder_ns_ = target_ns - whole_ns;
  velocity_ns_ = pace_ns_;
  wait(pace_ns_ + error_ns);
}

/// While R advances, slots that are ahead of it move on as slowly as they may.
void PhaseLockedMap::wait(double advanced_ns) {
  ahead_ns_ = std::max(0.0, ahead_ns_ - std::max(0.0, advanced_ns - slowest_ns()));
}

std::optional<RealTime> PhaseLockedMap::slot(std::int64_t) {
  if (pace_ns_ == 0) return std::nullopt;
  return origin_ + Duration{internal::floor_ns(remainder_ns_ + ahead_ns_ + kRounding_ns)};
}

}  // namespace evenstep
