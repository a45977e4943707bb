#pragma once
/// A shared library of the system that is opened when the program first needs it, so that a run that does not need it does
/// not load it, and a machine without it runs everything else.

#include <initializer_list>
#include <optional>
#include <string>

namespace evenstep {

/// A function pointer to be set, and the function's name in the library.
struct FunctionByName {
  const char* name;
  void** function;
};

/// Opens the shared library `soname`, such as "libOpenCL.so.1", and sets the functions. If a library loaded earlier has the
/// same functions (a tool that watches them, say), its functions are taken, as in a program that is linked with `soname`.
/// The library stays open till the program ends. Returns nullopt, or what is missing, in the words of the dynamic linker.
std::optional<std::string> load_on_demand(const char* soname, std::initializer_list<FunctionByName> functions);

}  // namespace evenstep
