#pragma once
/// Functions of a plug-in (plugin.h) as the interfaces that evenstep asks of foreign parts.

#include "evenstep/plugins/library.h"
#include "evenstep/plugins/plugin.h"

namespace evenstep::internal {

SolverFactory solver_factory(const evenstep_solver_functions& functions);
DeviceFactory device_factory(const evenstep_device_functions& functions);
MapFactory map_factory(const evenstep_map_functions& functions);
TimingFactory timing_factory(const evenstep_timing_functions& functions);

}  // namespace evenstep::internal
