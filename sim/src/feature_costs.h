#pragma once
/// What each feature would add to the CPU time of a substep with symplectic Euler, percent: `scripts/bench.sh features` on
/// 20,270 particles, PoCL's basic driver, the machine of docs/performance.md. Costs below 1 % are below what can be measured.

#include <array>

namespace evenstep::internal {

struct FeatureCost {
  const char* feature;
  int cpu_percent, opencl_percent;
};

inline constexpr std::array kFeatureCosts{
    FeatureCost{"regions", 0, 0},         FeatureCost{"damping", 0, 0},         FeatureCost{"axial damping", 0, 0},
    FeatureCost{"gravity", 0, 0},         FeatureCost{"fixed particles", 0, 0}, FeatureCost{"tools", 0, 0},
    FeatureCost{"second tool", 0, 0},     FeatureCost{"grab", 0, 0},            FeatureCost{"spring coupling", 0, 0},
    FeatureCost{"probe", 0, 0},           FeatureCost{"local model", 0, 0},     FeatureCost{"variable step", 0, 0},
    FeatureCost{"energy", 0, 0},          FeatureCost{"state digest", 0, 0},
};

}  // namespace evenstep::internal
