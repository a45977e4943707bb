#include "evenstep/reports/stiffness_limits.h"

#include <fmt/format.h>

#include <iterator>

#include "evenstep/reports/json.h"
#include "writers/texts/text.h"

namespace evenstep {
namespace {

std::string limit_text(const StiffnessLimit& limit) {
  switch (limit.state) {
    case StiffnessLimit::State::below:
      return fmt::format("below {:.5g} N/m", limit.unstable_N_per_m);
    case StiffnessLimit::State::above:
      return fmt::format("above {:.5g} N/m", limit.stable_N_per_m);
    case StiffnessLimit::State::found:
      break;
  }
  return fmt::format("{:.5g} N/m stable, {:.5g} N/m not", limit.stable_N_per_m, limit.unstable_N_per_m);
}

std::string bound(double value) { return value > 0 ? fmt::format("{}", value) : ""; }

}  // namespace

const char* name_of(StiffnessLimit::State state) {
  switch (state) {
    case StiffnessLimit::State::found:
      return "found";
    case StiffnessLimit::State::below:
      return "below";
    case StiffnessLimit::State::above:
      return "above";
  }
  return "";
}

std::string stiffness_table(const StiffnessLimits& study) {
  std::string out =
      fmt::format("  largest stable stiffness, from {:.5g} to {:.5g} N/m, seed{} {}{}\n", study.from_N_per_m,
                  study.to_N_per_m, study.seeds > 1 ? "s" : "", study.seed,
                  study.seeds > 1 ? fmt::format(" to {}", study.seed + static_cast<std::uint64_t>(study.seeds) - 1) : "");
  fmt::format_to(std::back_inserter(out), "  {:<14} {:>12} {:>6}  {}\n", "strategy", "latency", "runs", "limit");
  for (const StiffnessLimit& limit : study.limits) {
    fmt::format_to(std::back_inserter(out), "  {:<14} {:>9.3f} ms {:>6}  {}\n", limit.strategy, 1e3 * limit.latency_s,
                   limit.runs, limit_text(limit));
  }
  if (study.interrupted) out += "  interrupted: strategies are missing\n";
  return out;
}

std::string stiffness_csv(const StiffnessLimits& study) {
  std::string csv = "strategy,state,stable_N_per_m,unstable_N_per_m,latency_s,runs\n";
  for (const StiffnessLimit& limit : study.limits) {
    fmt::format_to(std::back_inserter(csv), "{},{},{},{},{},{}\n", internal::csv_field(limit.strategy), name_of(limit.state),
                   bound(limit.stable_N_per_m), bound(limit.unstable_N_per_m), limit.latency_s, limit.runs);
  }
  return csv;
}

std::string stiffness_json(const StiffnessLimits& study) {
  Json out = {{"format", 1},
              {"evenstep", study.version},
              {"scenario", study.scenario},
              {"file", study.file},
              {"from_N_per_m", json_number(study.from_N_per_m)},
              {"to_N_per_m", json_number(study.to_N_per_m)},
              {"seed", study.seed},
              {"seeds", study.seeds},
              {"interrupted", study.interrupted},
              {"limits", Json::array()}};
  for (const StiffnessLimit& limit : study.limits) {
    Json one = {{"strategy", limit.strategy}, {"state", name_of(limit.state)}};
    if (limit.stable_N_per_m > 0) one["stable_N_per_m"] = json_number(limit.stable_N_per_m);
    if (limit.unstable_N_per_m > 0) one["unstable_N_per_m"] = json_number(limit.unstable_N_per_m);
    one["latency_s"] = json_number(limit.latency_s);
    one["runs"] = limit.runs;
    out["limits"].push_back(one);
  }
  return json_text(out) + '\n';
}

}  // namespace evenstep
