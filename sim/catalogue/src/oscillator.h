#pragma once
/// One particle on one spring: S1, S2, S5 and S6 of the catalogue.

#include "evenstep/catalogue/linear_map.h"
#include "evenstep/catalogue/trial.h"

namespace evenstep::internal {

/// A particle of 1 g next to a fixed one. Along its own direction the spring is linear as long as it does not turn inside
/// out.
TissueScene oscillator_scene(const CellSpec& cell, double stiffness_N_per_m);
inline constexpr double kOscillatorMass_kg = 1e-3;
inline constexpr Rate kOscillatorRate{1000, 1};

std::unique_ptr<Trial> make_oscillator(const CellSpec& cell);         ///< value: w h
std::unique_ptr<Trial> make_stiffness_decades(const CellSpec& cell);  ///< value: N/m
std::unique_ptr<Trial> make_damping_decades(const CellSpec& cell);    ///< value: damping ratio

}  // namespace evenstep::internal
