#pragma once
/// The number of iterations per substep of the methods that iterate.

#include "evenstep/sim/scene.h"

namespace evenstep::internal {

/// TissueScene::iterations, or the method's default if that is 0; 0 for methods that do not iterate.
constexpr int iterations_of(const TissueScene& scene) {
  const bool given = scene.iterations > 0;
  switch (scene.method) {
    case Method::implicit_euler:
      return given ? scene.iterations : 20;
    case Method::implicit_midpoint:
      return given ? scene.iterations : 40;
    case Method::vertex_block_descent:
      return given ? scene.iterations : 10;
    default:
      return 0;
  }
}

}  // namespace evenstep::internal
