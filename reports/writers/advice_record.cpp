#include "evenstep/reports/advice_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <tuple>

#include "evenstep/reports/pareto.h"
#include "writers/texts/size_conclusion.h"

namespace evenstep {
namespace {

using internal::kSmooth;  // as `size` concludes

constexpr double kLeastJump = 1e-3;  // steps; with samples in whole nanometres a smaller jump may go unseen

double seen(double jump) { return jump < kLeastJump ? 0 : jump; }

/// To three significant digits.
double rounded(double value) { return std::strtod(fmt::format("{:.2e}", value).c_str(), nullptr); }

}  // namespace

std::string name_of(const AdviceChoice& choice) {
  std::string name = choice.map;
  if (choice.bandwidth_Hz > 0) name += fmt::format(" {:.3g} Hz", choice.bandwidth_Hz);
  if (choice.allowed_jump > 0) name += fmt::format(", jump {:.3g}", choice.allowed_jump);
  if (!choice.governor.empty()) name += ", " + choice.governor;
  if (choice.adaptive) name += ", adaptive";
  if (choice.accepted_rate > 0) name += fmt::format(", {:.3g} % late", 100 * choice.accepted_rate);
  return name + ", " + choice.renderer;
}

double late_share(const AdviceChoice& choice) { return std::max(choice.underrun_rate, choice.late_any_phase); }

std::vector<double> prices_of(const AdviceChoice& choice) {
  std::vector<double> prices{choice.delay_s,       seen(choice.jump_step), seen(choice.force_jump_step), late_share(choice),
                             choice.drawings_lost, choice.simulated_lost,  -choice.stiffness_N_per_m,    choice.runs_on_s};
  for (double& price : prices) price = rounded(price);
  // What a choice needs is a price as well: whoever has no such device, solver or simulator cannot pay it.
  // So is a missing promise: with an adaptive latency, a run in which nothing was late says nothing about the next.
  for (const bool need : {choice.needs_stiffness, choice.needs_springs, !choice.governor.empty(), choice.adaptive})
    prices.push_back(need ? 1 : 0);
  return prices;
}

void rank(AdviceRecord& record) {
  std::vector<AdviceChoice*> ranked;
  std::vector<std::vector<double>> prices;
  for (AdviceChoice& choice : record.choices) {
    const std::vector<double> its_prices = prices_of(choice);
    const bool finite = std::all_of(its_prices.begin(), its_prices.end(), [](double price) { return std::isfinite(price); });
    choice.ranked = choice.failure.empty() && choice.comes_to_rest.value_or(true) && finite;
    choice.on_front = false;
    choice.dominated_by.clear();
    choice.ties.clear();
    if (!choice.ranked) continue;
    ranked.push_back(&choice);
    prices.push_back(its_prices);
  }
  const std::vector<ParetoPlace> places = pareto(prices);
  for (std::size_t i = 0; i < ranked.size(); ++i) {
    ranked[i]->on_front = places[i].on_front;
    for (const std::size_t other : places[i].dominated_by) ranked[i]->dominated_by.push_back(ranked[other]->number);
    for (const std::size_t other : places[i].ties) ranked[i]->ties.push_back(ranked[other]->number);
  }
}

const AdviceChoice* choice_to_use(const AdviceRecord& record, bool solver_gives_stiffness) {
  const AdviceChoice* use = nullptr;
  const auto worth = [](const AdviceChoice& choice) {
    const std::vector<double> prices = prices_of(choice);
    const bool rough = prices[1] > kSmooth;
    return rough ? std::tuple(true, prices[1], prices[0], prices[2]) : std::tuple(false, prices[0], prices[2], prices[1]);
  };
  for (const AdviceChoice& choice : record.choices) {
    if (!choice.on_front || late_share(choice) > 0 || choice.drawings_lost > 0 || choice.simulated_lost > 0) continue;
    // An adaptive latency cannot promise that nothing will be late, a map that predicts runs on, and how much the hand may
    // jump is for its owner to say.
    if (choice.adaptive || choice.runs_on_s > 0 || choice.allowed_jump > 0) continue;
    if (choice.needs_springs || !choice.governor.empty() || choice.needs_stiffness != solver_gives_stiffness) continue;
    if (use == nullptr || worth(choice) < worth(*use)) use = &choice;
  }
  return use;
}

}  // namespace evenstep
