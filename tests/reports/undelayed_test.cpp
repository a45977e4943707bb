// The force that was sent, compared with the force without delay, on ticks that are made up here.
#include <cmath>
#include <functional>

#include "catch.h"
#include "evenstep/reports/measures.h"

using namespace evenstep;

namespace {

/// One device at 1 kHz for a second, with the force that was sent and the force without delay, both along x.
RunRecord run_of(const std::function<double(int)>& sent, const std::function<double(int)>& undelayed) {
  RunRecord run;
  run.nominal.end = RealTime{1'000'000'000};
  run.nominal.slot_s = 1.0 / 450;
  Nominal::Device& nominal = run.nominal.devices.emplace_back();
  nominal.name = "left";
  nominal.stop_at = RealTime{500'000'000};
  StrategyRecord& strategy = run.strategies.emplace_back();
  strategy.name = "direct";
  DeviceRecord& device = strategy.devices.emplace_back();
  device.name = "left";
  for (int k = 0; k < 1000; ++k)
    device.ticks.push_back({RealTime{std::int64_t{k} * 1'000'000}, {}, {}, {sent(k), 0, 0}, true, Vec3{undelayed(k), 0, 0}});
  return run;
}

std::map<std::string, double> values(const RunRecord& run) { return measure(run).at("left.force.direct"); }

}  // namespace

TEST_CASE("the error of the force is its distance from the undelayed one: largest, rms, share, and around the stop") {
  const auto late = [](int k) { return -0.003 * std::max(0, std::min(k, 500) - 15); };
  const auto now = [](int k) { return -0.003 * std::min(k, 500); };
  const auto all = values(run_of(late, now));
  double errors = 0, forces = 0;
  for (int k = 0; k < 1000; ++k) {
    errors += std::pow(late(k) - now(k), 2);
    forces += std::pow(now(k), 2);
  }
  CHECK(all.at("error_max") == Approx(0.045).epsilon(1e-12));
  CHECK(all.at("error_rms") == Approx(std::sqrt(errors / 1000)).epsilon(1e-12));
  CHECK(all.at("error_share") == Approx(std::sqrt(errors / forces)).epsilon(1e-12));
  CHECK(all.at("error_at_stop") == Approx(0.045).epsilon(1e-12));
  // An error more than 100 ms after the stop does not count as an error at the stop.
  const auto later = values(run_of([&](int k) { return now(k) + (k == 601 ? 1 : 0); }, now));
  CHECK(later.at("error_max") == Approx(1).epsilon(1e-12));
  CHECK(later.at("error_at_stop") == 0);
}

TEST_CASE("the onset is how much later a touch is sent, and a ghost is what is sent after the touch has ended") {
  const auto touch = [](int from, int to) { return [from, to](int k) { return k >= from && k < to ? 0.5 : 0.0; }; };
  const auto late = values(run_of(touch(115, 315), touch(100, 300)));
  CHECK(late.at("onset_delay") == Approx(0.015).epsilon(1e-12));
  CHECK(late.at("ghost_force") == 0.5);
  const auto early = values(run_of(touch(99, 300), touch(100, 300)));
  CHECK(early.at("onset_delay") == Approx(-0.001).epsilon(1e-12));
  CHECK(early.at("ghost_force") == 0);                                            // a force before the touch is no ghost
  CHECK(values(run_of(touch(0, 300), touch(0, 300))).count("onset_delay") == 0);  // touched from the start
  const auto never = values(run_of(touch(0, 0), touch(0, 0)));
  CHECK(never.count("onset_delay") == 0);
  CHECK(never.count("ghost_force") == 0);
  CHECK(never.count("error_share") == 0);
}

TEST_CASE("where nobody asked the scene for its undelayed force there is no error") {
  RunRecord run = run_of([](int) { return 1; }, [](int) { return 1; });
  for (TickRow& tick : run.strategies[0].devices[0].ticks) tick.undelayed_N.reset();
  CHECK(values(run).count("error_max") == 0);
}
