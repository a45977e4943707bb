#pragma once
/// Scenes that are barely meaningful, or not at all: S16 of the catalogue.

#include "evenstep/catalogue/trial.h"

namespace evenstep::internal {

/// value: 1 one particle alone, 2 one fixed particle and nothing else, 3 two particles at one place (a spring of no length),
/// 4 a whole block at one place, 5 a particle that no spring holds, 6 denormal displacements, 7 the hand jumps at 10 m/s,
/// 8 no mass, 9 no particle, 10 no stiffness, 11 a NaN from the hand, 12 infinity from the hand. 8 to 12 must be refused
/// with a message that names the fault.
std::unique_ptr<Trial> make_degenerate(const CellSpec& cell);

}  // namespace evenstep::internal
