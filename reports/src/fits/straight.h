#pragma once
/// Which samples lie on a straight piece of a programmed motion (Nominal::Turns): docs/reference/metrics.md, "Straight
/// pieces".

#include <cstdint>
#include <span>
#include <vector>

#include "evenstep/reports/run_record.h"
#include "src/fits/line_fit.h"

namespace evenstep::internal {

/// For each tick of a device, the last step whose force can be sent: E(n) and F(n) are not after the tick. -1 before the
/// first.
Rows<std::int64_t> sent_steps(const StrategyRecord& strategy, const DeviceRecord& device);

/// The judged samples, by their place among `steps` or `ticks`, as runs of neighbours on one straight piece. Without turns
/// (or `nominal`), all samples are one run.
std::vector<Window> straight_steps(const StrategyRecord& strategy, const Nominal::Device* nominal,
                                   std::span<const std::size_t> steps);
std::vector<Window> straight_ticks(const StrategyRecord& strategy, const DeviceRecord& device,
                                   const Nominal::Device* nominal, std::span<const std::size_t> ticks);

}  // namespace evenstep::internal
