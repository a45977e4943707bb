#pragma once
/// The same block as a Bullet soft body, the position-based solver that game and haptic projects often use.

#include <memory>

#include "evenstep/sim/scene.h"

namespace evenstep::bench {

/// The particles, masses and springs of the scene. Fixed particles have no mass, and those of the first tool follow it.
/// There is no gravity and no collision, and the stiffness factor is 1 (Bullet's stiffness is iterations times step length,
/// not N/m). A step gives no force.
class BulletBlock {
 public:
  BulletBlock(const TissueScene& scene, double step_s, int iterations);
  ~BulletBlock();
  void step(double offset_m);  ///< the offset of the tool along x from rest

 private:
  struct World;
  std::unique_ptr<World> world_;
};

}  // namespace evenstep::bench
