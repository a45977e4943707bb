#include <fmt/format.h>

#include <algorithm>

#include "evenstep/reports/size_record.h"
#include "size_conclusion.h"

namespace evenstep {
namespace {

using internal::ms;

std::string heading(const SizeRecord& record) {
  std::string from = record.segments_from;
  if (from == "cycle") from = "of the cycle found in it";
  if (from == "step") from = "of one step each: there is no cycle in it";
  if (from == "recording") from = "as recorded";
  if (from == "programmed") from = "as programmed";
  std::string out = fmt::format("{}\n{}\n  {} steps in {} segments {}, {:.6g} s", record.input, internal::answer(record),
                                record.steps, record.segments, from, seconds(record.length));
  if (record.left_out > 0) out += fmt::format("; {} steps before the first long pause are left out", record.left_out);
  return out + fmt::format("\n  device period {:.6g} ms at any phase, forces {}, damping {:.6g} N s/m\n",
                           ms(record.sampling_period), record.interpolated ? "interpolated" : "held",
                           record.damping_N_s_per_m);
}

std::string row(const std::string& name, const SizeNeed& need) {
  return fmt::format("  {:<13} {:>13.6f} {:>10.3f} {:>10.3f} {:>10.3f} {:>12.3f} {:>10.4g}", name, ms(need.latency),
                     ms(need.windows.p50), ms(need.windows.p99), ms(need.windows.most), ms(need.total_delay),
                     need.stiffness_limit_N_per_m);
}

std::string table(const SizeRecord& record) {
  std::string out = fmt::format("\n  {:<13} {:>13} {:>32} {:>12} {:>10}\n", "", "latency", "windows of 250 ms",
                                "total delay", "stiffness");
  out += fmt::format("  {:<13} {:>13} {:>10} {:>10} {:>10} {:>12} {:>10} {:>13} {:>20}\n", "", "ms", "p50", "p99", "max",
                     "ms", "N/m", "lead, ms", "samples, forces");
  const SizeBounds& bounds = record.linear ? *record.linear : record.held;
  out += row("taut string", bounds.taut_string) + "\n" + row("best line", bounds.best_line) + "\n";
  for (const SizeStrategy& strategy : record.strategies) {
    out += row(strategy.name, strategy.any_phase) +
           fmt::format(" {:>13.6f} {:>20}\n", ms(strategy.lead),
                       fmt::format("{}, {}", strategy.interaction_capacity, strategy.force_capacity));
    out += fmt::format("  {:<13} {:>13.6f} {:>69.6f}\n", "  this phase", ms(strategy.latency_this_phase),
                       ms(strategy.lead_this_phase));
  }
  return out +
         "  Every ms of latency costs stiffness: the loop carries damping / (period / 2 + total delay). No scheme of "
         "constant "
         "latency\n  does with less than the taut string; a straight line is perfectly even; 1 ns less than these "
         "underruns.\n";
}

double times(Duration latency, Duration bound) {
  return bound.ns > 0 ? static_cast<double>(latency.ns) / static_cast<double>(bound.ns) : 0;
}

/// Latency against velocity jump: the bounds, and each map beside them.
std::string jumps(const SizeRecord& record) {
  const SizeBounds& bounds = record.linear ? *record.linear : record.held;
  if (bounds.best_line.latency.ns == 0) return "";
  std::string out = fmt::format("\n  {:<13} {:>13} {:>12} {:>24} {:>24}\n", "", "latency, ms", "jump, steps",
                                "times any path so smooth", "times the pause bound");
  out += fmt::format("  {:<13} {:>13.6f}\n", "pause bound", ms(bounds.pause));
  out += fmt::format("  {:<13} {:>13.6f} {:>12}\n", "best line", ms(bounds.best_line.latency), 0);
  for (const SizePath& path : bounds.paths)
    out += fmt::format("  {:<13} {:>13.6f} {:>12}\n", "any path", ms(path.latency), path.jump);
  for (const SizeStrategy& strategy : record.strategies) {
    const Duration latency = strategy.any_phase.latency;
    const std::string smooth = strategy.path ? fmt::format("{:.2f}", times(latency, strategy.path->latency)) : "-";
    out += fmt::format("  {:<13} {:>13.6f} {:>12} {:>24} {:>24.2f}\n", strategy.name, ms(latency),
                       strategy.jump_seen ? fmt::format("{:.4f}", strategy.velocity_jump) : "-", smooth,
                       times(latency, bounds.pause));
  }
  if (record.other_jumps.size() == 2)
    out += fmt::format("  With [remap] jump = {:.4g} phase_locked needs {:.6f} ms, with {:.4g} {:.6f} ms.\n",
                       record.other_jumps[0].jump, ms(record.other_jumps[0].latency), record.other_jumps[1].jump,
                       ms(record.other_jumps[1].latency));
  if (bounds.paths.empty()) out += "  Too many steps for the least latencies of any path.\n";
  return out +
         "  The pause bound is what a map of even slots needs that does not know a pause before it is over; a path may "
         "know\n"
         "  everything. " +
         (record.forces_travel ? "They leave out how long forces are on their way to the device.\n"
                               : "A map near them is not to blame: the machine is.\n");
}

std::string late(const SizeCulprit& culprit) {
  const std::string pause = fmt::format("the pause before it took {:.3f} ms more than usual", ms(culprit.pause_excess));
  const std::string run = fmt::format("its run {}{:.3f} ms more than usual", culprit.pause_excess.ns == 0 ? "took " : "",
                                      ms(culprit.run_excess));
  if (culprit.run_excess.ns == 0) return pause;
  return culprit.pause_excess.ns == 0 ? run : pause + " and " + run;
}

std::string culprit(const std::string& name, const SizeNeed& need) {
  const SizeCulprit& culprit = need.culprit;
  if (culprit.step < 0) return "";
  std::string out = fmt::format("  {:<13} step {} ({} of segment {}, at {:.6f} s)", name, culprit.step, culprit.index,
                                culprit.segment, seconds(culprit.begin));
  if (culprit.late_step < 0) return out + ": no step of its segment or the two before took longer than usual\n";
  if (culprit.late_step != culprit.step) out += fmt::format(", by step {}", culprit.late_step);
  out += fmt::format(": {};", late(culprit));
  const Duration saved = need.latency - culprit.mended_latency;
  return out + (saved.ns > 0
                    ? fmt::format(" mended, {:.6f} ms will do ({:.6f} ms less)\n", ms(culprit.mended_latency), ms(saved))
                    : " mended alone it saves nothing\n");
}

std::string culprits(const SizeRecord& record) {
  const SizeBounds& bounds = record.linear ? *record.linear : record.held;
  std::string out = "\n  What sets the latency\n";
  out += culprit("taut string", bounds.taut_string) + culprit("best line", bounds.best_line);
  for (const SizeStrategy& strategy : record.strategies) out += culprit(strategy.name, strategy.any_phase);
  return out;
}

std::string clock_text(const SizeClock& clock) {
  const std::string step = fmt::format("{:.6f} ms a step", ms(clock.step));
  std::string out =
      clock.follows
          ? fmt::format("\n  Clock: the steps follow their own, {}, to within {:.3g} steps", step, clock.range_steps)
          : fmt::format(
                "\n  Clock: the steps follow none of {}: frames are up to {:.4g} steps apart from it. `clocked` is "
                "left out",
                step, clock.range_steps);
  if (clock.follows && clock.dropped > 0)
    out += fmt::format("; {} steps were dropped, in {} places", clock.dropped, clock.drops);
  const std::string pace = text(clock.pace);
  return out + (pace.empty() ? ".\n" : ".\n  With that step size " + pace + ".\n");
}

std::string cycle_text(const SizeRecord& record) {
  const SizeCycle& cycle = *record.cycle;
  if (!cycle.found)
    return fmt::format("\n  Cycle, from the step times alone: none: {}.{}\n", cycle.reason,
                       record.segments_from == "step" ? " `paper` has no meaning here." : "");
  std::string out = fmt::format(
      "\n  Cycle, from the step times alone: {} steps every {:.6f} ms (half of them within {:.2g} %), after a pause of "
      "{:.3f} "
      "ms;\n  {} of {} segments have so many ({:.4g} %)",
      cycle.steps_per_segment, ms(cycle.period), 100 * cycle.period_variation, ms(cycle.pause),
      static_cast<std::int64_t>(cycle.confidence * static_cast<double>(cycle.segments) + 0.5), cycle.segments,
      100 * cycle.confidence);
  if (cycle.least_steps < cycle.most_steps) out += fmt::format(", the others {} to {}", cycle.least_steps, cycle.most_steps);
  return out + ".\n";
}

/// How the sizes of the first parts did on the parts after them.
std::string unseen(const SizeRecord& record) {
  std::string out;
  for (const SizeStrategy& strategy : record.strategies) {
    if (strategy.unseen.empty()) continue;
    const SizeUnseen all = strategy.all_unseen();
    const auto parts =
        std::count_if(strategy.unseen.begin(), strategy.unseen.end(), [](const auto& one) { return one.late > 0; });
    out += fmt::format("  {:<13} {:>18} {:>9.3g} {:>14} {:>18.6f} {:>22.6f}\n", strategy.name,
                       fmt::format("{} of {}", all.late, all.played),
                       100 * static_cast<double>(all.late) / static_cast<double>(all.played),
                       fmt::format("{} of {}", parts, strategy.unseen.size()), ms(all.late_by), ms(all.missing_by));
  }
  if (out.empty())
    return fmt::format("\n  Too short to be sized on a part and played on the next: that takes {} segments.\n",
                       kLeastUnseen);
  return fmt::format(
             "\n  Sized on the first 1 to 5 sixths, and played on the sixth after them, which that size has not seen\n"
             "  {:<13} {:>18} {:>9} {:>14} {:>18} {:>22}\n",
             "", "late segments", "%", "in parts", "force late by, ms", "sample missing by, ms") +
         out;
}

std::string rate_row(const std::string& name, const SizeRateNeed& need) {
  return fmt::format("  {:<13} {:>13.6f} {:>13.6f} {:>10} {:>15}\n", name, ms(need.latency), ms(need.lead), need.underruns,
                     need.rate_at_most ? fmt::format("{:.3g} %", 100 * *need.rate_at_most) : "-");
}

/// The row of the latency that keeps the rate for sure, or why there is none.
std::string sure_row(const SizeRecord& record, const SizeStrategy& strategy) {
  const std::string name = fmt::format("  {:.6g} % sure", 100 * record.confidence);
  if (strategy.rate->sure) return rate_row(name, *strategy.rate->sure);
  const SizeTrust& trust = strategy.trust;
  if (!trust.one_process()) return fmt::format("  {:<13} nothing: {}\n", name, not_one_process(trust));
  return fmt::format(
      "  {:<13} nothing: too short, {} segments say as much as {} independent ones; {} without any underrun are needed\n",
      name, trust.segments, trust.effective(), strategy.rate->segments_needed);
}

/// The latencies for a span of time.
std::string per(const SizeRecord& record) {
  std::string out = fmt::format("\n  For {:.6g} s, {:.6g} % sure: at most one segment late in so long{}, on average\n",
                                seconds(*record.per), 100 * record.confidence,
                                record.rate ? fmt::format(", or {:.6g} %", 100 * *record.rate) : "");
  out += fmt::format("  {:<13} {:>13} {:>13} {:>16}\n", "", "latency, ms", "lead, ms", "most likely, ms");
  for (const SizeStrategy& strategy : record.strategies) {
    if (!strategy.per) continue;
    const SizePer& one = *strategy.per;
    if (!one.refused.empty()) {
      out += fmt::format("  {:<13} nothing: {}\n", strategy.name, internal::why_refused(one, strategy.trust));
      continue;
    }
    out += fmt::format("  {:<13} {:>13.6f} {:>13.6f} {:>16.6f}   {}\n", strategy.name, ms(one.latency), ms(one.lead),
                       ms(one.likely_latency),
                       one.beyond ? fmt::format("beyond what was seen: tail of {}, shape {:.2f}, at most {:.2f}",
                                                one.exceedances, one.shape, one.shape_at_most)
                                  : "seen");
  }
  return out;
}

std::string rates(const SizeRecord& record) {
  std::string out = fmt::format("\n  At most {:.6g} % of the segments with an underrun\n", 100 * *record.rate);
  out += fmt::format("  {:<13} {:>13} {:>13} {:>10} {:>15}\n", "", "latency, ms", "lead, ms", "segments",
                     fmt::format("rate at {:.6g} %", 100 * record.confidence));
  for (const SizeStrategy& strategy : record.strategies) {
    if (!strategy.rate) continue;
    out += rate_row(strategy.name, strategy.rate->any_phase) + rate_row("  this phase", strategy.rate->this_phase) +
           sure_row(record, strategy);
  }
  return out +
         "  The last column is an upper bound on the true rate of the process recorded. It knows that late segments come\n  "
         "together, and that lead and latency were chosen by the segments that judge them.\n";
}

}  // namespace

std::string size_rates_text(const SizeRecord& record) {
  return fmt::format("{}: {} segments\n", record.input, record.segments) + rates(record);
}

std::string size_text(const SizeRecord& record) {
  return heading(record) + table(record) + jumps(record) + unseen(record) + (record.rate ? rates(record) : "") +
         (record.per ? per(record) : "") + culprits(record) + (record.clock ? clock_text(*record.clock) : "") +
         (record.cycle ? cycle_text(record) : "") + internal::hitches_text(record) + internal::what_if_text(record) +
         internal::worst_order_text(record) + internal::reasons_text(record) + internal::fit_text(record);
}

}  // namespace evenstep
