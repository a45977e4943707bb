#pragma once
/// Numbers about a finished run. docs/reference/metrics.md has the exact definitions; names and units may be added but never
/// change. Every metric that has a value is computed, whether an expectation asks for it or not. Only the growths of errors,
/// which are fits and take longer than all others together, are added where they are wanted.

#include <array>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "evenstep/reports/growth.h"
#include "evenstep/reports/run_record.h"

namespace evenstep {

/// metrics[signal][metric] = value in SI base units (s, m, N) or a plain count. Signals: "<device>.interaction.<strategy>",
/// "<device>.force.<strategy>", "<device>.buffers.<strategy>", "closed_loop.<device>.<strategy>", "solver.<strategy>",
/// "events.<lane>.<name>", "run".
using Metrics = std::map<std::string, std::map<std::string, double>>;
/// A metric of a signal; 0 where it has none, as for what nothing counted.
double value_or_0(const Metrics& metrics, const std::string& signal, const std::string& metric);
Metrics measure(const RunRecord& run);
/// Adds "<error>_growth" and "<error>_growth_min" of each error that can be fitted (growth.h).
void add_growths(const RunRecord& run, Metrics& metrics);
/// Whether it is one of these metrics.
bool is_growth(std::string_view metric);

/// All metrics that a signal of this form can have, whether or not this run has values for them. So a metric that has judged
/// no sample can be told from a misspelt one; an expectation on it is an error, never a pass. Empty if the form of the
/// signal is unknown.
std::optional<std::vector<std::string>> metrics_of_signal(const std::string& signal);

/// The unit `step`: the size of the ideal change of the signal per slot, v * slot or k * v * slot, in the signal's own unit
/// (m or N). Empty if there is no nominal speed (or, for a force, no stiffness); using `step` as a unit is then an error.
std::optional<double> step_unit(const Nominal& nominal, const std::string& signal);
/// The unit in which a metric is measured: "m", "N", "s", "J", "N s/m", "count" or "1".
std::string base_unit(const std::string& signal, const std::string& metric);
/// Whether a metric is about the shape of the signal, so that it says nothing about a saturated one (saturation.h).
bool judges_shape(const std::string& signal, const std::string& metric);
/// Which way a metric gets better, whatever the scenario. `neither`: that depends on the scenario (a gain, a count of
/// steps).
enum class Better : std::uint8_t { neither, less, more };
Better better_of(const std::string& signal, const std::string& metric);
/// Whether a metric says how long something took on this machine, so that it differs from run to run.
bool is_timed(const std::string& signal, const std::string& metric);

// The measures themselves, on plain series.

/// max |x(n+1) - 2 x(n) + x(n-1)|
double velocity_jump(std::span<const Vec3> x);
struct Deviation {
  double max = 0;
  double rms = 0;
};
/// Residual of the least-squares line through the vector in each of the non-overlapping windows of `window_s`. A last window
/// shorter than half of that is joined with the one before. `t` in s, increasing.
Deviation deviation(std::span<const double> t, std::span<const Vec3> x, double window_s);
/// The largest change between two neighbouring samples.
double jump_max(std::span<const Vec3> x);
/// The largest growth of the length from one sample to the next; 0 if it never grows.
double rise_max(std::span<const Vec3> x);
/// RMS of x in the band [low, high] Hz, detrended per window. The band is exact: it is cut out of the DFT of each window, so
/// no filter has to settle.
double band_rms(std::span<const double> t, std::span<const Vec3> x, double window_s, double low_Hz, double high_Hz);
/// The energy in J that the hand has put into the device, at each tick since the first: E(n) = -sum of F . dx, where F is
/// the force felt on the way (sent `delay_s` earlier; before the first one it is unknown and counts as none) and dx the way
/// between two ticks. If it is negative, more came out than went in. `t` in s, increasing. With `springs` (one per tick, or
/// none; only without a delay) the springs' part of the force follows the hand until the next tick, as if they were rendered
/// at every instant. The result is kept in the files of `beside` (rows.h).
Rows<double> port_energy(std::span<const double> t, std::span<const Vec3> x, std::span<const Vec3> force_N, double delay_s,
                         std::span<const SpringRow> springs = {}, const RowAllocator<double>& beside = {});
/// The springs' force on a hand at `x_m`, N.
Vec3 spring_force_N(const SpringRow& spring, const Vec3& x_m);
/// The damping that a sine motion with the peak-to-peak travel `travel_m` meets: the energy E per cycle, over the whole
/// cycles from the first tick on, and the damper that would take as much, b = E / (pi (travel / 2)^2 2 pi f). If it is
/// negative, the loop drives the hand. Empty for less than a cycle.
struct RenderedDamping {
  double energy_per_cycle_J = 0, damping_N_s_per_m = 0;
};
std::optional<RenderedDamping> rendered_damping(std::span<const double> t, std::span<const double> energy_J, double travel_m,
                                                double frequency_Hz);
/// The diagonal of the smallest box that contains all positions.
double peak_to_peak(std::span<const Vec3> x);
/// Peak to peak in the third, the sixth and the last eighth of a run; for 8 s these are 2 s to 3 s, 5 s to 6 s and 7 s to 8
/// s.
struct Oscillation {
  double early_m = 0, middle_m = 0, late_m = 0;
  /// Whether late < 0.98 early and late < 0.98^(2/5) middle, or late < 5 um. The middle is checked for the same rate of
  /// decay, because an oscillation that a force limit bounds can overshoot once and then stay. False if a value is not a
  /// number.
  bool stable() const;
};
std::optional<Oscillation> oscillation(std::span<const double> t, std::span<const Vec3> x, double from_s, double length_s);
/// The oscillation of a device during its judged ticks.
std::optional<Oscillation> oscillation(const DeviceRecord& device, const Nominal& nominal);

/// The bins of a run, in real time: [origin + b * width, + width) for b < count, the last one to the end of the run.
struct BinLayout {
  RealTime origin;
  Duration width;
  std::int64_t count = 0;
};
/// Bins follow the length of the judged time: 60 to 119 bins of whole segments, or of whole ways there and back if a device
/// goes back and forth at least twenty times. There are fewer bins if there are fewer segments (or ways), and twenty parts
/// of the time if there are not even twenty segments. In every bin at least four steps (or ticks) fit.
BinLayout bin_layout(const RunRecord& run);

/// Error over the time of the run: one row per bin and signal.
struct BinRow {
  double from_s = 0, to_s = 0;
  double deviation_max = 0, deviation_rms = 0, velocity_jump = 0;
  std::optional<double> error_rms = {};  ///< interaction: from the true position; force: from the undelayed one
  std::optional<double> deviation_from_ideal_rms = {};  ///< force only
  std::int64_t underruns_so_far = 0;
  double largest = 0;  ///< of the signal itself: rounding errors go with it
};
std::map<std::string, std::vector<BinRow>> bins(const RunRecord& run);
std::map<std::string, std::vector<BinRow>> bins(const RunRecord& run, const BinLayout& layout);

/// An error in the bins of a signal: its name, "deviation", and its RMS there.
struct BinnedError {
  std::string_view name;
  std::optional<double> (*rms)(const BinRow& row);
};
inline constexpr std::array kBinnedErrors =
    std::to_array<BinnedError>({{"deviation", [](const BinRow& row) { return std::optional(row.deviation_rms); }},
                                {"error", [](const BinRow& row) { return row.error_rms; }},
                                {"deviation_from_ideal", [](const BinRow& row) { return row.deviation_from_ideal_rms; }}});
/// How each of these errors of a signal grows, as its metrics say; without those that the signal does not have.
std::vector<std::pair<std::string_view, GrowthInterval>> growths_of(const Metrics& metrics, const std::string& signal);

}  // namespace evenstep
