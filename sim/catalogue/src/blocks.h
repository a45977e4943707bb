#pragma once
/// Blocks of the 18-neighbour lattice: S4, S9, S12, S14 and S17 of the catalogue, and S18 on devices.

#include "evenstep/catalogue/trial.h"

namespace evenstep::internal {

std::unique_ptr<Trial> make_stability_edge(const CellSpec& cell);  ///< S4; value: stiffness over the largest stable one
std::unique_ptr<Trial> make_stiff_in_soft(const CellSpec& cell);   ///< S9; value: stiff over soft
std::unique_ptr<Trial> make_standing_block(const CellSpec& cell);  ///< S12; value: stiffness, N/m
std::unique_ptr<Trial> make_energy(const CellSpec& cell);          ///< S14; value: step over the limit at rest
void compare_energies(std::span<CaseCell> cells);
std::unique_ptr<Trial> make_crushed(const CellSpec& cell);  ///< S17; value: amplitude in spacings

/// Random displacements, one per particle, within a cube of this half edge around zero; zero in a fixed bottom layer.
std::vector<glm::dvec3> shaken(const TissueScene& scene, double amplitude_m);

/// The largest eigenvalue of M^-1 K at rest for this very block (not for the infinite lattice), by power iteration over its
/// springs.
double rest_lambda_per_s2(const TissueScene& scene, const std::atomic<bool>* interrupted = nullptr);

}  // namespace evenstep::internal
