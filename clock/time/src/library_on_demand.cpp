#include "evenstep/time/library_on_demand.h"

#include <dlfcn.h>

namespace evenstep {

std::optional<std::string> load_on_demand(const char* soname, std::initializer_list<FunctionByName> functions) {
  // RTLD_GLOBAL, so that dlsym() finds its functions, after those of libraries that were loaded before it.
  if (dlopen(soname, RTLD_NOW | RTLD_GLOBAL) == nullptr) return dlerror();
  for (const FunctionByName& wanted : functions) {
    *wanted.function = dlsym(RTLD_DEFAULT, wanted.name);
    if (*wanted.function == nullptr) return dlerror();
  }
  return std::nullopt;
}

}  // namespace evenstep
