#pragma once
/// How the interaction and the force follow a hand that moves as a sine.

#include <optional>

#include "evenstep/reports/run_record.h"

namespace evenstep::internal {

struct SineResponse {
  std::optional<double> gain;          ///< 1 is the ideal; empty if it is not known how much force to expect
  double delay_s = 0, distortion = 0;  ///< as SineFit
};

/// Empty if the motion is not a sine, or if no judged step reads it. `steps` and `ticks` are the judged ones.
std::optional<SineResponse> interaction_response(const RunRecord& run, const StrategyRecord& strategy,
                                                 const DeviceRecord& device, const Rows<std::size_t>& steps);
std::optional<SineResponse> force_response(const RunRecord& run, const StrategyRecord& strategy, const DeviceRecord& device,
                                           const Rows<std::size_t>& steps, const Rows<std::size_t>& ticks);

}  // namespace evenstep::internal
