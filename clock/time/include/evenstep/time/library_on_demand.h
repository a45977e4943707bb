#pragma once
/// A shared library of the system that is opened when the program first needs it, so that a run that does not need it does
/// not load it, and a machine without it runs everything else.

#include <initializer_list>
#include <optional>
#include <string>

namespace evenstep {

/// A pointer to a function, to be set, by the function's name in the library.
struct FunctionByName {
  const char* name;
  void** function;
};

/// Opens the shared library `soname`, such as "libOpenCL.so.1", and sets the functions. A library loaded before it that has
/// the same functions, such as a tool that watches them, comes first, as it does for programs that are linked with it. The
/// library stays open till the program ends. nullopt, or what is missing, in the words of the dynamic linker.
std::optional<std::string> load_on_demand(const char* soname, std::initializer_list<FunctionByName> functions);

}  // namespace evenstep
