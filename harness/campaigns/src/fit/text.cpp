#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

#include <algorithm>
#include <cmath>

#include "evenstep/campaigns/fit_report.h"

namespace evenstep {
namespace {

double ms(Duration duration) { return static_cast<double>(duration.ns) * 1e-6; }

std::string time(std::int64_t ns) { return fmt::format("\"{} ms\"", static_cast<double>(ns) / 1e6); }
std::string percent(double ratio) { return fmt::format("{:.3g} %", 100 * ratio); }

std::string rate_text(Rate rate) {
  if (rate.den == 1) return fmt::format("\"{} Hz\"", rate.num);
  return time(instant_ns(rate, 1));
}

/// Adds a line of the table, with the reason for it as a comment.
void add(std::string& out, const std::string& assignment, const std::string& comment) {
  out += fmt::format("{:<46} # {}\n", assignment, comment);
}
void leave_out(std::string& out, const std::string& comment) { out += fmt::format("# {}\n", comment); }

void add_segment(std::string& out, const TimingFit& fit) {
  const std::string measured =
      fmt::format("T: median {:.6g} ms, varies by {}; the work in it by {}; idle {} of the time; {} of {} late by over 1 %",
                  fit.segment_median_ns * 1e-6, percent(fit.segment_variation), percent(fit.work_variation),
                  percent(fit.idle_share), fit.late, fit.segments);
  if (!fit.timing.paced) return leave_out(out, "not paced. " + measured);
  add(out, "segment = " + rate_text(fit.timing.segment), measured);
  add(out, "paced = true", "T is steadier than the work in it");
  if (fit.spread)
    add(out, "governor = { steps = \"spread\" }", percent(fit.between_share) + " of the idle time is between the steps");
}

void add_order(std::string& out, const TimingFit& fit) {
  if (fit.timing.order == SegmentOrder::steps_first)
    add(out, "order = \"steps-first\"", "most visualizations follow their steps");
  if (fit.timing.order == SegmentOrder::concurrent)
    add(out, "order = \"concurrent\"",
        fmt::format("visualizations overlap steps; N from {} to {}", fit.least_steps, fit.most_steps));
}

void add_visualization(std::string& out, const TimingFit& fit) {
  const FittedLength& length = fit.visualization;
  add(out, "visualization = " + time(fit.timing.visualization.ns),
      fmt::format("median {:.6g} ms of {}; the mean of what lies within 5 deviations", length.median_ns * 1e-6,
                  length.count));
  if (fit.timing.regimes) {
    add(out,
        fmt::format("regimes = {{ factor = {:.4g}, mean_length = \"{:.4g} segments\", slow_share = \"{:.3g} %\" }}",
                    fit.timing.regimes->factor, fit.timing.regimes->mean_length, 100 * fit.timing.regimes->slow_share),
        fmt::format("two levels {:.3g} deviations apart; lag-1 correlation {:.2f}", fit.regime_separation, fit.lag_1));
  } else {
    leave_out(out, fmt::format("no regimes: one level explains it; lag-1 correlation of V {:.2f}", fit.lag_1));
  }
  if (fit.timing.hitch)
    add(out,
        fmt::format("hitch = {{ every = {}, visualization = {} }}", time(fit.timing.hitch->every.ns),
                    time(fit.timing.hitch->visualization.ns)),
        fmt::format("{} visualizations of about that length, at equal intervals", fit.hitches));
  if (fit.dropped > 0)
    add(out, fmt::format("dropped_visualization = \"{:.3g} %\"", 100 * fit.timing.dropped_visualization),
        fmt::format("{} of {} segments", fit.dropped, fit.segments));
  if (fit.merged > 0)
    add(out, fmt::format("merged_visualization = \"{:.3g} %\"", 100 * fit.timing.merged_visualization),
        fmt::format("{} of {} segments near twice the median", fit.merged, fit.segments));
}

void add_steps(std::string& out, const TimingFit& fit) {
  const ProgrammedTiming& timing = fit.timing;
  if (timing.order != SegmentOrder::concurrent) {
    const std::string list = timing.steps.size() == 1 ? fmt::format("{}", timing.steps.front())
                                                      : fmt::format("[{}]", fmt::join(timing.steps, ", "));
    add(out, "steps = " + list, fmt::format("{} to {}, mean {:.4g}", fit.least_steps, fit.most_steps, fit.mean_steps));
  }
  add(out, "step = " + time(timing.step->ns),
      fmt::format("median {:.6g} ms of {} that were not hit", fit.step.median_ns * 1e-6, fit.step.count));
  if (timing.order == SegmentOrder::concurrent) {
    const std::string why =
        fmt::format("beside a visualization x {:.3f} (+- {:.3f})", fit.slowdown.value, fit.slowdown.error);
    timing.slowdown > 1 ? add(out, fmt::format("slowdown = {:.4g}", timing.slowdown), why)
                        : leave_out(out, "no slowdown: " + why);
    return;
  }
  const std::string why = fmt::format("medians: {} (+- {})", percent(fit.first_step.value), percent(fit.first_step.error));
  timing.first_step > 0 ? add(out, fmt::format("first_step = \"+{:.3g} %\"", 100 * timing.first_step), why)
                        : leave_out(out, "no slower first step: " + why);
}

std::string jitter(JitterLaw law, double variation) {
  return fmt::format("\"{} {:.3g} %\"", law == JitterLaw::uniform ? "uniform" : "lognormal", 100 * variation);
}

void add_jitter(std::string& out, const TimingFit& fit) {
  const auto distance = [](const FittedLength& length, JitterLaw law) {
    return law == JitterLaw::uniform ? length.uniform_distance : length.distance;
  };
  const ProgrammedTiming& timing = fit.timing;
  add(out,
      fmt::format("jitter = {{ visualization = {}, step = {} }}",
                  jitter(timing.visualization_law, timing.visualization_variation),
                  jitter(timing.step_law, timing.step_variation)),
      fmt::format("Kolmogorov distance {:.3f} and {:.3f} (95 %: {:.3f} and {:.3f} if that is their law)",
                  distance(fit.visualization, timing.visualization_law), distance(fit.step, timing.step_law),
                  1.36 / std::sqrt(std::max<double>(1, static_cast<double>(fit.visualization.count))),
                  1.36 / std::sqrt(std::max<double>(1, static_cast<double>(fit.step.count)))));
}

void add_hits(std::string& out, const TimingFit& fit) {
  const auto hits = static_cast<std::int64_t>(fit.excess_ns.size());
  const std::string seen = fmt::format("{} steps over the median by {:.3g} ms or more in {:.3g} s of steps", hits,
                                       fit.hit_above_ns * 1e-6, fit.work_s);
  if (!fit.timing.spikes && !fit.timing.preemption)
    return leave_out(out, fmt::format("{}: {}", hits == 0 ? "no spikes, no pre-emption" : "too few hits for a model", seen));
  leave_out(out, seen + fmt::format(", {} of them alike", fit.alike));
  if (fit.timing.spikes) {
    add(out,
        fmt::format("spikes = {{ rate = \"{:.4g} Hz\", cost = {} }}", fit.timing.spikes->rate_Hz,
                    time(fit.timing.spikes->cost.ns)),
        fmt::format("{} of {}", fit.alike, hits));
  }
  if (!fit.timing.preemption) return;
  const Preemption& tail = *fit.timing.preemption;
  add(out,
      fmt::format("preemption = {{ rate = \"{:.4g} Hz\", cost = \"pareto {} ms cap {} ms\", tail = {:.3g} }}", tail.rate_Hz,
                  static_cast<double>(tail.least.ns) / 1e6, static_cast<double>(tail.most.ns) / 1e6, tail.tail),
      fmt::format("{} of {}; Kolmogorov distance {:.3f}", hits - (fit.timing.spikes ? fit.alike : 0), hits,
                  fit.tail_distance));
}

void add_drift(std::string& out, const TimingFit& fit) {
  const FittedNumber v = fit.visualization_drift_per_s, s = fit.step_drift_per_s;
  const std::string why = fmt::format("V {:.3g} %/s (+- {:.2g}), s {:.3g} %/s (+- {:.2g}) over {:.3g} s", 100 * v.value,
                                      100 * v.error, 100 * s.value, 100 * s.error, fit.seconds);
  if (fit.timing.drift_per_s == 0) return leave_out(out, "no drift: " + why);
  add(out, fmt::format("drift = \"{:.4g} %/s\"", 100 * fit.timing.drift_per_s), why);
}

std::string row(const char* name, const LatencyNeed& need, const std::vector<LatencyNeed>& seeds) {
  std::string out = fmt::format("#   {:<20} {:>9.3f} {:>9.3f} {:>10.3f} {:>13.3f}", name, ms(need.window_p50),
                                ms(need.window_p99), ms(need.whole), ms(need.phase_locked));
  if (seeds.empty()) return out + "\n";
  const auto [least, most] = std::minmax_element(seeds.begin(), seeds.end(), [](const LatencyNeed& a, const LatencyNeed& b) {
    return a.phase_locked < b.phase_locked;
  });
  return out + fmt::format("  ({:.3f} to {:.3f})\n", ms(least->phase_locked), ms(most->phase_locked));
}

/// What the recording needs, and the model and the shuffled recording beside it.
std::string needs_text(const FitComparison& comparison) {
  std::string out = fmt::format(
      "#\n# Least latency in ms: of one straight line for each window of 250 ms and for the whole recording, and of the "
      "map\n# phase_locked with a device of 1 kHz at any phase. Medians of {} seeds, and the range of the last.\n",
      comparison.shuffled.size());
  out += fmt::format("#   {:<20} {:>9} {:>9} {:>10} {:>13}\n", "", "250ms p50", "250ms p99", "whole", "phase_locked");
  out += row("recording", comparison.recording, {});
  if (comparison.objection.empty()) out += row("this model", comparison.model_median, comparison.model);
  out += row("recording, shuffled", comparison.shuffled_median, comparison.shuffled);
  const std::string pause = text(comparison.pause);
  return pause.empty() ? out : out + "# " + pause + "\n";
}

std::string verdict(const FitComparison& comparison, const std::string& file) {
  const auto order = differences(comparison.recording, comparison.shuffled_median);
  const auto model = differences(comparison.recording, comparison.model_median);
  const std::string tolerances = fmt::format("a factor of {} ({} for phase_locked)", kFitTolerance, kMapTolerance);
  std::string out;
  if (!order.empty())
    out += fmt::format("# The order of the segments matters: shuffled they differ by more than {} in: {}.\n", tolerances,
                       fmt::join(order, ", "));
  if (!comparison.objection.empty())
    return out +
           fmt::format("# The models cannot say this: {}\n# So the table replays the recording.\n", comparison.objection);
  if (model.empty()) return out + fmt::format("# This model needs what the recording needs, within {}.\n", tolerances);
  return out + fmt::format(
                   "# This model does NOT stand for the recording: more than {} apart in: {}.\n# Replay it instead: trace = "
                   "\"{}\"\n",
                   tolerances, fmt::join(model, ", "), file);
}

/// Each line of the text as a comment.
std::string commented(const std::string& lines) {
  std::string out = "# ";
  for (std::size_t i = 0; i < lines.size(); ++i) {
    out += lines[i];
    if (lines[i] == '\n' && i + 1 < lines.size()) out += "# ";
  }
  return out;
}

}  // namespace

std::string fitted_table(const TimingFit& fit) {
  std::string out;
  add_order(out, fit);
  add_segment(out, fit);
  add_visualization(out, fit);
  add_steps(out, fit);
  add_jitter(out, fit);
  add_hits(out, fit);
  add_drift(out, fit);
  return out;
}

std::string fit_toml(const TimingFit& fit, const FitComparison& comparison, const std::string& file) {
  const std::string table = fitted_table(fit);
  const bool replay = !comparison.objection.empty();
  return fmt::format("# Fitted to {}: {} segments, {:.4g} s\n[timing]\n", file, fit.segments, fit.seconds) +
         (replay ? fmt::format("trace = \"{}\"\n", file) + commented(table) : table) + needs_text(comparison) +
         verdict(comparison, file);
}

}  // namespace evenstep
