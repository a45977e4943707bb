#include "evenstep/reports/pareto.h"

#include <algorithm>
#include <numeric>

namespace evenstep {
namespace {

using Prices = std::vector<double>;

/// No price of `a` is above that of `b`.
bool at_most(const Prices& a, const Prices& b) {
  return std::equal(a.begin(), a.end(), b.begin(), [](double x, double y) { return x <= y; });
}

}  // namespace

std::vector<ParetoPlace> pareto(const std::vector<Prices>& prices) {
  std::vector<std::size_t> order(prices.size()), front;
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return prices[a] < prices[b]; });
  std::vector<ParetoPlace> places(prices.size());
  // Every choice that dominates another comes before it in this order, and is on the front or dominated by one that is.
  for (std::size_t place = 0; place < order.size(); ++place) {
    const std::size_t i = order[place];
    for (const std::size_t f : front) {
      if (prices[f] != prices[i] && at_most(prices[f], prices[i])) places[i].dominated_by.push_back(f);
    }
    std::sort(places[i].dominated_by.begin(), places[i].dominated_by.end());
    places[i].on_front = places[i].dominated_by.empty();
    if (places[i].on_front) front.push_back(i);
  }
  for (std::size_t from = 0, to = 0; from < order.size(); from = to) {
    while (to < order.size() && prices[order[to]] == prices[order[from]]) ++to;
    for (std::size_t i = from; i < to; ++i) {
      for (std::size_t j = from; j < to; ++j) {
        if (i != j) places[order[i]].ties.push_back(order[j]);  // ascending, because the sort was stable
      }
    }
  }
  return places;
}

}  // namespace evenstep
