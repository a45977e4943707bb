#pragma once
/// [timing] governor.

#include "src/field_rows.h"
#include "src/sections.h"

namespace evenstep::internal {

/// After the rest of [timing].
void read_governor(ScenarioReading& reading, const Table& governor);
const std::vector<Field>& governor_fields();

}  // namespace evenstep::internal
