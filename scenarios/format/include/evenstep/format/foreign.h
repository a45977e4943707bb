#pragma once
/// A part of a scenario that is not one of ours: named in the file, made by the program that registered this name. Its options
/// are passed on unread.

#include <string>

#include "evenstep/text/diagnostic.h"

namespace evenstep {

struct Foreign {
  std::string name;            ///< "my-arm"
  std::string options = "{}";  ///< a JSON object
  Place place;                 ///< of the name, for errors
};

}  // namespace evenstep
