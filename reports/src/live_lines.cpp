#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string_view>

#include "evenstep/reports/writers.h"

namespace evenstep {
namespace {

std::string milliseconds(double value_s) { return fmt::format("{:.3g} ms", 1e3 * value_s); }

/// What a device's force guard and its driver count, and the text for it; counts of 0 are left out.
struct Counted {
  std::string_view metric, text;
};
constexpr Counted kCounted[] = {{"clamped", "clamped"},
                                {"slewed", "slewed"},
                                {"saturated", "saturated"},
                                {"pid_saturated", "saturated by the PID device"},
                                {"evdev_saturated", "saturated by the evdev device"},
                                {"evdev_dropped", "times events dropped"},
                                {"evdev_untimed", "refusal of event times: a sample's time is that of its read"},
                                {"inverse3_absent", "messages without the device"},
                                {"inverse3_uncalibrated", "messages of an uncalibrated device"},
                                {"non_finite", "not finite"},
                                {"lost", "reports lost"},
                                {"write_failures", "writes failed"},
                                {"writes_rejected", "writes rejected"},
                                {"unplugged", "times unplugged"}};

std::string device_line(const Metrics& metrics, const std::string& device, const std::string& strategy) {
  const std::string force = device + ".force." + strategy, buffers = device + ".buffers." + strategy;
  double cuts = 0;
  for (const char* reason : {"cuts_device", "cuts_stale_hand", "cuts_stale_force", "cuts_speed"})
    cuts += value_or_0(metrics, force, reason);
  std::string line =
      fmt::format("{:<13}{} samples missing, {} forces late of {} judged steps; {} cuts", device,
                  value_or_0(metrics, buffers, "interaction_underruns"), value_or_0(metrics, buffers, "force_underruns"),
                  value_or_0(metrics, device + ".interaction." + strategy, "judged"), cuts);
  for (const Counted& counted : kCounted) {
    const double count = value_or_0(metrics, force, std::string(counted.metric));
    if (count > 0) line += fmt::format(", {} {}", count, counted.text);
  }
  return line + '\n';
}

/// Steps that never began, and what became of the forces of the other steps.
std::string flow_lines(const Metrics& metrics, const StrategyRecord& strategy) {
  std::string text;
  const std::string solver = "solver." + strategy.name;
  if (const double missing = value_or_0(metrics, solver, "steps_not_begun"); missing > 0)
    text += fmt::format("steps        {} began, {} that were programmed did not: the simulation fell behind\n",
                        value_or_0(metrics, solver, "steps_begun"), missing);
  for (const DeviceRecord& device : strategy.devices) {
    if (!device.flow) continue;
    const DeviceFlow& flow = *device.flow;
    text += fmt::format("{:<13}{} forces: {} sent, {} overtaken by a newer one, {} dropped, {} due after the last tick\n",
                        device.name, flow.forces, flow.forces_sent, flow.forces_overtaken, flow.forces_dropped,
                        flow.forces_pending);
  }
  return text;
}

/// Which rights the threads were granted, and how to get the rest.
std::string rights_lines(const LiveRights& rights) {
  std::string threads;
  bool all_granted = rights.memory_locked;
  int highest = 0;
  std::int64_t slack_ns = 0;
  for (const LiveRights::Thread& thread : rights.threads) {
    threads += fmt::format("{} {} {}", thread.name, thread.fifo ? "SCHED_FIFO" : "refused SCHED_FIFO", thread.priority);
    threads += thread.slice_ns > 0
                   ? fmt::format(" (a slice of {:.3g} ms instead), ", 1e-6 * static_cast<double>(thread.slice_ns))
                   : ", ";
    all_granted = all_granted && thread.fifo;
    highest = std::max(highest, thread.priority);
    slack_ns = std::max(slack_ns, thread.timer_slack_ns);
  }
  const char* const cores = !rights.cores_awake   ? ""
                            : *rights.cores_awake ? ", cores kept awake"
                                                  : ", refused to keep cores awake";
  const std::string text = fmt::format("rights       {}memory {}, timer slack {} ns{}\n", threads,
                                       rights.memory_locked ? "locked" : "not locked", slack_ns, cores);
  if (all_granted) return text;
  return text + fmt::format(
                    "             for all of them: two lines in /etc/security/limits.d/evenstep.conf, then log in again\n"
                    "               YOUR-USER-NAME - rtprio {}\n"
                    "               YOUR-USER-NAME - memlock unlimited\n",
                    highest);
}

}  // namespace

std::string live_lines(const RunRecord& run, const Metrics& metrics) {
  std::string text;
  for (const StrategyRecord& strategy : run.strategies) {
    if (strategy.name != run.live) continue;
    const auto tick = [&](const char* metric) { return value_or_0(metrics, "events.device.tick", metric); };
    text += fmt::format("live         {} for {:.3g} s on the wall clock: {} steps, {} ticks, {} ticks missed ({:.3g} %)\n",
                        strategy.name, seconds(run.nominal.end), strategy.steps.size(), tick("ticks_run"),
                        tick("deadline_misses"), 100 * tick("deadline_miss_share"));
    text += fmt::format("lateness     p50 {}, p99 {}, p99.9 {}, max {}\n", milliseconds(tick("lateness_p50")),
                        milliseconds(tick("lateness_p99")), milliseconds(tick("lateness_p999")),
                        milliseconds(tick("lateness_max")));
    text += flow_lines(metrics, strategy);
    if (run.rights) text += rights_lines(*run.rights);
    for (const DeviceRecord& device : strategy.devices) text += device_line(metrics, device.name, strategy.name);
  }
  return text;
}

std::string device_notes(const RunRecord& run) {
  std::set<std::string> silent;
  for (const StrategyRecord& strategy : run.strategies) {
    for (const DeviceRecord& device : strategy.devices) {
      const auto unknown = device.counters.find("pid_pool_unknown");
      if (unknown != device.counters.end() && unknown->second > 0) silent.insert(device.name);
    }
  }
  std::string text;
  for (const std::string& device : silent)
    text += fmt::format(
        "{:<13}did not say, or not believably, how many effects it plays at once; it is driven all the same\n", device);
  return text;
}

}  // namespace evenstep
