#pragma once
/// A chain of n particles between two fixed ones, which is exactly linear along its own direction: S3 and S13 of the
/// catalogue.

#include "evenstep/catalogue/trial.h"

namespace evenstep::internal {

/// w_p^2 of mode p = 1 .. n: (4 k / m) sin^2(p pi / (2 (n + 1))).
double chain_w2_per_s2(int n, int mode, double stiffness_N_per_m, double particle_mass_kg);

std::unique_ptr<Trial> make_chain_order(const CellSpec& cell);  ///< value j: h = duration / (2^j N), N h least below dt_max
std::unique_ptr<Trial> make_wave(const CellSpec& cell);         ///< S13; value: Courant number h sqrt(k / m)
void compare_chain_orders(std::span<CaseCell> cells);

}  // namespace evenstep::internal
