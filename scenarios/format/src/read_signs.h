#pragma once
/// The signs of forces and springs that a user has measured on a device: reversed_force and springs of its table.

#include <fmt/format.h>

#include <cstddef>

#include "field_rows.h"
#include "sections.h"

namespace evenstep::internal {

inline std::size_t axis_of(char letter) { return static_cast<std::size_t>(letter - 'x'); }

template <class Options>
void read_signs(const Table& table, Options& options, Errors& errors) {
  for (const Value& axis : table.at("reversed_force").list) options.reversed_force[axis_of(axis.text[0])] = true;
  for (const Value& axis : table.at("springs").list) {
    const bool reversed = axis.text[0] == '-';
    auto& known = options.reversed_spring[axis_of(axis.text.back())];
    if (known && *known != reversed)
      errors.add(axis.place,
                 fmt::format("'springs' names both signs of {}; write the one that was measured", axis.text.back()));
    known = reversed;
  }
}

}  // namespace evenstep::internal
