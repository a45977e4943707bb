#pragma once
/// What tests of laws over drawn scenarios share.

#include <cstdlib>
#include <fstream>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "../own_parts/parts.h"
#include "cases.h"
#include "catch.h"
#include "program.h"
#include "scenario_generator.h"
#include "temporary_folder.h"

namespace evenstep::testing {

using Json = nlohmann::json;

inline std::string content_of(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// The number after EVENSTEP_SEEDS, as "7" for one seed or "20000" for so many from 0 on; or `usual` seeds.
struct Seeds {
  std::uint64_t first = 0, end = 0;
};
inline Seeds seeds(std::uint64_t usual) {
  if (const char* const one = std::getenv("EVENSTEP_SEED")) {
    const std::uint64_t seed = std::stoull(one);
    return {seed, seed + 1};
  }
  if (const char* const count = std::getenv("EVENSTEP_SEEDS")) return {0, std::stoull(count)};
  return {0, share_of(usual)};
}

/// Reports that are lost or late, or whose age varies, miss more than the schedule alone does.
inline bool loses_or_varies(const std::string& toml) {
  for (const char* const part :
       {"[[device.faults]]", "unplug", "_at = ", "report_", "clock_rate", "[[device.events]]", "interrupt"})
    if (toml.find(part) != std::string::npos) return true;
  return false;
}

constexpr double kRichness = 0.05;

/// Runs in a folder of its own.
class Bench {
 public:
  Bench() { write_recordings(folder_.path().string()); }
  std::string path() const { return folder_.path().string(); }
  std::string scenario() const { return folder_.path().string() + "/scenario.toml"; }
  GeneratedScenario draw(std::uint64_t seed) const {
    ScenarioGenerator generator(seed, folder_.path().string(), registry_);
    GeneratedScenario drawn;
    for (int attempt = 0; attempt < 8 && !drawn.is_valid; ++attempt) drawn = generator.scenario(kRichness);
    return drawn;
  }
  Ended program(const std::vector<std::string>& arguments) const {
    return run_program(arguments, folder_.path().string(), registry_, {.interrupt_after_s = 60, .end_after_s = 20});
  }
  /// `evenstep run` of a scenario text; `summary` is null if there is none.
  struct Run {
    Ended ended;
    Json summary;
  };
  Run run(const std::string& toml, const std::string& out, std::vector<std::string> more = {}) const {
    std::ofstream(scenario()) << toml;
    std::vector<std::string> arguments{"run", "scenario.toml", "--out", out, "--allow-no-expectations"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    Run run{program(arguments), nullptr};
    run.summary = Json::parse(content_of(folder_.path().string() + '/' + out + "/summary.json"), nullptr, false);
    return run;
  }

 private:
  TemporaryFolder folder_;
  Registry registry_ = own_parts::registry();
};

/// Draws a scenario for each seed and counts those that `judge` could judge: it returns false for one of which the law says
/// nothing. At least one must be judged, but for a single seed and the few of a sanitized build.
inline void judge_drawn(std::uint64_t usual,
                        const std::function<bool(const Bench&, std::uint64_t seed, GeneratedScenario drawn)>& judge) {
  const Bench bench;
  const auto [first, end] = seeds(usual);
  std::uint64_t judged = 0;
  for (std::uint64_t seed = first; seed < end; ++seed) {
    GeneratedScenario drawn = bench.draw(seed);
    if (!drawn.is_valid) continue;
    INFO("EVENSTEP_SEED=" << seed << '\n' << drawn.toml);
    judged += judge(bench, seed, std::move(drawn));
  }
  std::cout << judged << " of " << end - first << " scenarios judged\n";
  CHECK((judged > 0 || kSanitized || end - first == 1));
}

}  // namespace evenstep::testing
