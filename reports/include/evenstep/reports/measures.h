#pragma once
/// Numbers about a finished run. Exact definitions: docs/metrics.md; names and units are only ever added to.
/// Every metric that has a value is computed, asserted or not.

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "evenstep/reports/run_record.h"

namespace evenstep {

/// metrics[signal][metric] = value in SI base units (s, m, N) or a plain count. Signals: "<device>.interaction.<strategy>",
/// "<device>.force.<strategy>", "<device>.buffers.<strategy>", "closed_loop.<device>.<strategy>", "solver.<strategy>",
/// "events.<lane>.<name>", "run".
using Metrics = std::map<std::string, std::map<std::string, double>>;
Metrics measure(const RunRecord& run);

/// "Judged no sample" is an error, never a pass: the metrics known for a signal, whether or not this run has values.
/// nullopt: the signal's form is unknown.
std::optional<std::vector<std::string>> metrics_of_signal(const std::string& signal);

/// |ideal change of the signal per slot|, in the signal's own unit (m or N): v * slot or k * v * slot.
/// nullopt where no nominal speed (or, for force, no stiffness) exists: then `step` is an error as a unit.
std::optional<double> step_unit(const Nominal& nominal, const std::string& signal);
/// "m", "N", "s", "J", "N s/m", "count" or "1": what a metric is measured in.
std::string base_unit(const std::string& signal, const std::string& metric);

// The measures themselves, on plain series.

/// max |x(n+1) - 2 x(n) + x(n-1)|
double velocity_jump(std::span<const Vec3> x);
struct Deviation { double max = 0; double rms = 0; };
/// Residual of the least-squares line of the vector in each non-overlapping window of `window_s`; the last joins the one
/// before if shorter than half. `t` in s, increasing.
Deviation deviation(std::span<const double> t, std::span<const Vec3> x, double window_s);
/// Largest change between two neighbours.
double jump_max(std::span<const Vec3> x);
/// RMS of x, detrended per window, in the band [low, high] Hz: exact band by DFT of each window (no filter state).
double band_rms(std::span<const double> t, std::span<const Vec3> x, double window_s, double low_Hz, double high_Hz);
/// Energy that has gone into what renders the force, J, at each tick since the first: E(n) = -sum of F . dx, where F is the
/// force felt on the way (sent `delay_s` before; none is known before the first) and dx the way between two ticks. Negative:
/// more came out than went in. `t` in s, increasing. With `springs` (one per tick, or none; then without delay) what they are of
/// the force goes along with the hand until the next tick, as if they were rendered at every instant.
std::vector<double> port_energy(std::span<const double> t, std::span<const Vec3> x, std::span<const Vec3> force_N,
                                double delay_s, std::span<const SpringRow> springs = {});
/// The springs' force on a hand at `x_m`, N.
Vec3 spring_force_N(const SpringRow& spring, const Vec3& x_m);
/// What a sine motion of the whole travel `travel_m` meets: E of a cycle, over the whole cycles from the first tick on, and the
/// damper that would take as much, b = E / (pi (travel / 2)^2 2 pi f). Negative: it drives. nullopt: less than a cycle.
struct RenderedDamping { double energy_per_cycle_J = 0, damping_N_s_per_m = 0; };
std::optional<RenderedDamping> rendered_damping(std::span<const double> t, std::span<const double> energy_J, double travel_m,
                                                double frequency_Hz);
/// Diagonal of the box that holds them all.
double peak_to_peak(std::span<const Vec3> x);
/// Peak to peak in the third, the sixth and the last eighth of a run: of 8 s, 2 s to 3 s, 5 s to 6 s and 7 s to 8 s.
struct Oscillation {
  double early_m = 0, middle_m = 0, late_m = 0;
  /// Late is below 0.98 early and as good a decay below the middle (0.98^(2/5): a swing that a force limit bounds can overshoot
  /// once and then stay), or it is below 5 um. Never where one is not a number.
  bool stable() const;
};
std::optional<Oscillation> oscillation(std::span<const double> t, std::span<const Vec3> x, double from_s, double length_s);
/// Of a device's judged ticks.
std::optional<Oscillation> oscillation(const DeviceRecord& device, const Nominal& nominal);

/// Error against run time: one row per bin (1 s) and signal.
struct BinRow { double from_s = 0; double deviation_max = 0, velocity_jump = 0; std::int64_t underruns_so_far = 0; };
std::map<std::string, std::vector<BinRow>> bins(const RunRecord& run, double bin_s = 1.0);

}  // namespace evenstep
