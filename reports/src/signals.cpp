#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "evenstep/reports/measures.h"
#include "src/judged.h"

namespace evenstep {
namespace {

struct MetricUnit {
  std::string_view metric, unit;
  bool shape = false;  ///< about the shape of the signal, so it says nothing if the signal is saturated
};
constexpr bool kShape = true;

constexpr std::array kInteraction = std::to_array<MetricUnit>({{"judged", "count"},
                                                               {"straight", "count"},
                                                               {"saturated", "count"},
                                                               {"velocity_jump", "m", kShape},
                                                               {"deviation_max", "m", kShape},
                                                               {"deviation_rms", "m", kShape},
                                                               {"step_ratio_max", "1", kShape},
                                                               {"step_ratio_min", "1", kShape},
                                                               {"back_steps", "count"},
                                                               {"latency_min", "s"},
                                                               {"latency_mean", "s"},
                                                               {"latency_max", "s"},
                                                               {"underruns", "count"},
                                                               {"underrun_rate", "1"},
                                                               {"overruns", "count"},
                                                               {"error_at_stop", "m", kShape},
                                                               {"error_max", "m", kShape},
                                                               {"deviation_growth", "1", kShape},
                                                               {"deviation_growth_min", "1", kShape},
                                                               {"error_growth", "1", kShape},
                                                               {"error_growth_min", "1", kShape},
                                                               {"gain", "1", kShape},
                                                               {"phase_delay", "s", kShape},
                                                               {"distortion", "1", kShape}});
constexpr std::array kForce = std::to_array<MetricUnit>({{"judged", "count"},
                                                         {"straight", "count"},
                                                         {"saturated", "count"},
                                                         {"velocity_jump", "N", kShape},
                                                         {"deviation_max", "N", kShape},
                                                         {"deviation_rms", "N", kShape},
                                                         {"jump_max", "N", kShape},
                                                         {"error_max", "N", kShape},
                                                         {"error_rms", "N", kShape},
                                                         {"error_share", "1", kShape},
                                                         {"error_at_stop", "N", kShape},
                                                         {"onset_delay", "s", kShape},
                                                         {"ghost_force", "N", kShape},
                                                         {"residual_20_500_hz", "N", kShape},
                                                         {"deviation_from_ideal", "N", kShape},
                                                         {"deviation_growth", "1", kShape},
                                                         {"deviation_growth_min", "1", kShape},
                                                         {"error_growth", "1", kShape},
                                                         {"error_growth_min", "1", kShape},
                                                         {"deviation_from_ideal_growth", "1", kShape},
                                                         {"deviation_from_ideal_growth_min", "1", kShape},
                                                         {"schedule_latency", "s"},
                                                         {"schedule_latency_min", "s"},
                                                         {"schedule_latency_mean", "s"},
                                                         {"schedule_latency_p50", "s"},
                                                         {"schedule_latency_spread", "s"},
                                                         {"total_latency", "s"},
                                                         {"total_latency_min", "s"},
                                                         {"total_latency_mean", "s"},
                                                         {"late", "count"},
                                                         {"underruns", "count"},
                                                         {"underrun_rate", "1"},
                                                         {"felt", "count"},
                                                         {"emission_repairs", "count"},
                                                         {"latency_growths", "count"},
                                                         {"clamped", "count"},
                                                         {"slewed", "count"},
                                                         {"non_finite", "count"},
                                                         {"reports", "count"},
                                                         {"lost", "count"},
                                                         {"malformed", "count"},
                                                         {"stale", "count"},
                                                         {"write_failures", "count"},
                                                         {"pid_refreshes", "count"},
                                                         {"pid_saturated", "count"},
                                                         {"pid_unpowered", "count"},
                                                         {"pid_pool_unknown", "count"},
                                                         {"pid_cuts_paused", "count"},
                                                         {"pid_cuts_actuators", "count"},
                                                         {"pid_cuts_switch", "count"},
                                                         {"pid_cuts_power", "count"},
                                                         {"evdev_refreshes", "count"},
                                                         {"evdev_saturated", "count"},
                                                         {"evdev_dropped", "count"},
                                                         {"evdev_waited", "count"},
                                                         {"cuts_device", "count"},
                                                         {"cuts_stale_hand", "count"},
                                                         {"cuts_stale_force", "count"},
                                                         {"cuts_speed", "count"},
                                                         {"writes", "count"},
                                                         {"writes_overtaken", "count"},
                                                         {"writes_rejected", "count"},
                                                         {"unplugged", "count"},
                                                         {"write_time_p50", "s"},
                                                         {"write_time_p99", "s"},
                                                         {"write_time_max", "s"},
                                                         {"motors_max", "N"},
                                                         {"motors_max_x", "N"},
                                                         {"motors_max_y", "N"},
                                                         {"motors_max_z", "N"},
                                                         {"motors_left", "N"},
                                                         {"motors_unrenewed", "s"},
                                                         {"effects_ended", "count"},
                                                         {"contact_stiffness", "N/m"},
                                                         {"softened", "count"},
                                                         {"gain", "1", kShape},
                                                         {"phase_delay", "s", kShape},
                                                         {"distortion", "1", kShape}});
constexpr std::array kBuffers = std::to_array<MetricUnit>({{"interaction_capacity", "count"},
                                                           {"force_capacity", "count"},
                                                           {"underruns", "count"},
                                                           {"interaction_underruns", "count"},
                                                           {"force_underruns", "count"},
                                                           {"underrun_rate", "1"},
                                                           {"overruns", "count"},
                                                           {"predicted_interaction_underruns", "count"},
                                                           {"predicted_late_forces", "count"},
                                                           {"lead", "s"},
                                                           {"latency", "s"},
                                                           {"latency_any_phase", "s"},
                                                           {"latency_this_phase", "s"},
                                                           {"gated", "count"},
                                                           {"gate_wait", "s"},
                                                           {"interaction_lateness_max", "s"},
                                                           {"force_lateness_max", "s"}});
constexpr std::array kClosedLoop = std::to_array<MetricUnit>({{"energy_min", "J"},
                                                              {"energy_end", "J"},
                                                              {"energy_per_cycle", "J", kShape},
                                                              {"energy_released", "1"},
                                                              {"rendered_damping", "N s/m", kShape},
                                                              {"peak_to_peak", "m"},
                                                              {"oscillation_ratio", "1"},
                                                              {"stable", "count"},
                                                              {"loop_delay", "s"},
                                                              {"alpha", "1"},
                                                              {"alpha_star", "1"},
                                                              {"spring_share", "1"},
                                                              {"stiffness_cap", "N/m"},
                                                              {"predicted_damping", "N s/m"},
                                                              {"predicted_stiffness_limit", "N/m"}});
constexpr std::array kSolver = std::to_array<MetricUnit>({{"energy_growth", "1"},
                                                          {"non_finite", "count"},
                                                          {"first_bad_step", "count"},
                                                          {"step_size_over_limit", "1"},
                                                          {"substeps", "count"},
                                                          {"particles", "count"},
                                                          {"step_limit", "s"},
                                                          {"rest_state_step_limit", "s"},
                                                          {"k_max", "N/m"},
                                                          {"limit_particle", "count"},
                                                          {"iterations", "count"},
                                                          {"solver_seconds", "s"},
                                                          {"steps_over_limit", "count"},
                                                          {"step_over_limit_max", "1"},
                                                          {"segment_mean", "s"}});
constexpr std::array kEvents = std::to_array<MetricUnit>({{"sometimes", "count"},
                                                          {"lateness_p50", "s"},
                                                          {"lateness_p99", "s"},
                                                          {"lateness_max", "s"},
                                                          {"ticks_run", "count"},
                                                          {"deadline_misses", "count"},
                                                          {"deadline_miss_share", "1"}});
constexpr std::array kRun = std::to_array<MetricUnit>(
    {{"judged_s", "s"}, {"real_time_granted", "count"}, {"strategies", "count"}, {"left_out", "count"}});

// First the metrics of statuses and schedules, then those of the kinds of cases.
constexpr std::array kCase = std::to_array<MetricUnit>({{"cells", "count"},
                                                        {"ok", "count"},
                                                        {"damped", "count"},
                                                        {"drifting", "count"},
                                                        {"refused", "count"},
                                                        {"diverged", "count"},
                                                        {"unavailable", "count"},
                                                        {"interrupted", "count"},
                                                        {"schedule_difference", "count"},
                                                        {"closed_form_error", "1"},
                                                        {"energy_over_bound", "1"},
                                                        {"energy_left", "1"},
                                                        {"energy_left_min", "1"},
                                                        {"order", "1"},
                                                        {"order_min", "1"},
                                                        {"error", "1"},
                                                        {"step_s", "s"},
                                                        {"momentum_error", "1"},
                                                        {"restitution", "1"},
                                                        {"restitution_min", "1"},
                                                        {"bounces_min", "count"},
                                                        {"reaction_error", "1"},
                                                        {"limit_scaling", "1"},
                                                        {"limit_scaling_min", "1"},
                                                        {"stiffest_named_min", "count"},
                                                        {"energy_swing", "1"},
                                                        {"energy_trend", "1"},
                                                        {"speed_error", "1"},
                                                        {"device_difference", "count"},
                                                        {"numbering_difference", "1"},
                                                        {"step_over_limit", "1"}});

using Table = std::span<const MetricUnit>;

std::vector<std::string_view> parts_of(std::string_view signal) {
  std::vector<std::string_view> parts;
  for (std::size_t begin = 0;;) {
    const std::size_t dot = signal.find('.', begin);
    parts.push_back(signal.substr(begin, dot - begin));
    if (dot == std::string_view::npos) return parts;
    begin = dot + 1;
  }
}

/// The tables for a form of signal; `*` as the middle one of three parts stands for every kind of device signal.
std::vector<Table> tables_of(std::string_view signal) {
  const std::vector<std::string_view> parts = parts_of(signal);
  if (std::find(parts.begin(), parts.end(), "") != parts.end()) return {};
  if (parts.size() == 1 && parts[0] == "run") return {kRun};
  if (parts.size() == 2 && parts[0] == "solver") return {kSolver};
  if (parts.size() != 3) return {};
  if (parts[0] == "case") return {kCase};
  if (parts[0] == "closed_loop") return {kClosedLoop};
  if (parts[0] == "events") {
    const bool lane = parts[1] == "completion" || parts[1] == "device" || parts[1] == "launch" || parts[1] == "*";
    return lane ? std::vector<Table>{kEvents} : std::vector<Table>{};
  }
  if (parts[1] == "interaction") return {kInteraction};
  if (parts[1] == "force") return {kForce};
  if (parts[1] == "buffers") return {kBuffers};
  if (parts[1] == "*") return {kInteraction, kForce, kBuffers};
  return {};
}

}  // namespace

std::optional<std::vector<std::string>> metrics_of_signal(const std::string& signal) {
  const std::vector<Table> tables = tables_of(signal);
  if (tables.empty()) return std::nullopt;
  std::vector<std::string> names;
  for (const Table table : tables) {
    for (const MetricUnit& row : table) {
      if (std::find(names.begin(), names.end(), row.metric) == names.end()) names.emplace_back(row.metric);
    }
  }
  return names;
}

std::string base_unit(const std::string& signal, const std::string& metric) {
  std::string unit;
  for (const Table table : tables_of(signal)) {
    for (const MetricUnit& row : table) {
      if (row.metric != metric) continue;
      if (!unit.empty() && unit != row.unit) return "";  // "*" matches metrics in m and in N
      unit = row.unit;
    }
  }
  return unit;
}

bool judges_shape(const std::string& signal, const std::string& metric) {
  for (const Table table : tables_of(signal)) {
    for (const MetricUnit& row : table) {
      if (row.metric == metric && row.shape) return true;
    }
  }
  return false;
}

std::optional<double> step_unit(const Nominal& nominal, const std::string& signal) {
  const std::vector<std::string_view> parts = parts_of(signal);
  if (parts.size() != 3) return std::nullopt;
  const Nominal::Device* device = internal::nominal_device(nominal, std::string(parts[0]));
  if (!device || !device->speed_m_per_s) return std::nullopt;
  const double step_m = std::abs(*device->speed_m_per_s) * nominal.slot_s;
  if (!(step_m > 0)) return std::nullopt;
  if (parts[1] == "interaction") return step_m;
  if (parts[1] == "force" && device->stiffness_N_per_m) return *device->stiffness_N_per_m * step_m;
  return std::nullopt;
}

}  // namespace evenstep
