#pragma once
/// A few particles with an exact answer: S7, S8, S10, S11, S12 and S15 of the catalogue.

#include "evenstep/catalogue/trial.h"

namespace evenstep::internal {

std::unique_ptr<Trial> make_moving_target(const CellSpec& cell);  ///< S7; value: stiffness of the coupling, N/m
std::unique_ptr<Trial> make_mass_ratio(const CellSpec& cell);     ///< S8; value: heavy over light
std::unique_ptr<Trial> make_wall(const CellSpec& cell);           ///< S10; value: penalty stiffness, N/m
std::unique_ptr<Trial> make_free_fall(const CellSpec& cell);      ///< S11; value: distance from rest, m
std::unique_ptr<Trial> make_hanging_chain(const CellSpec& cell);  ///< S12; value: stiffness, N/m
std::unique_ptr<Trial> make_press(const CellSpec& cell);          ///< S15; value: steps per millisecond

}  // namespace evenstep::internal
