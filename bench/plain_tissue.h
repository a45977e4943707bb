#pragma once
/// The yardstick of the solvers: the substep of the tissue as one would write it by hand, as one loop over arrays, in float.
/// It has the arithmetic and the order of summation of the solvers, so that its forces are theirs bit by bit. One tool, one
/// substep per step.

#include <array>
#include <cstddef>
#include <vector>

#include "evenstep/sim/scene.h"

namespace evenstep::bench {

struct PlainConstants {
  static constexpr int kNeighbours = 18;
  std::array<std::ptrdiff_t, kNeighbours> offset{};  // offsets to the cells of the neighbours
  std::array<std::array<float, 3>, kNeighbours> rest_m{};
  std::array<float, kNeighbours> length_m{};
  float step_s = 0, acceleration = 0, decay = 0, stiffness = 0;
};

class PlainTissue {
 public:
  explicit PlainTissue(const TissueScene& scene, double step_s, int threads);
  /// Moves the tool to `offset_m` from rest. Returns the force on the hand in newtons.
  std::array<double, 3> step(const std::array<double, 3>& offset_m);

 private:
  struct Field {
    std::vector<float> x, y, z;
  };
  void advance(std::ptrdiff_t begin, std::ptrdiff_t end);

  int threads_;
  double step_s_;
  PlainConstants constants_;
  std::ptrdiff_t first_ = 0, end_ = 0;  // cells that can be particles
  Field now_, next_, velocity_;
  std::vector<float> active_, mobile_;
  std::vector<std::ptrdiff_t> grabbed_;
  std::array<double, 3> tool_m_{};
};

/// A cost that no arrangement of the loop can undercut: a square root and a division for each of the 18 springs of every
/// cell that the solver visits, with data in the cache and in vectors.
class DivideAndRootFloor {
 public:
  explicit DivideAndRootFloor(const TissueScene& scene);
  void step();

 private:
  std::vector<float> squares_, sums_;
};

}  // namespace evenstep::bench
