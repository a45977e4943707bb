#pragma once
/// What is really done during a visualization on a wall clock: [timing] visualization = "render" or "burn 11.1 ms".

#include <memory>
#include <string>

#include "evenstep/format/scenario.h"
#include "evenstep/harness/watched_solver.h"
#include "evenstep/loop/haptic_loop.h"
#include "evenstep/reports/run_record.h"

namespace evenstep {

class RealVisualization : public Visualization {
 public:
  /// "the tissue is drawn, 800 x 600 pixels, by llvmpipe (...)"
  virtual const std::string& text() const = 0;
  /// What was drawn last, as PNG; empty if nothing is drawn or it cannot be packed.
  virtual std::string png() { return {}; }
};

/// Ready to run: libraries are loaded, kernels and shaders compiled, and it has run once. A drawing reads `solver` between
/// two of its steps; `solver` must outlive the result. Null if nothing is done in that time. Throws RunFailure if this
/// machine cannot do it.
std::unique_ptr<RealVisualization> make_visualization(const Scenario& scenario, WatchedSolver& solver);

/// The scene's tissue as SVG, in the pose that `solver` has kept, with a sentence that says what it shows. Empty if there is
/// no such pose.
TissuePicture picture_of(const Scenario& scenario, const WatchedSolver& solver);
/// How many steps lie between two of the poses that picture_of chooses from: as many as fit in a thirtieth of a second. 0:
/// the scene cannot be drawn.
std::int64_t steps_between_poses(const Scene& scene);

}  // namespace evenstep
