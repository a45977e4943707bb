#include "evenstep/format/registry.h"

#include <fmt/format.h>

#include <stdexcept>

namespace evenstep {

void Registry::check(const char* kind, const std::string& name, bool can_be_made, bool is_taken) {
  if (name.empty()) throw std::invalid_argument(fmt::format("a {} is registered without a name", kind));
  if (!can_be_made)
    throw std::invalid_argument(fmt::format("the {} '{}' is registered without a function that makes it", kind, name));
  if (is_taken) throw std::invalid_argument(fmt::format("the {} '{}' is registered twice", kind, name));
}

}  // namespace evenstep
