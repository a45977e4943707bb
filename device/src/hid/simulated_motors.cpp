#include "evenstep/device/hid/simulated_motors.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace evenstep {

void MotorLog::until(RealTime at) {
  if (drives_) unrenewed_ = std::max(unrenewed_, at - since_);
}

void MotorLog::heard(RealTime at) {
  until(at);
  since_ = at;
}

void MotorLog::render(RealTime at, const glm::dvec3& force_N) {
  until(at);
  if (!drives_) since_ = at;
  const double length_N = glm::length(force_N);
  drives_ = length_N > 0;
  largest_N_ = std::max(largest_N_, length_N);
  largest_along_N_ = glm::max(largest_along_N_, glm::abs(force_N));
}

void MotorLog::lose(RealTime at) {
  render(at, glm::dvec3(0));
  asked_away_N_ = asked_away_N_.value_or(0);
}

void MotorLog::ask_away(const glm::dvec3& force_N) {
  asked_away_N_ = std::max(asked_away_N_.value_or(0), glm::length(force_N));
}

void MotorLog::tell(MotorState& state) const {
  state.largest_N = largest_N_;
  state.largest_along_N = largest_along_N_;
  state.unrenewed = unrenewed_;
  state.asked_away_N = asked_away_N_;
}

}  // namespace evenstep
