#include "blocks.h"
#include "chain.h"
#include "degenerate.h"
#include "evenstep/catalogue/numbering.h"
#include "oscillator.h"
#include "particles.h"

namespace evenstep::internal {

const std::vector<CaseKind>& case_kinds() {
  static const std::vector<CaseKind> kinds{
      {"oscillator", "w h", "", make_oscillator},
      {"stiffness", "stiffness", "N/m", make_stiffness_decades},
      {"chain-order", "halvings of the step", "", make_chain_order, compare_chain_orders},
      {"edge", "stiffness over the largest stable one", "", make_stability_edge},
      {"damping", "damping ratio", "", make_damping_decades},
      {"moving-target", "coupling", "N/m", make_moving_target},
      {"mass-ratio", "heavy over light", "", make_mass_ratio},
      {"stiff-in-soft", "stiff over soft", "", make_stiff_in_soft},
      {"wall", "penalty", "N/m", make_wall},
      {"free-fall", "away from rest", "m", make_free_fall},
      {"hanging-chain", "stiffness", "N/m", make_hanging_chain},
      {"standing-block", "stiffness", "N/m", make_standing_block},
      {"wave", "Courant number", "", make_wave},
      {"energy", "step over the limit at rest", "", make_energy, compare_energies},
      {"press", "steps per ms", "", make_press},
      {"degenerate", "what", "", make_degenerate},
      {"crushed", "amplitude", "spacings", make_crushed},
      {"numbering", "steps", "", make_numbering},
  };
  return kinds;
}

}  // namespace evenstep::internal
