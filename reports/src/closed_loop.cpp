#include "src/closed_loop.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

#include "src/vec3.h"

namespace evenstep {
using internal::kNone;

namespace {

constexpr double kDecay = 0.98;             // over five eighths of the run; a ratio above this is no decay
constexpr double kDecayFromMiddle = 0.992;  // the same decay over two eighths: 0.98^(2/5) = 0.99195
constexpr double kAtRest_m = 5e-6;          // peak to peak; anything less does not count as an oscillation

double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// E at a time between two ticks. There the hand moves along a line and feels one force, so E is linear too.
double energy_at(std::span<const double> t, std::span<const double> energy_J, double at_s) {
  const auto after = std::upper_bound(t.begin(), t.end(), at_s);
  if (after == t.end()) return energy_J.back();
  const auto i = static_cast<std::size_t>(after - t.begin());
  if (i == 0) return energy_J.front();
  return energy_J[i - 1] + (energy_J[i] - energy_J[i - 1]) * ((at_s - t[i - 1]) / (t[i] - t[i - 1]));
}

struct Pull {
  double force_N, stored_J;
};

/// The pull of the spring along one axis: proportional up to its limit, and then constant.
Pull pull_of(const SpringRow& spring, std::size_t axis, double x_m) {
  const double stretch_m = spring.center_m[axis] - x_m, limit_N = spring.limit_N[axis];
  const double k = stretch_m > 0 ? spring.below_N_per_m[axis] : spring.above_N_per_m[axis];
  const double most = k * std::abs(stretch_m);
  if (most <= limit_N) return {k * stretch_m, k * stretch_m * stretch_m / 2};
  return {std::copysign(limit_N, stretch_m), limit_N * std::abs(stretch_m) - limit_N * limit_N / (2 * k)};
}

double stored_J(const SpringRow& spring, const Vec3& x_m) {
  double sum_J = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) sum_J += pull_of(spring, axis, x_m[axis]).stored_J;
  return sum_J;
}

}  // namespace

Vec3 spring_force_N(const SpringRow& spring, const Vec3& x_m) {
  return {pull_of(spring, 0, x_m[0]).force_N, pull_of(spring, 1, x_m[1]).force_N, pull_of(spring, 2, x_m[2]).force_N};
}

Rows<double> port_energy(std::span<const double> t, std::span<const Vec3> x, std::span<const Vec3> force_N, double delay_s,
                         std::span<const SpringRow> springs, const RowAllocator<double>& beside) {
  assert(springs.empty() || (springs.size() == t.size() && delay_s == 0));
  Rows<double> energy_J(t.size(), 0, beside);
  std::size_t felt = 0;  // how many changes the hand has felt: force_N[felt - 1] acts on it
  for (std::size_t n = 1; n < t.size(); ++n) {
    const Vec3 way_m = internal::minus(x[n], x[n - 1]);
    double work_J = 0, from_s = t[n - 1];
    // The part of this interval during which each force is felt.
    while (from_s < t[n]) {
      while (felt < t.size() && t[felt] + delay_s <= from_s) ++felt;
      const double to_s = felt < t.size() ? std::min(t[n], t[felt] + delay_s) : t[n];
      if (felt > 0) work_J += dot(force_N[felt - 1], way_m) * ((to_s - from_s) / (t[n] - t[n - 1]));
      from_s = to_s;
    }
    if (!springs.empty()) {
      const SpringRow& spring = springs[n - 1];
      // The springs' part of the force was not held constant during the tick.
      work_J -= dot(spring_force_N(spring, x[n - 1]), way_m);
      work_J += stored_J(spring, x[n - 1]) - stored_J(spring, x[n]);
    }
    energy_J[n] = energy_J[n - 1] - work_J;
  }
  return energy_J;
}

std::optional<RenderedDamping> rendered_damping(std::span<const double> t, std::span<const double> energy_J, double travel_m,
                                                double frequency_Hz) {
  if (t.empty()) return std::nullopt;
  // The billionth makes a cycle that ends with the last tick count as whole.
  const double cycles = std::floor((t.back() - t.front()) * frequency_Hz * (1 + 1e-9));
  if (cycles < 1 || !(travel_m > 0)) return std::nullopt;
  const double end_s = std::min(t.back(), t.front() + cycles / frequency_Hz);
  const double per_cycle_J = (energy_at(t, energy_J, end_s) - energy_J.front()) / cycles;
  const double amplitude_m = travel_m / 2, omega = 2 * std::numbers::pi * frequency_Hz;
  return RenderedDamping{per_cycle_J, per_cycle_J / (std::numbers::pi * amplitude_m * amplitude_m * omega)};
}

double peak_to_peak(std::span<const Vec3> x) {
  if (x.empty()) return kNone;
  Vec3 least = x.front(), most = x.front();
  for (const Vec3& value : x) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (std::isnan(value[axis])) return kNone;
      least[axis] = std::min(least[axis], value[axis]);
      most[axis] = std::max(most[axis], value[axis]);
    }
  }
  return internal::norm(internal::minus(most, least));
}

bool Oscillation::stable() const {
  return (late_m < kDecay * early_m && late_m < kDecayFromMiddle * middle_m) || late_m < kAtRest_m;
}

std::optional<Oscillation> oscillation(std::span<const double> t, std::span<const Vec3> x, double from_s, double length_s) {
  const auto window = [&](double begin, double end) {
    const auto first = std::lower_bound(t.begin(), t.end(), from_s + begin * length_s);
    const auto last = std::lower_bound(first, t.end(), from_s + end * length_s);
    return x.subspan(static_cast<std::size_t>(first - t.begin()), static_cast<std::size_t>(last - first));
  };
  const std::span<const Vec3> early = window(2.0 / 8, 3.0 / 8), middle = window(5.0 / 8, 6.0 / 8), late = window(7.0 / 8, 1);
  if (early.empty() || middle.empty() || late.empty()) return std::nullopt;
  return Oscillation{peak_to_peak(early), peak_to_peak(middle), peak_to_peak(late)};
}

std::optional<Oscillation> oscillation(const DeviceRecord& device, const Nominal& nominal) {
  Rows<double> t(device.ticks.get_allocator());
  Rows<Vec3> x(device.ticks.get_allocator());
  for (const std::size_t k : internal::judged_ticks(device, nominal)) {
    t.push_back(seconds(internal::sent_at(device.ticks[k]) - nominal.judged_from));
    x.push_back(device.ticks[k].position_m);
  }
  return oscillation(t, x, 0, seconds(nominal.end - nominal.judged_from));
}

namespace internal {
namespace {

/// Adds the predictions of the laws to the measured values. For a tissue, the stiffness is that of the stiffest contact that
/// occurred, if any did.
void put_laws(const DeviceRecord& device, std::map<std::string, double>& values) {
  const LoopRecord& loop = device.loop;
  const auto put = [&](const char* metric, const std::optional<double>& value) {
    if (value && std::isfinite(*value)) values[metric] = *value;
  };
  put("loop_delay", loop.delay_s);
  put("alpha", loop.alpha);
  put("alpha_star", loop.alpha_star);
  put("stiffness_cap", loop.cap_N_per_m);
  put("predicted_stiffness_limit", loop.stiffness_limit_N_per_m);
  std::optional<double> stiffness_N_per_m = loop.stiffness_N_per_m;
  const auto met = device.counters.find("contact_stiffness");
  if (!stiffness_N_per_m && met != device.counters.end()) stiffness_N_per_m = met->second;
  if (!stiffness_N_per_m || !loop.damping_per_stiffness_s) return;
  const double played_N_per_m = std::min(*stiffness_N_per_m, loop.cap_N_per_m.value_or(*stiffness_N_per_m));
  const double own_N_per_m = std::min(loop.alpha.value_or(0) * played_N_per_m, loop.own_N_per_m);
  put("predicted_damping", *loop.damping_per_stiffness_s * played_N_per_m + own_N_per_m * loop.own_gain_s);
}

/// The share of the force, over all ticks, that the device rendered by itself.
std::optional<double> spring_share(const Rows<Vec3>& x, const Rows<Vec3>& force_N, const Rows<SpringRow>& springs) {
  double by_device = 0, all = 0;
  for (std::size_t k = 0; k < springs.size(); ++k) {
    by_device += norm(spring_force_N(springs[k], x[k]));
    all += norm(force_N[k]);
  }
  return all > 0 && !springs.empty() ? std::optional(by_device / all) : std::nullopt;
}

void put_energy(const DeviceRecord& device, const Nominal& run, const Nominal::Device& nominal, std::span<const double> t,
                std::span<const double> energy_J, std::map<std::string, double>& values) {
  Peak extracted;
  for (const double energy : energy_J) extracted.add(-energy);
  values["energy_min"] = -extracted.value;
  values["energy_end"] = energy_J.back();
  if (device.stored_J.value_or(0) > 0) values["energy_released"] = extracted.value / *device.stored_J;
  if (!nominal.sine) return;
  const double begun_s = nominal.sine->begin_s - seconds(run.judged_from - RealTime{0});
  const auto first = static_cast<std::size_t>(std::lower_bound(t.begin(), t.end(), begun_s) - t.begin());
  if (const auto rendered = rendered_damping(t.subspan(first), energy_J.subspan(first), norm(nominal.sine->amplitude_m),
                                             nominal.sine->frequency_Hz)) {
    values["energy_per_cycle"] = rendered->energy_per_cycle_J;
    values["rendered_damping"] = rendered->damping_N_s_per_m;
  }
}

}  // namespace

std::map<std::string, double> closed_loop_values(const RunRecord& run, const DeviceRecord& device) {
  std::map<std::string, double> values;
  put_laws(device, values);
  const Nominal::Device* nominal = nominal_device(run.nominal, device.name);
  const Rows<std::size_t> ticks = judged_ticks(device, run.nominal);
  if (!nominal || ticks.size() < 2) return values;
  const auto beside = device.ticks.get_allocator();
  Rows<double> t(beside);
  Rows<Vec3> x(beside), force_N(beside);
  Rows<SpringRow> springs(beside);
  for (const std::size_t k : ticks) {
    t.push_back(seconds(sent_at(device.ticks[k]) - run.nominal.judged_from));
    x.push_back(device.ticks[k].position_m);
    force_N.push_back(device.ticks[k].force_N);
    if (!device.springs.empty()) springs.push_back(device.springs[k]);
  }
  if (const auto share = spring_share(x, force_N, springs)) values["spring_share"] = *share;
  // If the hand feels the device's springs with a delay, only the device knows how much energy they give and take.
  const bool energy_is_known = springs.empty() || nominal->force_delay.ns == 0;
  if (energy_is_known) {
    put_energy(device, run.nominal, *nominal, t, port_energy(t, x, force_N, seconds(nominal->force_delay), springs, beside),
               values);
  }
  if (!nominal->feels_force) return values;
  const auto swing = oscillation(device, run.nominal);
  if (!swing) return values;
  values["peak_to_peak"] = swing->late_m;
  values["stable"] = swing->stable() ? 1 : 0;
  if (swing->early_m > 0) values["oscillation_ratio"] = swing->late_m / swing->early_m;
  return values;
}

}  // namespace internal
}  // namespace evenstep
