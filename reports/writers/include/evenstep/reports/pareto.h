#pragma once
/// Which of several choices are Pareto-optimal: those that no other choice beats.
///
/// Choice a dominates b if none of its prices is above that of b and at least one is below. The front is the set of choices
/// that nothing dominates. Choices with equal prices tie: they dominate the same others, and are on the front together or
/// not at all.

#include <cstddef>
#include <vector>

namespace evenstep {

struct ParetoPlace {
  bool on_front = false;
  std::vector<std::size_t> dominated_by;  ///< choices on the front that do, ascending; not empty if it is not on the front
  std::vector<std::size_t> ties;          ///< the others with the same prices, ascending
};

/// One place for each choice. prices[i] are the prices of choice i: as many for each choice, finite, less is better.
/// O(n log n + n f), f the size of the front.
std::vector<ParetoPlace> pareto(const std::vector<std::vector<double>>& prices);

}  // namespace evenstep
