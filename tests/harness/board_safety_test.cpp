// Every scenario of scenarios/safety runs on every board. Its expectations hold, except for what a board's firmware cannot
// know or do; and no force is felt along an axis for which none was asked.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "evenstep/device/hid/simulated_board.h"
#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

/// True for scenarios about the protocol of the reference device, about evdev or about an Inverse Service. They do not run
/// here: each has a twin for PID devices.
bool is_about_another_driver(const std::string& name) {
  return name.find("reference") != std::string::npos || name.find("evdev") != std::string::npos ||
         name.find("inverse3") != std::string::npos;
}

std::vector<std::string> safety_scenarios() {
  std::vector<std::string> names;
  for (const auto& file : std::filesystem::directory_iterator(shipped("safety"))) {
    const std::string name = file.path().stem().string();
    if (file.path().extension() == ".toml" && !is_about_another_driver(name)) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// Block Load tells no block, so that no scenario with two axes begins; or it needs springs, and whoever measures those of
/// this board feels none.
bool is_refused(const NamedBoard& board, const std::string& scenario) {
  if (board.kind == BoardKind::pxn) return scenario.find("-spring") != std::string::npos;
  return board.kind == BoardKind::load_error_first || board.kind == BoardKind::load_never ||
         board.kind == BoardKind::load_always_1;
}

/// Settings that put the board into the scenario, with the signs and slopes that a user would have measured on it. If the
/// scenario has no PID device of its own, the device has 100 N over 0.6 m.
std::vector<std::string> overrides(const Scenario& scenario, const std::string& name, const NamedBoard& board) {
  const bool one_axis = motors_of(board.kind) == 1, reversed = board.kind == BoardKind::arduino;
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
  if (board.kind == BoardKind::no_duration) set.push_back("device.left.pid.effect_duration=\"none\"");
  if (reversed) set.push_back("device.left.pid.reversed_force=[\"x\", \"y\"]");
  // A device with one axis has only one effect, so the faults must hit the first.
  if (one_axis && name == "pid-pool-full") set.push_back("device.left.pid.pool=0");
  if (one_axis && name == "pid-block-load-error") set.push_back("device.left.pid.block_load_error=1");
  // A count of this board is 10 mN, so only two of five ticks send a report; 400 reports are lost in about a second.
  if (reversed && (name == "dead-man" || name == "dead-man-control"))
    set.push_back("device.left.faults=[{ kind = \"write-lost\", at = \"2 s\", amount = 400 }]");
  return set;
}

/// How far a value may be beyond its limits, and why.
double allowance(const ExpectationResult& result, const std::string& name, const NamedBoard& board, bool made_for_pid) {
  const bool of_switches = name == "switches-mask" || name == "switches-array";
  const bool reports_switches =
      board.kind != BoardKind::openffboard_1 && board.kind != BoardKind::openffboard_2 && board.kind != BoardKind::arduino;
  const auto& metric = result.metric;
  // A board that does not report its switches cannot tell that one is off: the force is not cut, and comes back at once.
  if (of_switches && !reports_switches && (metric == "cuts_device" || metric == "error_max")) return 1e9;
  // The user has said that its effects may last.
  if (board.kind == BoardKind::no_duration && (metric == "effects_ended" || metric == "motors_unrenewed")) return 1e9;
  if (metric == "lost" && !made_for_pid) return 1e9;                         // samples are not numbered
  if (metric == "motors_max" && !made_for_pid) return 0.02;                  // two counts of 100 N
  if (metric == "motors_unrenewed") return result.unit == "ms" ? 2 : 0.002;  // whole milliseconds
  // A device with one axis has half as many effects.
  if (metric == "effects_ended" && motors_of(board.kind) == 1) return *result.min / 2;
  return 0;
}

}  // namespace

TEST_CASE("every safety scenario holds on every board and nothing is felt along an axis that was not asked for", "[sweep]") {
  const std::vector<std::string> names = safety_scenarios();
  CHECK(names.size() >= 20);
  for (const NamedBoard& board : simulated_boards()) {
    for (const std::string& name : names) {
      if (is_refused(board, name)) continue;
      const std::string file = "safety/" + name + ".toml";
      const Scenario as_shipped = read(file);
      const bool made_for_pid = std::holds_alternative<PidSpec>(as_shipped.devices.at(0).driver);
      const RunOutcome outcome = run_scenario(read(file, overrides(as_shipped, name, board)), {});
      INFO(name << " on " << board.name << ": " << outcome.failure);
      CHECK((outcome.exit == ExitCode::pass || outcome.exit == ExitCode::expectation_failed));
      for (const ExpectationResult& result : outcome.results) {
        INFO(result.metric << " " << result.detail);
        REQUIRE(result.value);
        const double allowed = allowance(result, name, board, made_for_pid);
        if (result.min) CHECK(*result.value >= *result.min - allowed);
        if (result.max) CHECK(*result.value <= *result.max + allowed);
      }
      for (const StrategyRecord& record : outcome.record.strategies) {
        glm::dvec3 asked_N{0};
        for (const TickRow& tick : record.devices.at(0).ticks) {
          for (int axis = 0; axis < 3; ++axis)
            asked_N[axis] = std::max(asked_N[axis], std::abs(tick.force_N[static_cast<std::size_t>(axis)]));
        }
        const auto& motors = outcome.metrics.at("left.force." + record.name);
        INFO(record.name);
        // Nearly all motions and walls are along X. A count is 10 mN at most. An 8-bit direction is up to 0.35 degrees off.
        CHECK(motors.at("motors_max_y") <= asked_N.y + 0.0063 * motors.at("motors_max_x") + 0.01);
        CHECK(motors.at("motors_max_z") == 0);
        CHECK(motors.at("motors_left") == 0);
      }
    }
  }
}
