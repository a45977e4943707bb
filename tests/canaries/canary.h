#pragma once
/// Only the program `evenstep_canary` has the five faults, which CMakeLists.txt lists. It is built with the tests and never
/// installed; no source of evenstep knows the faults. EVENSTEP_CANARY in its environment says which fault is on.

namespace evenstep {

bool canary(const char* name);

}  // namespace evenstep
