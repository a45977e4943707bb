#pragma once
// Runs of the paper's figure 1 on a spring, with parts that the program adds.

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <vector>

#include "catch.h"
#include "evenstep/harness/run.h"
#include "parts.h"

namespace own_parts {

inline const std::string kFigure1 = std::string(EVENSTEP_SOURCE_DIR) + "/scenarios/paper/figure-1-spring.toml";

/// Half a second of figure 1, without its expectations, with these keys set.
inline evenstep::ReadResult read(std::vector<std::string> set, const evenstep::Registry& registry) {
  set.insert(set.begin(), {"run.duration=\"0.5 s\"", "expect=[]"});
  return evenstep::read_scenario(kFigure1, {set, std::nullopt, registry});
}

inline std::string text_of(const std::vector<evenstep::Diagnostic>& errors) {
  std::string all;
  for (const evenstep::Diagnostic& error : errors) all += error.message + "\n";
  return all;
}

inline std::string errors_of(const std::vector<std::string>& set, const evenstep::Registry& registry) {
  return text_of(read(set, registry).error_or({}));
}

inline evenstep::RunOutcome run(const std::vector<std::string>& set, const evenstep::Registry& registry,
                                evenstep::RunOptions options = {}) {
  const evenstep::ReadResult scenario = read(set, registry);
  INFO(text_of(scenario.error_or({})));
  REQUIRE(scenario);
  options.allow_no_expectations = true;
  return evenstep::run_scenario(*scenario, options);
}

/// A run that must end well.
inline evenstep::RunRecord record(const std::vector<std::string>& set, const evenstep::Registry& parts = registry(),
                                  const evenstep::RunOptions& options = {}) {
  const evenstep::RunOutcome outcome = run(set, parts, options);
  INFO(text_of(outcome.errors) << outcome.failure << outcome.repeat_difference);
  REQUIRE(outcome.exit == evenstep::ExitCode::pass);
  return outcome.record;
}

inline const evenstep::StrategyRecord& strategy(const evenstep::RunRecord& run, std::string_view name) {
  for (const evenstep::StrategyRecord& one : run.strategies) {
    if (one.name == name) return one;
  }
  FAIL("no strategy " << name);
  throw 0;
}

inline const std::string kMySpring = R"(scene={ kind = "foreign", name = "my-spring", options = { stiffness = 200 } })";
inline std::string scene_of(const std::string& name) {
  return fmt::format("scene={{ kind = \"foreign\", name = \"{}\" }}", name);
}

}  // namespace own_parts
