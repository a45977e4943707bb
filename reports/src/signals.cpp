#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "evenstep/reports/measures.h"
#include "src/judged.h"

namespace evenstep {
namespace {

/// What is true of a metric, as bits. Without kLess and kMore nobody can say which way is better without the scenario.
enum : unsigned {
  kShape = 1,  ///< about the shape of the signal, so it says nothing if the signal is saturated
  kLess = 2,   ///< less is better
  kMore = 4,   ///< more is better
  kTimed = 8,  ///< how long something took here: another number in every run
};
struct MetricUnit {
  std::string_view metric, unit;
  unsigned traits = 0;
};

// Several rows to a line.
// clang-format off
constexpr std::array kInteraction = std::to_array<MetricUnit>({
    {"judged", "count"}, {"straight", "count"}, {"saturated", "count", kLess}, {"velocity_jump", "m", kShape | kLess},
    {"deviation_max", "m", kShape | kLess}, {"deviation_rms", "m", kShape | kLess},
    {"step_ratio_max", "1", kShape | kLess}, {"step_ratio_min", "1", kShape | kMore}, {"back_steps", "count", kLess},
    {"latency_min", "s", kLess}, {"latency_mean", "s", kLess}, {"latency_max", "s", kLess}, {"underruns", "count", kLess},
    {"underrun_rate", "1", kLess}, {"overruns", "count", kLess}, {"error_at_stop", "m", kShape | kLess},
    {"error_max", "m", kShape | kLess}, {"deviation_growth", "1", kShape | kLess},
    {"deviation_growth_min", "1", kShape | kLess}, {"error_growth", "1", kShape | kLess},
    {"error_growth_min", "1", kShape | kLess}, {"gain", "1", kShape}, {"phase_delay", "s", kShape},
    {"distortion", "1", kShape | kLess},
});
constexpr std::array kForce = std::to_array<MetricUnit>({
    {"judged", "count"}, {"straight", "count"}, {"saturated", "count", kLess}, {"velocity_jump", "N", kShape | kLess},
    {"deviation_max", "N", kShape | kLess}, {"deviation_rms", "N", kShape | kLess}, {"jump_max", "N", kShape | kLess},
    {"rise_max", "N", kShape | kLess}, {"error_max", "N", kShape | kLess}, {"error_rms", "N", kShape | kLess},
    {"error_share", "1", kShape | kLess}, {"error_at_stop", "N", kShape | kLess}, {"onset_delay", "s", kShape},
    {"ghost_force", "N", kShape | kLess}, {"residual_20_500_hz", "N", kShape | kLess},
    {"deviation_from_ideal", "N", kShape | kLess}, {"deviation_growth", "1", kShape | kLess},
    {"deviation_growth_min", "1", kShape | kLess}, {"error_growth", "1", kShape | kLess},
    {"error_growth_min", "1", kShape | kLess}, {"deviation_from_ideal_growth", "1", kShape | kLess},
    {"deviation_from_ideal_growth_min", "1", kShape | kLess}, {"schedule_latency", "s", kLess},
    {"schedule_latency_min", "s", kLess}, {"schedule_latency_mean", "s", kLess}, {"schedule_latency_p50", "s", kLess},
    {"schedule_latency_spread", "s", kLess}, {"total_latency", "s", kLess}, {"total_latency_min", "s", kLess},
    {"total_latency_mean", "s", kLess}, {"animation_error", "s", kLess}, {"animation_error_mean", "s", kLess},
    {"source_lost", "count", kLess}, {"source_reordered", "count", kLess}, {"late", "count", kLess},
    {"underruns", "count", kLess}, {"underrun_rate", "1", kLess}, {"felt", "count", kLess}, {"recovery_time", "s", kLess},
    {"recovery_time_underruns", "s", kLess}, {"recovery_time_latency", "s", kLess}, {"recovery_time_jump", "s", kLess},
    {"recovered", "count", kMore}, {"emission_repairs", "count", kLess}, {"latency_growths", "count", kLess},
    {"clamped", "count", kLess}, {"slewed", "count", kLess}, {"non_finite", "count", kLess}, {"reports", "count"},
    {"lost", "count", kLess}, {"malformed", "count", kLess}, {"stale", "count", kLess}, {"write_failures", "count", kLess},
    {"reports_overtaken", "count", kLess}, {"forces", "count"}, {"forces_sent", "count"},
    {"forces_overtaken", "count", kLess}, {"forces_dropped", "count", kLess}, {"forces_pending", "count"},
    {"ticks_unforced", "count"}, {"ticks_underrun", "count", kLess}, {"ticks_overrun", "count", kLess},
    {"sample_age_p50", "s", kLess}, {"sample_age_p99", "s", kLess}, {"sample_age_max", "s", kLess},
    {"ages_capped", "count", kLess}, {"clock_rate_error", "1"}, {"clock_residual", "s", kLess},
    {"clock_ahead", "count", kLess}, {"clock_ahead_max", "s", kLess}, {"clock_restarts", "count", kLess},
    {"pid_refreshes", "count"}, {"pid_saturated", "count", kLess}, {"pid_unpowered", "count", kLess},
    {"pid_pool_unknown", "count", kLess}, {"pid_cuts_paused", "count", kLess}, {"pid_cuts_actuators", "count", kLess},
    {"pid_cuts_switch", "count", kLess}, {"pid_cuts_power", "count", kLess}, {"evdev_refreshes", "count"},
    {"evdev_saturated", "count", kLess}, {"evdev_dropped", "count", kLess}, {"evdev_waited", "count", kLess},
    {"evdev_untimed", "count", kLess}, {"inverse3_absent", "count", kLess}, {"inverse3_uncalibrated", "count", kLess},
    {"cuts_device", "count", kLess}, {"cuts_stale_hand", "count", kLess}, {"cuts_stale_force", "count", kLess},
    {"cuts_speed", "count", kLess}, {"writes", "count"}, {"writes_overtaken", "count", kLess},
    {"writes_rejected", "count", kLess}, {"unplugged", "count", kLess}, {"write_time_p50", "s", kLess},
    {"write_time_p99", "s", kLess}, {"write_time_max", "s", kLess}, {"motors_max", "N"}, {"motors_max_x", "N"},
    {"motors_max_y", "N"}, {"motors_max_z", "N"}, {"motors_left", "N", kLess}, {"motors_away", "N", kLess},
    {"motors_unrenewed", "s", kLess}, {"effects_ended", "count", kLess}, {"contact_stiffness", "N/m"},
    {"softened", "count"}, {"gain", "1", kShape}, {"phase_delay", "s", kShape}, {"distortion", "1", kShape | kLess},
});
constexpr std::array kBuffers = std::to_array<MetricUnit>({
    {"interaction_capacity", "count"}, {"force_capacity", "count"}, {"underruns", "count", kLess},
    {"interaction_underruns", "count", kLess}, {"force_underruns", "count", kLess}, {"underrun_rate", "1", kLess},
    {"overruns", "count", kLess}, {"predicted_interaction_underruns", "count", kLess},
    {"predicted_late_forces", "count", kLess}, {"lead", "s", kLess}, {"latency", "s", kLess},
    {"latency_any_phase", "s", kLess}, {"latency_this_phase", "s", kLess}, {"least_entries", "count", kLess},
    {"played_age", "s", kLess},
    {"gated", "count", kLess}, {"gate_wait", "s", kLess}, {"interaction_lateness_max", "s", kLess},
    {"force_lateness_max", "s", kLess},
});
constexpr std::array kClosedLoop = std::to_array<MetricUnit>({
    {"energy_min", "J", kMore}, {"energy_end", "J"}, {"energy_per_cycle", "J", kShape | kMore},
    {"energy_released", "1", kLess}, {"rendered_damping", "N s/m", kShape | kMore}, {"peak_to_peak", "m", kLess},
    {"oscillation_ratio", "1", kLess}, {"stable", "count", kMore}, {"loop_delay", "s", kLess}, {"alpha", "1"},
    {"alpha_star", "1"}, {"spring_share", "1"}, {"stiffness_cap", "N/m"}, {"predicted_damping", "N s/m", kMore},
    {"predicted_stiffness_limit", "N/m", kMore},
});
constexpr std::array kSolver = std::to_array<MetricUnit>({
    {"energy_growth", "1", kLess}, {"non_finite", "count", kLess}, {"first_bad_step", "count"},
    {"step_size_over_limit", "1", kLess}, {"substeps", "count"}, {"particles", "count"}, {"step_limit", "s", kMore},
    {"rest_state_step_limit", "s", kMore}, {"k_max", "N/m", kMore}, {"limit_particle", "count"}, {"iterations", "count"},
    {"solver_seconds", "s", kLess | kTimed}, {"steps_begun", "count"}, {"steps_not_begun", "count", kLess},
    {"steps_over_limit", "count", kLess}, {"step_over_limit_max", "1", kLess}, {"segment_mean", "s"},
    {"drawing_rate", "Hz", kMore}, {"drawings_left_out", "count", kLess}, {"drawing_pause_max", "s", kLess},
    {"drawing_interval_max", "s", kLess}, {"steps_dropped", "count", kLess}, {"simulated_per_real", "1"},
});
constexpr std::array kEvents = std::to_array<MetricUnit>({
    {"sometimes", "count"}, {"lateness_p50", "s", kLess}, {"lateness_p99", "s", kLess}, {"lateness_p999", "s", kLess},
    {"lateness_max", "s", kLess}, {"ticks_run", "count"}, {"deadline_misses", "count", kLess},
    {"deadline_miss_share", "1", kLess},
});
constexpr std::array kRun = std::to_array<MetricUnit>({
    {"judged_s", "s"}, {"real_time_granted", "count", kMore}, {"strategies", "count"}, {"left_out", "count"},
});

// First the metrics of statuses and schedules, then those of the kinds of cases.
constexpr std::array kCase = std::to_array<MetricUnit>({
    {"cells", "count"}, {"ok", "count", kMore}, {"damped", "count"}, {"drifting", "count", kLess}, {"refused", "count"},
    {"diverged", "count", kLess}, {"unavailable", "count", kLess}, {"interrupted", "count", kLess},
    {"schedule_difference", "count", kLess}, {"closed_form_error", "1", kLess}, {"energy_over_bound", "1", kLess},
    {"energy_left", "1"}, {"energy_left_min", "1"}, {"order", "1", kMore}, {"order_min", "1", kMore},
    {"error", "1", kLess}, {"step_s", "s"}, {"momentum_error", "1", kLess}, {"restitution", "1"}, {"restitution_min", "1"},
    {"bounces_min", "count"}, {"reaction_error", "1", kLess}, {"limit_scaling", "1"}, {"limit_scaling_min", "1"},
    {"stiffest_named_min", "count", kMore}, {"energy_swing", "1", kLess}, {"energy_trend", "1"},
    {"speed_error", "1", kLess}, {"device_difference", "count", kLess}, {"numbering_difference", "1", kLess},
    {"step_over_limit", "1", kLess},
});
// clang-format on

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

unsigned traits_of(const std::string& signal, const std::string& metric) {
  unsigned traits = 0;
  for (const Table table : tables_of(signal)) {
    for (const MetricUnit& row : table) {
      if (row.metric == metric) traits |= row.traits;
    }
  }
  return traits;
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

bool judges_shape(const std::string& signal, const std::string& metric) { return traits_of(signal, metric) & kShape; }

Better better_of(const std::string& signal, const std::string& metric) {
  const unsigned traits = traits_of(signal, metric);
  return traits & kLess ? Better::less : traits & kMore ? Better::more : Better::neither;
}

bool is_timed(const std::string& signal, const std::string& metric) { return traits_of(signal, metric) & kTimed; }

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
