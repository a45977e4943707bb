#pragma once
/// The five faults of canaries.cmake are in the program `evenstep_canary` alone, which is built with the tests and never
/// installed: no source of evenstep knows them. EVENSTEP_CANARY in its environment says which of them is on.

namespace evenstep {

bool canary(const char* name);

}  // namespace evenstep
