#pragma once
/// Blocks of the 18-neighbour lattice: S4, S9, S14, S17 and S18 of the catalogue.

#include "cases/trial.h"

namespace evenstep::internal {

std::unique_ptr<Trial> make_stability_edge(const CellSpec& cell);  ///< S4; value: stiffness over the largest stable one
std::unique_ptr<Trial> make_stiff_in_soft(const CellSpec& cell);   ///< S9; value: stiff over soft
std::unique_ptr<Trial> make_energy(const CellSpec& cell);          ///< S14; value: step over the limit at rest
void compare_energies(std::span<CaseCell> cells);
std::unique_ptr<Trial> make_crushed(const CellSpec& cell);         ///< S17; value: amplitude in spacings

/// Largest eigenvalue of M^-1 K at rest, of the block as it is (not of the endless lattice): power iteration over its springs.
double rest_lambda_per_s2(const TissueScene& scene);

}  // namespace evenstep::internal
