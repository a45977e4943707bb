#pragma once
/// A part of a scenario that evenstep does not provide: the program has registered it by its name, or it is in a library or
/// a process that the file names. Its options are passed on without being read.

#include <cstdint>
#include <string>

#include "evenstep/text/diagnostic.h"

namespace evenstep {

struct Foreign {
  std::string name;            ///< "my-arm"; for a library, what it calls itself
  std::string options = "{}";  ///< a JSON object, its keys in alphabetical order
  std::string library;         ///< path of a shared object (plugin.h); empty: the program has registered it
  std::uint64_t seed = 1;      ///< [run] seed, from which all its random numbers must follow
  Place place;                 ///< of the name or the library, for errors
};

}  // namespace evenstep
