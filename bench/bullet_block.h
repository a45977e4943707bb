#pragma once
/// The same block as a Bullet soft body: the position-based solver that game and haptic projects reach for.

#include <memory>

#include "evenstep/sim/scene.h"

namespace evenstep::bench {

/// Particles, masses and springs of the scene, the fixed ones of no mass; the first tool's particles follow it. No gravity,
/// no collision, stiffness factor 1 (Bullet's stiffness is iterations times step length, not N/m). Its step gives no force.
class BulletBlock {
 public:
  BulletBlock(const TissueScene& scene, double step_s, int iterations);
  ~BulletBlock();
  void step(double offset_m);  ///< of the tool along x, from rest

 private:
  struct World;
  std::unique_ptr<World> world_;
};

}  // namespace evenstep::bench
