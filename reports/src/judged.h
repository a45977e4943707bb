#pragma once
/// The judged part of a record: steps that begin at or after the end of warm-up and are not acquiring, and ticks in [end of
/// warm-up, end of the run) that send a scheduled force.

#include <cstddef>
#include <vector>

#include "evenstep/reports/run_record.h"

namespace evenstep::internal {

Rows<std::size_t> judged_steps(const StrategyRecord& strategy, const Nominal& nominal);
Rows<std::size_t> judged_ticks(const DeviceRecord& device, const Nominal& nominal);

/// The simulation time at which step n begins: n * slot, or the recorded one for a strategy with variable steps.
double simulation_time_s(const StrategyRecord& strategy, std::size_t n, double slot_s);

/// A vector signal over its own time. Times are relative to the end of warm-up (for the interaction, to the simulation time
/// of the first judged step), so that a long run loses no digits. The rows are kept where the record's are.
struct Series {
  Rows<double> t_s;
  Rows<Vec3> value;
};
Series interaction_series(const StrategyRecord& strategy, const DeviceRecord& device, const Rows<std::size_t>& steps,
                          double slot_s);
Series force_series(const DeviceRecord& device, const Rows<std::size_t>& ticks, RealTime origin);

/// When the force of a tick really left: the scheduled time plus its lateness (none in virtual time).
inline RealTime sent_at(const TickRow& tick) { return tick.at + tick.lateness; }

const Nominal::Device* nominal_device(const Nominal& nominal, const std::string& name);

}  // namespace evenstep::internal
