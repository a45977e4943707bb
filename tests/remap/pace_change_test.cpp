// A sudden change of V, of N or of the run time of steps, and what must not be mistaken for one.

#include "catch.h"
#include "schedules.h"

using namespace evenstep;
using namespace evenstep::testing;

namespace {

constexpr double kStep_ns = 22'233'333.0 / 15;
struct Pace {
  double visualization_ns = 11'100'000;
  std::int32_t steps = 15;
  double step_ns = kStep_ns;
  double length_ns() const { return visualization_ns + steps * step_ns; }
};

/// `before` segments of one pace, then `after` segments of another. Each instant is the floor of the exact one.
Schedule changed(const Pace& from, const Pace& to, std::int64_t before, std::int64_t after) {
  Schedule schedule;
  double now_ns = 0;
  const auto floored = [](double ns) { return RealTime{static_cast<std::int64_t>(std::floor(ns))}; };
  for (std::int64_t k = 0; k < before + after; ++k) {
    const Pace& pace = k < before ? from : to;
    Segment segment{floored(now_ns), {}};
    const double first_ns = now_ns + pace.visualization_ns;
    for (std::int32_t i = 0; i < pace.steps; ++i) {
      segment.steps.push_back({floored(first_ns + i * pace.step_ns), floored(first_ns + (i + 1) * pace.step_ns), k, i});
    }
    now_ns += pace.length_ns();
    schedule.push_back(segment);
  }
  return schedule;
}

struct Outcome {
  double latency_ms;
  double jump;            // in slots of the shorter pace
  std::int64_t recovery;  // segments of the new pace after which every velocity jump is at most 1 % of a slot
  bool steps_back;
};
constexpr std::int64_t kChange = 60;

Outcome outcome(const Pace& to) {
  const Schedule schedule = changed({}, to, kChange, 150);
  const std::vector<Placed> placed = place(PhaseLockedMap({}, {}), schedule);
  const SamplingGrid grid{{1000, 1}, {}};
  const LatencyBudget budget = least_latency_any_phase(mapped_steps(placed), std::span(&grid, 1), Emission::hold);
  const double slot_ns = std::min(Pace{}.length_ns() / 15, to.length_ns() / to.steps);
  Outcome result{static_cast<double>(budget.latency.ns) * 1e-6, 0, 0, false};
  for (std::size_t n = 15 * 40; n + 1 < placed.size(); ++n) {
    const Duration after = placed[n + 1].slot.read - placed[n].slot.read;
    const Duration before = placed[n].slot.read - placed[n - 1].slot.read;
    const double jump_ns = static_cast<double>(std::abs((after - before).ns));
    result.jump = std::max(result.jump, jump_ns / slot_ns);
    result.steps_back |= after.ns <= 0;
    if (jump_ns > 0.01 * slot_ns) result.recovery = placed[n].real.segment - kChange + 1;
  }
  return result;
}

}  // namespace

TEST_CASE("a step of V, of N or of all run times: latency, jump and recovery as in the table of docs/choose/numerics.md") {
  // The latency has the digits of the table, the jump is rounded up, the recovery is exact.
  struct Row {
    const char* change;
    Pace to;
    double latency_ms;
    double jump;
    std::int64_t recovery;
  };
  const auto all = [](double factor) { return Pace{11'100'000 * factor, 15, kStep_ns * factor}; };
  const Row rows[]{{"V x 2", {22'200'000}, 24.493, 0.082, 25},
                   {"V x 1/2", {5'550'000}, 13.512, 0.084, 21},
                   {"V x 3", {33'300'000}, 38.906, 0.101, 30},
                   {"V gone", {0}, 14.269, 0.105, 28},
                   {"N 15 to 30", {11'100'000, 30}, 16.159, 0.083, 17},
                   {"N 15 to 8", {11'100'000, 8}, 18.280, 0.072, 20},
                   {"T x 0.5", all(0.5), 16.190, 0.141, 26},
                   {"T x 0.75", all(0.75), 14.284, 0.094, 17},
                   {"T x 1.25", all(1.25), 17.256, 0.071, 15},
                   {"T x 1.5", all(1.5), 22.117, 0.078, 21},
                   {"T x 2", all(2), 38.510, 0.095, 26},
                   {"T x 3", all(3), 91.800, 0.157, 26}};
  for (const Row& row : rows) {
    const Outcome result = outcome(row.to);
    INFO(row.change);
    CAPTURE(result.latency_ms, result.jump, result.recovery);
    CHECK(result.latency_ms == Approx(row.latency_ms).margin(0.0006));
    CHECK(result.jump <= row.jump);
    CHECK(result.recovery == row.recovery);
    CHECK_FALSE(result.steps_back);
  }
}

TEST_CASE("a longer V needs at most 6 ms more than its pause, from 1.1 V to 3 V") {
  // The pause bound is V' + s + h less what the read of the last step before the pause had to spare. The map learns of the
  // pause when it is over, and has caught up before the next one.
  for (int percent = 110; percent <= 300; percent += 5) {
    const double visualization_ns = 111'000.0 * percent;
    const double pause_ms = (visualization_ns + 2 * kStep_ns - 1e9 / 450 + 1e6) * 1e-6;
    const double latency_ms = outcome({visualization_ns}).latency_ms;
    INFO(percent << " %");
    CHECK(latency_ms >= pause_ms - 1e-3);
    CHECK(latency_ms <= pause_ms + 6);
  }
}
