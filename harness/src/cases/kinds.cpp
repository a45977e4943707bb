#include "cases/chain.h"
#include "cases/oscillator.h"

namespace evenstep::internal {

const std::vector<CaseKind>& case_kinds() {
  static const std::vector<CaseKind> kinds{
      {"oscillator", "w h", "", make_oscillator},
      {"stiffness", "stiffness", "N/m", make_stiffness_decades},
      {"chain-order", "halvings of the step", "", make_chain_order, compare_chain_orders},
  };
  return kinds;
}

}  // namespace evenstep::internal
