#pragma once
/// Solvers, devices, maps and timing sources that are Python objects, as parts of a scenario.

#include "common.h"
#include "evenstep/format/scenario.h"

namespace evenstep::python {

/// A scenario, and what is raised by the Python parts in it.
struct WithParts {
  ReadResult scenario;
  std::shared_ptr<FirstError> error = std::make_shared<FirstError>();
};
/// Reads a scenario with Python parts. `parts`: {"solver": …, "device": …, "map": …, "timing": …}, each a callable, or a
/// dictionary from the names that the scenario has for them to callables. A callable alone takes the place of the part of
/// its kind that the scenario names, or else of evenstep's own.
WithParts read_with_parts(const std::string& file, const std::vector<std::string>& set, std::optional<std::uint64_t> seed,
                          const py::dict& parts);
/// The registry of parts that are all named.
Registry registry_of(const py::dict& parts, const std::shared_ptr<FirstError>& error);

void define_parts(py::module_& module);

}  // namespace evenstep::python
