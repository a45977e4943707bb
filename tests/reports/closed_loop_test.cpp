// The signal closed_loop.<device>.<strategy>: energy at the device's port, rendered damping, oscillation.

#include <cmath>
#include <numbers>
#include <vector>

#include "catch.h"
#include "evenstep/reports/measures.h"

using namespace evenstep;

namespace {

constexpr double kPi = std::numbers::pi;

struct Port {
  std::vector<double> t;
  std::vector<Vec3> x, force_N;
};

/// A sine of amplitude A at `rate` ticks per second, and the force that `law` sends at each tick.
template <class Law>
Port sine_port(double amplitude_m, double frequency_Hz, double rate, int ticks, Law law) {
  Port port;
  for (int n = 0; n < ticks; ++n) {
    const double t = n / rate;
    port.t.push_back(t);
    port.x.push_back({amplitude_m * std::sin(2 * kPi * frequency_Hz * t), 0, 0});
    port.force_N.push_back({law(t), 0, 0});
  }
  return port;
}

RunRecord run_of(const Rows<TickRow>& ticks, bool feels_force) {
  RunRecord run;
  run.nominal.slot_s = 1.0 / 450;
  run.nominal.end = RealTime{8'000'000'000};
  Nominal::Device nominal;
  nominal.name = "left";
  nominal.rate = {1000, 1};
  nominal.feels_force = feels_force;
  run.nominal.devices.push_back(nominal);
  StrategyRecord strategy;
  strategy.name = "direct";
  DeviceRecord device;
  device.name = "left";
  device.ticks = ticks;
  strategy.devices.push_back(device);
  run.strategies.push_back(strategy);
  return run;
}

/// 8 s of a decaying or growing swing: x = 5 mm exp(rate t) cos(2 pi 3 Hz t).
Rows<TickRow> swing(double growth_per_s, double amplitude_m = 5e-3) {
  Rows<TickRow> ticks;
  for (std::int64_t k = 0; k < 8000; ++k) {
    TickRow tick;
    tick.at = RealTime{k * 1'000'000};
    const double t = k * 1e-3;
    tick.position_m = {amplitude_m * std::exp(growth_per_s * t) * std::cos(6 * kPi * t), 0, 0};
    tick.started = true;
    ticks.push_back(tick);
  }
  return ticks;
}

}  // namespace

TEST_CASE("the energy at the port is minus force times way, step by step, and its sign says who gives") {
  // The hand is pushed by 1 mm against 2 N twice, then moves back under 5 N: 4 mJ in, 5 mJ out.
  const std::vector<double> t{0, 0.001, 0.002, 0.003};
  const std::vector<Vec3> x{{0, 0, 0}, {1e-3, 0, 0}, {2e-3, 0, 0}, {1e-3, 0, 0}};
  const std::vector<Vec3> force{{-2, 0, 0}, {-2, 0, 0}, {-5, 0, 0}, {-99, 0, 0}};
  const Rows<double> energy = port_energy(t, x, force, 0);
  const std::vector<double> expected{0, 2e-3, 4e-3, -1e-3};
  for (std::size_t n = 0; n < 4; ++n) CHECK(energy[n] == Approx(expected[n]).margin(1e-15));
}

TEST_CASE("every axis counts") {
  const std::vector<double> t{0, 1};
  const std::vector<Vec3> x{{0, 0, 0}, {1, 2, 3}}, force{{-10, -20, -30}, {}};
  CHECK(port_energy(t, x, force, 0)[1] == Approx(10 + 40 + 90));
}

TEST_CASE("springs that go along with the hand give back what was put in, whatever way, saturation and side") {
  // The whole force comes from the spring, so E is the energy that the spring stores.
  const SpringRow spring{{0.001, 0, -0.002}, {300, 0, 100}, {0, 200, 100}, {0.4, 0.2, 9}};
  std::vector<double> t;
  std::vector<Vec3> x, force;
  for (int k = 0; k < 500; ++k) {
    t.push_back(k * 1e-3);
    x.push_back({4e-3 * std::sin(0.1 * k), 3e-3 * std::sin(0.07 * k), 5e-3 * std::sin(0.031 * k)});
    force.push_back(spring_force_N(spring, x.back()));
  }
  const auto stored_J = [&](const Vec3& at) {
    // By the midpoint rule along each axis, from the center on.
    double sum = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      constexpr int kParts = 20'000;
      const double way = at[axis] - spring.center_m[axis];
      for (int i = 0; i < kParts; ++i) {
        Vec3 on = spring.center_m;
        on[axis] += way * (i + 0.5) / kParts;
        sum -= spring_force_N(spring, on)[axis] * way / kParts;
      }
    }
    return sum;
  };
  const Rows<SpringRow> springs(t.size(), spring);
  const auto energy = port_energy(t, x, force, 0, springs);
  for (std::size_t k = 0; k < t.size(); k += 7) CHECK(energy[k] == Approx(stored_J(x[k]) - stored_J(x[0])).margin(1e-9));
  // With a held force added, the work of that force is added.
  std::vector<Vec3> more = force;
  for (Vec3& f : more) f[1] -= 0.5;
  const auto both = port_energy(t, x, more, 0, springs);
  for (std::size_t k = 0; k < t.size(); ++k) CHECK(both[k] - energy[k] == Approx(0.5 * (x[k][1] - x[0][1])).margin(1e-12));
}

TEST_CASE("a damper renders its own damping, a held spring minus k h / 2, a delayed one minus k times the delay") {
  const double k = 300, b = 2.5, A = 5e-3, h = 1e-3;
  for (const double f : {1.0, 3.0, 7.0}) {
    CAPTURE(f);
    const double w = 2 * kPi * f;
    const auto rendered = [&](auto law, double delay_s) {
      const Port port = sine_port(A, f, 1000, 5001, law);
      const auto energy = port_energy(port.t, port.x, port.force_N, delay_s);
      const auto result = rendered_damping(port.t, energy, 2 * A, f);
      REQUIRE(result);
      CHECK(result->energy_per_cycle_J == Approx(kPi * A * A * w * result->damping_N_s_per_m));
      return result->damping_N_s_per_m;
    };
    const auto spring = [&](double delay) { return [=](double t) { return -k * A * std::sin(w * (t - delay)); }; };
    // A force that is held for h acts h / 2 late, and its fundamental is smaller by (w h)^2 / 24. For a delay D the law has
    // sin(w D) / w instead of D.
    const double tolerance = w * h * w * h;
    for (const double delay : {0.0, 0.0151, 0.03}) {
      const double total = delay + h / 2, expected = -k * std::sin(w * total) / w;
      CHECK(rendered(spring(delay), 0) == Approx(expected).epsilon(tolerance + 1e-6));
      // The delay between sending and feeling counts the same, whether it is a whole number of ticks or not.
      const double late = -k * std::sin(w * (total + 0.0024)) / w;
      CHECK(rendered(spring(delay), 0.0024) == Approx(late).epsilon(0.005));
      CHECK(rendered(spring(delay), 0.002) == Approx(rendered(spring(delay + 0.002), 0)).epsilon(0.002));
    }
    CHECK(rendered([=](double t) { return -b * A * w * std::cos(w * (t - h / 2)); }, 0) ==
          Approx(b * std::cos(w * h)).epsilon(0.002));
  }
}

TEST_CASE("rendered damping uses whole cycles only, ends between two ticks, and has none to use in less than a cycle") {
  const auto law = [](double t) { return -300 * 5e-3 * std::sin(6 * kPi * (t - 0.01)); };
  const auto rendered = [&](int ticks) {
    const Port port = sine_port(5e-3, 3, 1000, ticks, law);
    return rendered_damping(port.t, port_energy(port.t, port.x, port.force_N, 0), 0.01, 3);
  };
  CHECK_FALSE(rendered(334));  // 333 ms, shorter than the period of 333.3 ms
  REQUIRE(rendered(335));
  const double whole = rendered(3001)->damping_N_s_per_m;
  for (const int ticks : {335, 500, 668, 1234, 2777})
    CHECK(rendered(ticks)->damping_N_s_per_m == Approx(whole).epsilon(0.01));
  CHECK_FALSE(rendered_damping({}, {}, 0.01, 3));
  const Port still = sine_port(0, 3, 1000, 1000, law);
  CHECK_FALSE(rendered_damping(still.t, port_energy(still.t, still.x, still.force_N, 0), 0, 3));
}

TEST_CASE("an oscillation is judged by the last eighth against two before, decaying by 2 percent or resting within 5 um") {
  // Five seconds lie between the two windows.
  const double edge = std::log(0.98) / 5;
  const auto values = [](double growth, double amplitude = 5e-3) {
    return measure(run_of(swing(growth, amplitude), true)).at("closed_loop.left.direct");
  };
  CHECK(values(edge - 1e-4).at("stable") == 1);
  CHECK(values(edge + 1e-4).at("stable") == 0);
  CHECK(values(0).at("stable") == 0);
  CHECK(values(0.1).at("oscillation_ratio") == Approx(std::exp(0.5)).epsilon(1e-6));
  CHECK(values(-0.3).at("oscillation_ratio") == Approx(std::exp(-1.5)).epsilon(1e-6));
  CHECK(values(0.0).at("peak_to_peak") == Approx(0.01).epsilon(1e-3));
  // A swing that overshoots early and then keeps its size does not count as decaying.
  auto ticks = swing(0);
  for (std::size_t k = 2000; k < 3000; ++k) ticks[k].position_m[0] *= 1.5;
  const auto overshoot = measure(run_of(ticks, true)).at("closed_loop.left.direct");
  CHECK(overshoot.at("oscillation_ratio") == Approx(1 / 1.5));
  CHECK(overshoot.at("stable") == 0);
  // Nor does one that then decays more slowly than 2 percent over five eighths, which is 0.8 percent over the last two.
  const auto bounded = [](double growth_per_s) {
    auto swings = swing(growth_per_s);
    for (std::size_t k = 2000; k < 3000; ++k) swings[k].position_m[0] *= 1.5;
    return measure(run_of(swings, true)).at("closed_loop.left.direct").at("stable");
  };
  CHECK(bounded(edge + 1e-4) == 0);
  CHECK(bounded(edge - 1e-4) == 1);
  CHECK(values(0, 2.4e-6).at("stable") == 1);  // 4.8 um
  CHECK(values(0, 2.6e-6).at("stable") == 0);
}

TEST_CASE("what is not a number is not stable, what did not move has no ratio, and a programmed motion has no stability") {
  auto ticks = swing(-1);
  ticks[7500].position_m[1] = NAN;
  CHECK(measure(run_of(ticks, true)).at("closed_loop.left.direct").at("stable") == 0);
  const auto still = measure(run_of(swing(0, 0), true)).at("closed_loop.left.direct");
  CHECK(still.at("stable") == 1);
  CHECK(still.count("oscillation_ratio") == 0);
  const auto programmed = measure(run_of(swing(0), false)).at("closed_loop.left.direct");
  CHECK(programmed.count("stable") == 0);
  CHECK(programmed.count("energy_min") == 1);
  CHECK(programmed.count("rendered_damping") == 0);
}

TEST_CASE("a run's energy is judged from the end of warm-up on and its least is never above zero") {
  auto ticks = swing(0);
  for (TickRow& tick : ticks) tick.force_N = {-100 * tick.position_m[0], 0, 0};
  RunRecord run = run_of(ticks, true);
  run.nominal.judged_from = RealTime{1'000'000'000};
  const auto values = measure(run).at("closed_loop.left.direct");
  // The force of a spring is held for a tick. That gives b = -k h / 2, so a negative energy per cycle. Within a cycle the
  // energy swings by k A^2 / 2.
  const double per_cycle = -kPi * 25e-6 * 6 * kPi * 100 * 0.5e-3;
  CHECK(values.at("energy_end") == Approx(7 * 3 * per_cycle).epsilon(0.03));
  CHECK(values.at("energy_min") <= values.at("energy_end"));
  CHECK(values.at("energy_min") >= values.at("energy_end") - 100 * 25e-6 / 2);
  // A pure damper takes energy at every tick and never gives any back.
  for (std::size_t k = 0; k + 1 < ticks.size(); ++k) {
    const double way = ticks[k + 1].position_m[0] - ticks[k].position_m[0];
    run.strategies[0].devices[0].ticks[k].force_N = {-10 * way / 1e-3, 0, 0};
  }
  CHECK(measure(run).at("closed_loop.left.direct").at("energy_min") == 0);
}

TEST_CASE("what is released is counted in what was stored, and has no meaning where nothing or nobody knows what was") {
  auto ticks = swing(0);
  for (TickRow& tick : ticks) tick.force_N = {-100 * tick.position_m[0], 0, 0};
  RunRecord run = run_of(ticks, true);
  const auto values = [&] { return measure(run).at("closed_loop.left.direct"); };
  CHECK(values().count("energy_released") == 0);
  run.strategies[0].devices[0].stored_J = 0;
  CHECK(values().count("energy_released") == 0);
  run.strategies[0].devices[0].stored_J = 1.25e-3;  // 100 N/m, 5 mm
  CHECK(values().at("energy_released") == Approx(-values().at("energy_min") / 1.25e-3).epsilon(1e-14));
  CHECK(values().at("energy_released") > 1);  // holding the force for a tick makes energy
}

TEST_CASE("the laws stand beside what was measured, each where it has a meaning") {
  RunRecord run = run_of(swing(-1), true);
  DeviceRecord& device = run.strategies[0].devices[0];
  const auto values = [&] { return measure(run).at("closed_loop.left.direct"); };
  device.loop = {15e-3};
  CHECK(values().at("loop_delay") == 15e-3);
  for (const char* metric : {"alpha", "alpha_star", "stiffness_cap", "predicted_damping", "predicted_stiffness_limit"})
    CHECK(values().count(metric) == 0);
  device.loop.damping_per_stiffness_s = -0.5e-3;
  device.loop.stiffness_limit_N_per_m = 2000;
  device.loop.alpha = 1.0;
  device.loop.alpha_star = 1.03;
  device.loop.cap_N_per_m = INFINITY;
  CHECK(values().at("predicted_stiffness_limit") == 2000);
  CHECK(values().at("alpha") == 1);
  CHECK(values().at("alpha_star") == 1.03);
  CHECK(values().count("stiffness_cap") == 0);
  CHECK(values().count("predicted_damping") == 0);  // no stiffness is known yet
  device.counters["contact_stiffness"] = 400;
  CHECK(values().at("predicted_damping") == Approx(-0.2).epsilon(1e-14));
  device.loop.stiffness_N_per_m = 300;  // the stiffness of the scene takes precedence
  CHECK(values().at("predicted_damping") == Approx(-0.15).epsilon(1e-14));
  device.loop.cap_N_per_m = 100;
  CHECK(values().at("stiffness_cap") == 100);
  CHECK(values().at("predicted_damping") == Approx(-0.05).epsilon(1e-14));
  device.loop.stiffness_limit_N_per_m = INFINITY;  // above alpha* nothing is lost to damping
  CHECK(values().count("predicted_stiffness_limit") == 0);
  CHECK(base_unit("closed_loop.left.direct", "predicted_damping") == "N s/m");
  CHECK(base_unit("closed_loop.left.direct", "loop_delay") == "s");
}

TEST_CASE("the peak to peak of a vector is the diagonal of its box") {
  CHECK(peak_to_peak(std::vector<Vec3>{{0, 0, 0}, {3, 0, 0}, {0, 4, 0}}) == Approx(5));
  CHECK(std::isnan(peak_to_peak({})));
}

TEST_CASE("the signal has its metrics and units") {
  const auto metrics = metrics_of_signal("closed_loop.left.phase_locked");
  REQUIRE(metrics);
  CHECK(std::find(metrics->begin(), metrics->end(), "energy_min") != metrics->end());
  CHECK(base_unit("closed_loop.left.direct", "energy_per_cycle") == "J");
  CHECK(base_unit("closed_loop.left.direct", "rendered_damping") == "N s/m");
  CHECK(base_unit("closed_loop.left.direct", "peak_to_peak") == "m");
  CHECK(base_unit("closed_loop.left.direct", "stable") == "count");
}
