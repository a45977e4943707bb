#include "evenstep/device/hid/simulated_motors.h"

#include <algorithm>

namespace evenstep {

void MotorLog::until(RealTime at) {
  if (force_N_ > 0) unrenewed_ = std::max(unrenewed_, at - since_);
}

void MotorLog::heard(RealTime at) {
  until(at);
  since_ = at;
}

void MotorLog::render(RealTime at, double force_N) {
  until(at);
  if (force_N_ == 0) since_ = at;
  force_N_ = force_N;
  largest_N_ = std::max(largest_N_, force_N);
}

}  // namespace evenstep
