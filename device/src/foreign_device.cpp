#include "evenstep/device/foreign_device.h"

namespace evenstep {

glm::dvec3 SimulatedGrip::hand_m() {
  if (!hand_) return position_m(motion_, clock_.now());
  if (has_let_go_) return last_m_;
  try {
    return last_m_ = hand_->position_m(clock_.now());
  } catch (const HandDiverged&) {
    has_let_go_ = true;
    throw;
  }
}

void SimulatedGrip::drive(const glm::dvec3& force_N) {
  const RealTime now = clock_.now();
  log_.heard(now);
  log_.render(now, force_N);
  force_N_ = force_N;
  if (hand_ && !has_let_go_) hand_->feel(now + force_delay_, force_N);
}

MotorState SimulatedGrip::motors() {
  hand_m();
  log_.until(clock_.now());
  MotorState state;
  state.force_N = force_N_;
  log_.tell(state);
  return state;
}

}  // namespace evenstep
