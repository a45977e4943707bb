#include <cmath>
#include <numbers>

#include "catch.h"
#include "evenstep/reports/measures.h"
#include "src/fits/sine_fit.h"
#include "synthetic.h"

using namespace evenstep;

namespace {

const Vec3 kTravel_m{0.02, -0.01, 0.02};  // 0.03 m long

/// `gain` times the motion, `delay_s` late, from another origin.
Vec3 answer(double t, double frequency_Hz, double begin_s, double gain, double delay_s) {
  const double u = (1 - std::cos(2 * std::numbers::pi * frequency_Hz * (t - begin_s - delay_s))) / 2;
  return {3 + gain * kTravel_m[0] * u, -2 + gain * kTravel_m[1] * u, gain * kTravel_m[2] * u};
}

struct Samples {
  std::vector<double> t_s;
  std::vector<Vec3> value;
};
template <class Signal>
Samples sampled(std::size_t count, double rate_Hz, double from_s, Signal signal) {
  Samples samples;
  for (std::size_t i = 0; i < count; ++i) {
    samples.t_s.push_back(from_s + static_cast<double>(i) / rate_Hz);
    samples.value.push_back(signal(samples.t_s.back()));
  }
  return samples;
}

const StrategyRecord& named(const RunRecord& run, const std::string& name) {
  return *std::find_if(run.strategies.begin(), run.strategies.end(), [&](const auto& s) { return s.name == name; });
}

/// The reference run with a hand that moves as a sine from 0.5 s on.
RunRecord sine_run(double frequency_Hz) {
  RunRecord run = synthetic::reference_run({4'000'000'000});
  run.nominal.devices[0].speed_m_per_s.reset();
  run.nominal.devices[0].sine = Nominal::Sine{kTravel_m, frequency_Hz, 0.5};
  for (StrategyRecord& strategy : run.strategies) {
    DeviceRecord& device = strategy.devices[0];
    for (std::size_t n = 0; n < strategy.steps.size(); ++n) {
      const double at = std::max(0.5, seconds(strategy.steps[n].read - RealTime{}));
      device.steps[n].position_m = answer(at, frequency_Hz, 0.5, 1, 0);
      device.steps[n].force_N = synthetic::times(-synthetic::kStiffness_N_per_m, device.steps[n].position_m);
    }
    device.ticks.clear();
    synthetic::add_ticks(strategy, run.nominal.end);
  }
  return run;
}

}  // namespace

TEST_CASE("an exact sine is found exactly, whatever its frequency, phase, gain, start and share of a last period") {
  for (const double frequency_Hz : {0.5, 1.7, 5.0, 40.0}) {
    for (const double periods : {1.0, 1.01, 1.37, 2.5, 7.77}) {
      for (const double delay : {-0.49, -0.1, 0.0, 1e-4, 0.2, 0.5}) {
        for (const double from_s : {0.0, 600.0}) {
          const double delay_s = delay / frequency_Hz, begin_s = 0.123;
          const auto count = static_cast<std::size_t>(std::ceil(periods * 450 / frequency_Hz));
          const Samples s =
              sampled(count, 450, from_s, [&](double t) { return answer(t, frequency_Hz, begin_s, 0.8, delay_s); });
          const internal::SineFit fit = internal::fit_sine(s.t_s, s.value, kTravel_m, frequency_Hz, begin_s);
          CAPTURE(frequency_Hz, periods, delay, from_s);
          // Samples near 3 m are rounded to 2e-16 m, and the amplitude is 0.012 m. Times at 600 s are rounded to 6e-14 s of
          // 25 ms and more. Over one period the fit makes both errors some ten times larger, which is still below 1e-10.
          CHECK(fit.travel == Approx(0.8 * 0.03).epsilon(1e-10));
          CHECK(std::abs(std::remainder((fit.delay_s - delay_s) * frequency_Hz, 1)) < 1e-10);
          CHECK(std::abs(fit.delay_s) * frequency_Hz <= 0.5);
          CHECK(fit.distortion < 1e-9);
        }
      }
    }
  }
}

TEST_CASE("distortion is the share of what is no sine of this frequency: a harmonic of a tenth is 0.1") {
  for (const int harmonic : {2, 3, 5, 17}) {
    const Samples s = sampled(900, 450, 0, [&](double t) {  // four whole periods: harmonics are orthogonal
      const double u =
          std::cos(2 * std::numbers::pi * 2 * t) + 0.1 * std::sin(2 * std::numbers::pi * 2 * harmonic * t + 0.3);
      return Vec3{u, 0, 0};
    });
    const internal::SineFit fit = internal::fit_sine(s.t_s, s.value, {1, 0, 0}, 2, 0);
    CHECK(fit.distortion == Approx(0.1).epsilon(1e-12));
    CHECK(fit.travel == Approx(2).epsilon(1e-12));
  }
}

TEST_CASE("only the motion's own direction counts, and its sign") {
  const Samples s = sampled(900, 450, 0, [](double t) {
    Vec3 x = answer(t, 2, 0, 1, 0.01);
    x[0] += 0.5 * std::cos(31 * t), x[2] -= 0.5 * std::cos(31 * t);  // across kTravel_m
    return x;
  });
  const internal::SineFit along = internal::fit_sine(s.t_s, s.value, kTravel_m, 2, 0);
  CHECK(along.distortion < 1e-9);
  CHECK(along.delay_s == Approx(0.01).epsilon(1e-9));
  const internal::SineFit against = internal::fit_sine(s.t_s, s.value, {-0.2, 0.1, -0.2}, 2, 0);
  CHECK(against.delay_s == Approx(0.01 - 0.25).epsilon(1e-9));  // half a period off
  CHECK(against.travel == Approx(0.03).epsilon(1e-9));
}

TEST_CASE("less than one period, or one or two samples per period, judge nothing") {
  const auto fit = [](std::size_t count, double rate_Hz) {
    const Samples s = sampled(count, rate_Hz, 0, [](double t) { return answer(t, 5, 0, 1, 0.003); });
    return internal::fit_sine(s.t_s, s.value, kTravel_m, 5, 0);
  };
  CHECK(fit(90, 450).travel == Approx(0.03));
  for (const auto& none : {fit(89, 450), fit(40, 5), fit(40, 10), fit(2, 2), fit(0, 450)}) {
    CHECK(std::isnan(none.travel));
    CHECK(std::isnan(none.delay_s));
    CHECK(std::isnan(none.distortion));
  }
  CHECK(fit(40, 15.1).travel == Approx(0.03));  // three samples per period are enough
}

TEST_CASE("a signal that stands still has gain 0, and neither delay nor distortion") {
  const Samples s = sampled(900, 450, 0, [](double) { return Vec3{1, 2, 3}; });
  const internal::SineFit fit = internal::fit_sine(s.t_s, s.value, kTravel_m, 2, 0);
  CHECK(fit.travel == 0);
  CHECK(std::isnan(fit.delay_s));
  CHECK(std::isnan(fit.distortion));
}

TEST_CASE("interaction: an even map has gain 1, delays by its lead and leaves nothing, direct distorts") {
  for (const double frequency_Hz : {0.7, 2.0, 4.3}) {
    Metrics metrics = measure(sine_run(frequency_Hz));
    for (const char* name : {"paper", "phase_locked", "ideal"}) {
      auto& values = metrics.at(std::string("left.interaction.") + name);
      CHECK(values.at("gain") == Approx(1).epsilon(1e-6));  // R is floored to 1 ns, 2.7e-8 rad at 4.3 Hz
      CHECK(values.at("phase_delay") == Approx(260'000e-9).margin(1e-9));
      CHECK(values.at("distortion") < 1e-6);
    }
    auto& direct = metrics.at("left.interaction.direct");
    // Step i of a segment reads V (1 - i / 15) after its slot, on average 16/30 V. Where periods are not whole numbers of
    // segments, the fit weighs phases unevenly, by 2 pi f V at most.
    CHECK(direct.at("phase_delay") == Approx(-11.1e-3 * 16 / 30).epsilon(0.1));
    // The saw tooth of +-V/2 has an RMS of V / sqrt 12, times 2 pi f.
    CHECK(direct.at("distortion") == Approx(2 * std::numbers::pi * frequency_Hz * 11.1e-3 / std::sqrt(12)).epsilon(0.1));
  }
}

TEST_CASE("force: against k A, behind the hand by the latency and hold's half slot") {
  for (const double frequency_Hz : {0.7, 2.0, 4.3}) {
    RunRecord run = sine_run(frequency_Hz);
    Metrics metrics = measure(run);
    const auto& values = metrics.at("left.force.paper");
    // 20 ticks fall on 9 slots. So the mean age of what is sent is half a slot, to within half of slot / 9.
    CHECK(values.at("phase_delay") == Approx(12.842223e-3 + synthetic::kSlot_s / 2).margin(synthetic::kSlot_s / 18));
    CHECK(values.at("gain") ==
          Approx(1).margin(std::pow(std::numbers::pi * frequency_Hz * synthetic::kSlot_s, 2) / 6 + 1e-4));
    // The staircase differs from the sine by a saw tooth of one slot.
    CHECK(values.at("distortion") ==
          Approx(2 * std::numbers::pi * frequency_Hz * synthetic::kSlot_s / std::sqrt(12)).epsilon(0.1));
    run.nominal.devices[0].stiffness_N_per_m.reset();  // a tissue: the right force is not known
    metrics = measure(run);
    CHECK(metrics.at("left.force.paper").count("gain") == 0);
    CHECK(metrics.at("left.force.paper").at("phase_delay") > 0.012);
  }
}

TEST_CASE("the rest before a sine begins is not fitted, a sine never read has no value, other motions have none") {
  RunRecord run = sine_run(2);
  const double delay_s = measure(run).at("left.interaction.paper").at("phase_delay");
  for (StepSample& step : run.strategies[2].devices[0].steps) {
    const auto n = static_cast<std::size_t>(&step - run.strategies[2].devices[0].steps.data());
    if (seconds(named(run, "paper").steps[n].read - RealTime{}) < 0.5) step.position_m = {9, 9, 9};
  }
  CHECK(measure(run).at("left.interaction.paper").at("phase_delay") == delay_s);
  run.nominal.devices[0].sine->begin_s = 10;
  CHECK(measure(run).at("left.interaction.paper").count("gain") == 0);
  CHECK(measure(run).at("left.force.paper").count("phase_delay") == 0);
  run.nominal.devices[0].sine.reset();
  CHECK(measure(run).at("left.interaction.paper").count("phase_delay") == 0);
}
