#include "evenstep/time/build_option.h"

namespace evenstep {

std::string built_without(const BuildOption& option) {
  return "this evenstep is built without " + std::string(option.brings);
}

std::string remedy_without(const BuildOption& option, std::string_view otherwise) {
  std::string remedy(otherwise);
  if (!remedy.empty()) remedy += ", or ";
  return remedy + "build it with -D " + std::string(option.name) + "=ON, which needs " + std::string(option.needs);
}

std::string refusal_without(const BuildOption& option, std::string_view otherwise) {
  return built_without(option) + "; " + remedy_without(option, otherwise);
}

}  // namespace evenstep
