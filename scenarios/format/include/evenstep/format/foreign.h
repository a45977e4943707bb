#pragma once
/// A part of a scenario that evenstep does not provide: it is named in the file, and made by the program that has registered
/// this name. Its options are passed on without being read.

#include <string>

#include "evenstep/text/diagnostic.h"

namespace evenstep {

struct Foreign {
  std::string name;            ///< "my-arm"
  std::string options = "{}";  ///< a JSON object, its keys in alphabetical order
  Place place;                 ///< of the name, for errors
};

}  // namespace evenstep
