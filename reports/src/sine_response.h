#pragma once
/// How the interaction and the force follow a hand that moves as a sine.

#include <optional>

#include "evenstep/reports/run_record.h"

namespace evenstep::internal {

struct SineResponse {
  std::optional<double> gain;          ///< 1: in full; none where nothing says how much force is expected
  double delay_s = 0, distortion = 0;  ///< as SineFit
};

/// nullopt: the motion is no sine, or nothing judged reads it. `steps`, `ticks`: what is judged.
std::optional<SineResponse> interaction_response(const RunRecord& run, const StrategyRecord& strategy,
                                                 const DeviceRecord& device, const std::vector<std::size_t>& steps);
std::optional<SineResponse> force_response(const RunRecord& run, const StrategyRecord& strategy, const DeviceRecord& device,
                                           const std::vector<std::size_t>& steps, const std::vector<std::size_t>& ticks);

}  // namespace evenstep::internal
