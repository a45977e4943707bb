// Animation errors of records that are written by hand.
#include <vector>

#include "catch.h"
#include "src/shown_time.h"

using namespace evenstep;

namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr double kSlot_s = 10e-3;

/// Steps of 10 ms of simulation time that begin at these times, in ms, take 2 ms and are due 40 ms after their begin.
struct Run {
  explicit Run(const std::vector<std::int64_t>& begins_ms, bool mapped, std::size_t lost = SIZE_MAX) {
    for (std::size_t n = 0; n < begins_ms.size(); ++n) {
      StepRow row;
      row.begin = row.read = RealTime{begins_ms[n] * kMs};
      row.end = row.begin + Duration{2 * kMs};
      row.emission = mapped ? row.begin + Duration{40 * kMs} : row.end;
      row.mapped = mapped;
      row.lost = n == lost;
      strategy.steps.push_back(row);
      steps.push_back(n);
    }
    for (std::int64_t k = 0; k <= begins_ms.back() + 40; ++k) {
      TickRow tick;
      tick.at = RealTime{k * kMs};
      device.ticks.push_back(tick);
      ticks.push_back(static_cast<std::size_t>(k));
    }
  }
  double error_ms(bool hold) {
    device.interpolates = !hold;
    const auto error = internal::animation_error(strategy, device, internal::shown_steps(strategy, steps), ticks, kSlot_s);
    REQUIRE(error);
    return error->max_s * 1e3;
  }
  StrategyRecord strategy;
  DeviceRecord device;
  Rows<std::size_t> steps, ticks;
};

}  // namespace

TEST_CASE("animation error: none if forces are shown as evenly as they are simulated, held or on a line") {
  const std::vector<std::int64_t> even{0, 10, 20, 30, 40, 50, 60};
  CHECK(Run(even, true).error_ms(true) < 1e-9);
  CHECK(Run(even, true).error_ms(false) < 1e-9);
  CHECK(Run(even, false).error_ms(true) < 1e-9);
}

TEST_CASE("animation error: a step that begins d late is shown d late, and the next one d early") {
  for (std::int64_t d = 1; d <= 9; ++d) {
    const std::vector<std::int64_t> late{0, 10, 20, 30 + d, 40, 50, 60};
    CHECK(Run(late, false).error_ms(true) == Approx(static_cast<double>(d)).epsilon(1e-9));
  }
}

TEST_CASE(
    "animation error: a lost force costs none, because its time passes in both, and a period that is left out costs one") {
  const std::vector<std::int64_t> even{0, 10, 20, 30, 40, 50, 60}, left_out{0, 10, 20, 40, 50, 60};
  CHECK(Run(even, false, 3).error_ms(true) < 1e-9);
  CHECK(Run(even, true, 3).error_ms(false) < 1e-9);
  CHECK(Run(left_out, false).error_ms(true) == Approx(10).epsilon(1e-9));
  // On a line the ten missing milliseconds are spread over the twenty of the line, half a tick at each tick.
  CHECK(Run(left_out, true).error_ms(false) == Approx(0.5).epsilon(1e-9));
}

TEST_CASE("animation error: a force that comes after a later one is not shown at all") {
  Run run({0, 10, 20, 30, 40, 50}, false);
  run.strategy.steps[2].transport = Duration{15 * kMs};  // it arrives at 37 ms, the next one at 32 ms
  const Rows<std::size_t> shown = internal::shown_steps(run.strategy, run.steps);
  CHECK(std::vector<std::size_t>(shown.begin(), shown.end()) == std::vector<std::size_t>{0, 1, 3, 4, 5});
  CHECK(run.error_ms(true) < 1e-9);
}
