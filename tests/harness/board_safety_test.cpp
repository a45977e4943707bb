// Every scenario of scenarios/safety on every board: what it expects holds, but for what a board's firmware cannot know or
// do, and nothing is felt along an axis that was not asked for.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "evenstep/device/hid/simulated_board.h"
#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

/// Those of the reference device whose subject is its own protocol have a twin for PID devices.
bool is_about_reports_of_reference(const std::string& name) { return name.find("reference") != std::string::npos; }

std::vector<std::string> safety_scenarios() {
  std::vector<std::string> names;
  for (const auto& file : std::filesystem::directory_iterator(shipped("safety"))) {
    const std::string name = file.path().stem().string();
    if (file.path().extension() == ".toml" && !is_about_reports_of_reference(name)) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// The board, with the signs and slopes that somebody would have measured on it. 100 N over 0.6 m if the scenario has no PID
/// device of its own.
std::vector<std::string> overrides(const std::string& file, const NamedBoard& board) {
  const Scenario scenario = read(file, {});
  const bool one_axis = board.kind == BoardKind::openffboard_1, reversed = board.kind == BoardKind::arduino;
  std::vector<std::string> set;
  const auto* pid = std::get_if<PidSpec>(&scenario.devices.at(0).driver);
  const double travel_m = pid ? pid->options.travel_m.x : 0.6, full_scale_N = pid ? *pid->options.full_scale_N : 100;
  const std::string travel = fmt::format("[\"{0} m\", \"{1} m\", \"0 m\"]", travel_m, one_axis ? 0 : travel_m);
  if (!pid) {
    set.push_back("device.left.driver=\"pid\"");
    set.push_back(fmt::format("device.left.pid={{ travel = {}, full_scale = \"{} N\", gain = 1.0 }}", travel, full_scale_N));
  } else {
    set.push_back("device.left.pid.travel=" + travel);
  }
  set.push_back(fmt::format("device.left.pid.full_slope=\"{} N/m\"", full_scale_N / (travel_m / 2)));
  set.push_back(fmt::format("device.left.pid.firmware=\"{}\"", board.name));
  set.push_back(one_axis ? "device.left.pid.springs=[\"x\"]" : "device.left.pid.springs=[\"x\", \"y\"]");
  if (reversed) set.push_back("device.left.pid.reversed_force=[\"x\", \"y\"]");
  return set;
}

/// What a board cannot do: scenario, board ("*": all), metric, why.
struct Exception {
  std::string_view scenario, board, metric, why;
};
const std::vector<Exception> kExceptions{};

bool is_excepted(const std::string& scenario, std::string_view board, const std::string& metric) {
  return std::any_of(kExceptions.begin(), kExceptions.end(), [&](const Exception& exception) {
    return exception.scenario == scenario && (exception.board == "*" || exception.board == board) &&
           exception.metric == metric;
  });
}

}  // namespace

TEST_CASE("every safety scenario holds on every board and nothing is felt along an axis that was not asked for") {
  const std::vector<std::string> names = safety_scenarios();
  CHECK(names.size() >= 20);
  for (const NamedBoard& board : simulated_boards()) {
    for (const std::string& name : names) {
      const std::string file = "safety/" + name + ".toml";
      const RunOutcome outcome = run_scenario(read(file, overrides(file, board)), {});
      INFO(name << " on " << board.name << ": " << outcome.failure);
      CHECK((outcome.exit == ExitCode::pass || outcome.exit == ExitCode::expectation_failed));
      for (const ExpectationResult& result : outcome.results) {
        INFO(result.detail);
        if (is_excepted(name, board.name, result.metric)) continue;
        CHECK(result.verdict == ExpectationResult::Verdict::pass);
      }
      for (const auto& [signal, metrics] : outcome.metrics) {
        const auto across = metrics.find("motors_max_y");
        if (across == metrics.end()) continue;
        INFO(signal);
        // The motions and walls are along X. A direction of 8 bits is 0.35 degrees off.
        CHECK(across->second <= 0.0063 * metrics.at("motors_max_x") + 1e-9);
        CHECK(metrics.at("motors_max_z") == 0);
        CHECK(metrics.at("motors_left") == 0);
      }
    }
  }
}
