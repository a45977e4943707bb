#include "evenstep/harness/suffered.h"

#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "evenstep/reports/pace.h"
#include "src/judge.h"

namespace evenstep {
namespace {

/// A metric that counts what must not happen; the metrics of the same signal, and of the device's buffers, that ask about
/// it, too, separated by blanks.
struct Harm {
  std::string_view room, metric, words;
  bool of_judged = false;
  std::string_view also = "", of_buffers = "";
};
constexpr std::array kOfDevice = std::to_array<Harm>(
    {{"interaction", "underruns", "samples missing", true, "underrun_rate", "underruns interaction_underruns underrun_rate"},
     {"force", "underruns", "forces late", true, "underrun_rate late", "underruns force_underruns underrun_rate"},
     {"buffers", "overruns", "samples overwritten before they were read"},
     {"force", "ticks_overrun", "ticks whose force was overwritten before it was played"},
     {"force", "forces_dropped", "forces dropped"},
     {"force", "non_finite", "forces not finite"},
     {"force", "cuts_device", "cuts by the device's switch"},
     {"force", "cuts_stale_hand", "cuts because the hand was stale"},
     {"force", "cuts_stale_force", "cuts because the force was stale"},
     {"force", "cuts_speed", "cuts because the hand was too fast"},
     {"force", "lost", "reports lost"},
     {"force", "write_failures", "writes failed"}});
constexpr std::array kOfStrategy = std::to_array<Harm>({{"solver", "non_finite", "values not finite"},
                                                        {"solver", "steps_not_begun", "steps that did not begin"},
                                                        {"solver", "steps_dropped", "steps dropped by the loop"}});
/// It may be too slow as well as too fast.
constexpr Harm kPace = {"solver", "simulated_per_real", ""};

bool has_word(std::string_view words, std::string_view word) {
  return (" " + std::string(words) + " ").find(" " + std::string(word) + " ") != std::string::npos;
}

/// Whether an expectation that was judged asks about it.
bool is_asserted(const Harm& harm, const std::string& signal, const std::string& buffers,
                 const std::vector<ExpectationResult>& results) {
  return std::any_of(results.begin(), results.end(), [&](const ExpectationResult& result) {
    if (result.verdict == ExpectationResult::Verdict::skipped) return false;
    const std::string& pattern = result.pattern.empty() ? result.signal : result.pattern;
    return (internal::matches(pattern, signal) && (result.metric == harm.metric || has_word(harm.also, result.metric))) ||
           (internal::matches(pattern, buffers) && has_word(harm.of_buffers, result.metric));
  });
}

}  // namespace

std::vector<std::string> suffered(const RunOutcome& outcome) {
  // What several have suffered alike stands in one line.
  std::vector<std::pair<std::string, std::vector<std::string>>> suffered_by;
  const auto say = [&](const std::string& what, const std::string& who) {
    if (what.empty()) return;
    const auto same =
        std::find_if(suffered_by.begin(), suffered_by.end(), [&](const auto& one) { return one.first == what; });
    if (same == suffered_by.end())
      suffered_by.push_back({what, {who}});
    else
      same->second.push_back(who);
  };
  const auto add = [&](const std::string& device, const StrategyRecord& strategy, std::span<const Harm> harms) {
    std::vector<std::string> counts;
    const std::string before = device.empty() ? "" : device + ".";
    const double judged = value_or_0(outcome.metrics, before + "interaction." + strategy.name, "judged");
    for (const Harm& harm : harms) {
      const std::string signal = fmt::format("{}{}.{}", before, harm.room, strategy.name);
      const double count = value_or_0(outcome.metrics, signal, std::string(harm.metric));
      if (!(count > 0) || is_asserted(harm, signal, before + "buffers." + strategy.name, outcome.results)) continue;
      counts.push_back(harm.of_judged ? fmt::format("{} of {} {}", count, judged, harm.words)
                                      : fmt::format("{} {}", count, harm.words));
    }
    say(fmt::format("{}", fmt::join(counts, ", ")), before + strategy.name);
  };
  for (const StrategyRecord& strategy : outcome.record.strategies) {
    for (const DeviceRecord& device : strategy.devices) add(device.name, strategy, kOfDevice);
    add("", strategy, kOfStrategy);
    const std::string solver = "solver." + strategy.name;
    if (!strategy.solver.memoryless && !is_asserted(kPace, solver, "", outcome.results))
      say(text(pace_of(strategy, outcome.record.nominal.slot_s)), strategy.name);
  }
  std::vector<std::string> all;
  for (const auto& [what, who] : suffered_by)
    all.push_back(fmt::format("{}: {}; nothing asserts this", fmt::join(who, ", "), what));
  return all;
}

std::string suffered_lines(const RunOutcome& outcome) {
  std::string lines;
  for (const std::string& one : suffered(outcome)) lines += fmt::format("went wrong   {}\n", one);
  return lines;
}

}  // namespace evenstep
