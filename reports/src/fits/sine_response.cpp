#include "src/fits/sine_response.h"

#include <algorithm>
#include <iterator>

#include "src/fits/sine_fit.h"
#include "src/judged.h"
#include "src/vec3.h"

namespace evenstep::internal {
namespace {

const Nominal::Sine* sine_of(const Nominal::Device* device) { return device && device->sine ? &*device->sine : nullptr; }

/// The judged steps from the first one that reads the sine; before that the hand is at rest.
Rows<std::size_t> moving_steps(const StrategyRecord& strategy, const Rows<std::size_t>& steps, const Nominal::Sine& sine) {
  const auto first = std::find_if(steps.begin(), steps.end(), [&](std::size_t n) {
    return seconds(strategy.steps[n].read - RealTime{}) >= sine.begin_s;
  });
  return {first, steps.end(), steps.get_allocator()};
}

}  // namespace

std::optional<SineResponse> interaction_response(const RunRecord& run, const StrategyRecord& strategy,
                                                 const DeviceRecord& device, const Rows<std::size_t>& steps) {
  const Nominal::Sine* sine = sine_of(nominal_device(run.nominal, device.name));
  if (!sine) return std::nullopt;
  const Rows<std::size_t> moving = moving_steps(strategy, steps, *sine);
  if (moving.empty()) return std::nullopt;
  const double slot_s = run.nominal.slot_s;
  const Series series = interaction_series(strategy, device, moving, slot_s);
  const double begin_s = sine->begin_s - simulation_time_s(strategy, moving.front(), slot_s);
  const SineFit fit =
      fit_sine(series.t_s, series.value, sine->amplitude_m, sine->frequency_Hz, begin_s, series.t_s.get_allocator());
  return SineResponse{fit.travel / norm(sine->amplitude_m), fit.delay_s, fit.distortion};
}

std::optional<SineResponse> force_response(const RunRecord& run, const StrategyRecord& strategy, const DeviceRecord& device,
                                           const Rows<std::size_t>& steps, const Rows<std::size_t>& ticks) {
  const Nominal::Device* nominal = nominal_device(run.nominal, device.name);
  const Nominal::Sine* sine = sine_of(nominal);
  if (!sine) return std::nullopt;
  const Rows<std::size_t> moving = moving_steps(strategy, steps, *sine);
  if (moving.empty()) return std::nullopt;
  // Ticks count from the force of the first moving step on.
  const StepRow& first = strategy.steps[moving.front()];
  const RealTime from = std::max(first.emission, first.end);
  Rows<std::size_t> sent(ticks.get_allocator());
  std::copy_if(ticks.begin(), ticks.end(), std::back_inserter(sent),
               [&](std::size_t k) { return sent_at(device.ticks[k]) >= from; });
  if (sent.empty()) return std::nullopt;
  const Series series = force_series(device, sent, run.nominal.judged_from);
  const double begin_s = sine->begin_s - seconds(run.nominal.judged_from - RealTime{});
  const Vec3 pull = minus({}, sine->amplitude_m);  // on the hand: -k x
  const SineFit fit = fit_sine(series.t_s, series.value, pull, sine->frequency_Hz, begin_s, series.t_s.get_allocator());
  SineResponse response{std::nullopt, fit.delay_s, fit.distortion};
  if (nominal->stiffness_N_per_m) response.gain = fit.travel / (*nominal->stiffness_N_per_m * norm(sine->amplitude_m));
  return response;
}

}  // namespace evenstep::internal
