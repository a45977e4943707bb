#pragma once
/// The forces of a source on their way to the device: they are there from their arrival on, in whatever order that is, and
/// are played as SourceForces says.

#include "rendered_schedule.h"

namespace evenstep::internal {

std::unique_ptr<RenderedSchedule> make_source_forces(const LinkSpec& link);

}  // namespace evenstep::internal
