#pragma once
/// What each feature would add to the CPU time of a substep with symplectic Euler, in percent: `scripts/bench.sh features`
/// with 20,270 particles and PoCL's basic driver on the machine of docs/performance.md. Costs below 1 % are too small to be
/// measured.

#include <array>

namespace evenstep::internal {

struct FeatureCost {
  const char* feature;
  int cpu_percent, opencl_percent;
};

inline constexpr std::array kFeatureCosts{
    FeatureCost{"regions", 12, 14},       FeatureCost{"damping", 0, 0},
    FeatureCost{"axial damping", 54, 53}, FeatureCost{"gravity", 1, 0},
    FeatureCost{"fixed particles", 0, 0}, FeatureCost{"tools", 1, 2},
    FeatureCost{"second tool", 1, 0},     FeatureCost{"grab", 2, 0},
    FeatureCost{"spring coupling", 5, 3}, FeatureCost{"probe", 14, 81},
    FeatureCost{"local model", 1, 2},     FeatureCost{"variable step", 0, 1},
    FeatureCost{"energy", 68, 64},        FeatureCost{"state digest", 36, 37},
};

}  // namespace evenstep::internal
