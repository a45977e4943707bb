#pragma once
/// The largest stable stiffness of a scene in a hand that feels it, per strategy. `evenstep study` finds it if a scenario
/// has a [study] stiffness_limit. Definitions: docs/forces/study.md.

#include <cstdint>
#include <string>
#include <vector>

namespace evenstep {

struct StiffnessLimit {
  std::string strategy;
  /// found: between `stable` and `unstable`. below: unstable even where the search begins. above: stable up to its end.
  enum class State : std::uint8_t { found, below, above } state = State::found;
  double stable_N_per_m = 0;    ///< the largest that was stable; 0: none (below)
  double unstable_N_per_m = 0;  ///< the least that was not; 0: none (above)
  double latency_s = 0;         ///< L of the strategy's map; 0 without one
  int runs = 0;
};
const char* name_of(StiffnessLimit::State state);

struct StiffnessLimits {
  std::string scenario, file, version;
  double from_N_per_m = 0, to_N_per_m = 0;
  std::uint64_t seed = 1;
  int seeds = 1;
  std::vector<StiffnessLimit> limits;
  bool interrupted = false;  ///< interrupted, so strategies are missing
};

std::string stiffness_table(const StiffnessLimits& study);
/// strategy,state,stable_N_per_m,unstable_N_per_m,latency_s,runs
std::string stiffness_csv(const StiffnessLimits& study);
std::string stiffness_json(const StiffnessLimits& study);

}  // namespace evenstep
