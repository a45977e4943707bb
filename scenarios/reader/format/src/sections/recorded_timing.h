#pragma once
/// [timing] trace and foreign: a timing that is a list of segments before the run begins.

#include "src/sections.h"

namespace evenstep::internal {

void read_trace(ScenarioReading& reading, const Table& timing);
/// A source of the program's own: what it gives is kept, as a recording.
void read_foreign_timing(ScenarioReading& reading, const Table& timing);

}  // namespace evenstep::internal
