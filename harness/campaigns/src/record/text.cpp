#include <fmt/format.h>
#include <sys/utsname.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>

#include "evenstep/campaigns/record_solver.h"
#include "evenstep/harness/version.h"
#include "src/study/machine.h"

namespace evenstep {
namespace {

/// Lengths in ns, and the value that `permille` of them do not exceed (nearest rank).
std::int64_t rank(const std::vector<std::int64_t>& ascending, std::size_t permille) {
  return ascending[(ascending.size() * permille + 999) / 1000 - 1];
}
Spread spread_of(std::vector<std::int64_t> lengths) {
  if (lengths.empty()) return {};
  std::sort(lengths.begin(), lengths.end());
  return {rank(lengths, 500), rank(lengths, 990), lengths.back()};
}

std::int64_t length_ns(std::uint64_t from, std::uint64_t to) { return static_cast<std::int64_t>(to - from); }

/// The commands of one step, on the device's clock.
struct OnDevice {
  std::uint64_t queued_ns = 0, ended_ns = 0;
  std::int64_t busy_ns = 0;
  bool any = false;
  void add(const DeviceCommand& command) {
    if (!any) queued_ns = command.queued_ns;
    const std::uint64_t from = any ? std::max(command.started_ns, ended_ns) : command.started_ns;
    if (command.ended_ns > from) busy_ns += length_ns(from, command.ended_ns);
    queued_ns = std::min(queued_ns, command.queued_ns);
    ended_ns = std::max(ended_ns, command.ended_ns);
    any = true;
  }
};

/// Their times by name.
class NamedCommands {
 public:
  void add(const DeviceCommand& command) {
    const auto [place, added] = index_.try_emplace(command.name, names_.size());
    if (added) names_.push_back({std::string(command.name), {}, {}, {}});
    OfName& of = names_[place->second];
    of.queued.push_back(length_ns(command.queued_ns, command.submitted_ns));
    of.submitted.push_back(length_ns(command.submitted_ns, command.started_ns));
    of.runs.push_back(length_ns(command.started_ns, command.ended_ns));
  }
  std::vector<CommandSummary> take() {
    std::vector<CommandSummary> all;
    for (OfName& of : names_) {
      all.push_back({of.name, static_cast<std::int64_t>(of.runs.size()), spread_of(std::move(of.queued)).p50,
                     spread_of(std::move(of.submitted)).p50, spread_of(std::move(of.runs)).p50});
    }
    return all;
  }

 private:
  struct OfName {
    std::string name;
    std::vector<std::int64_t> queued, submitted, runs;
  };
  std::map<std::string_view, std::size_t> index_;
  std::vector<OfName> names_;
};

/// What is known of the commands while they are read.
class DeviceSums {
 public:
  void add(const SolverRecording& recording, RecordSummary& summary) {
    const auto& commands = recording.commands;
    for (std::size_t at = 0; at < commands.size();) {
      const std::size_t segment = commands[at].segment;
      const std::optional<std::size_t> step = commands[at].step;
      OnDevice one;
      for (; at < commands.size() && commands[at].segment == segment && commands[at].step == step; ++at) {
        if (commands[at].command.has_times()) {
          one.add(commands[at].command);
          (step ? of_steps_ : of_drawings_).add(commands[at].command);
        } else {
          ++summary.commands_without_times;
        }
      }
      if (one.any && step) add_step(recording.segments[segment].steps[*step], one, summary);
      if (one.any && !step) {
        drawing_spans_.push_back(length_ns(one.queued_ns, one.ended_ns));
        drawing_busy_.push_back(one.busy_ns);
      }
    }
    put(summary);
  }

 private:
  void add_step(const Interval& host, const OnDevice& device, RecordSummary& summary) {
    const std::int64_t span = length_ns(device.queued_ns, device.ended_ns), rest = (host.end - host.begin).ns - span;
    spans_.push_back(span);
    busy_.push_back(device.busy_ns);
    waiting_.push_back(span - device.busy_ns);
    beyond_.push_back(rest);
    if (rest < 0) ++summary.steps_beyond_host;
    summary.beyond_host_max_ns = std::max(summary.beyond_host_max_ns, -rest);
    if (spans_.size() == 1) first_host_ = host.end, first_ended_ns_ = device.ended_ns;
    last_host_ = host.end, last_ended_ns_ = device.ended_ns;
  }

  void put(RecordSummary& summary) {
    summary.steps_on_device = static_cast<std::int64_t>(spans_.size());
    summary.span = spread_of(std::move(spans_));
    summary.busy = spread_of(std::move(busy_));
    summary.waiting = spread_of(std::move(waiting_));
    summary.beyond = spread_of(std::move(beyond_));
    summary.commands = of_steps_.take();
    summary.drawing_span = spread_of(std::move(drawing_spans_));
    summary.drawing_busy = spread_of(std::move(drawing_busy_));
    summary.drawing_commands = of_drawings_.take();
    const double host_ns = static_cast<double>((last_host_ - first_host_).ns);
    if (host_ns < 1e9) return;
    const double device_ns = static_cast<double>(last_ended_ns_) - static_cast<double>(first_ended_ns_);
    summary.faster_ppm = 1e6 * (device_ns - host_ns) / host_ns;
  }

  NamedCommands of_steps_, of_drawings_;
  std::vector<std::int64_t> spans_, busy_, waiting_, beyond_, drawing_spans_, drawing_busy_;
  RealTime first_host_, last_host_;
  std::uint64_t first_ended_ns_ = 0, last_ended_ns_ = 0;
};

std::string first_line(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

/// Of text that a driver or a person wrote: one line, without control characters.
std::string one_line(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  return text;
}

std::string milliseconds(std::int64_t ns) { return fmt::format("{:.4f}", static_cast<double>(ns) * 1e-6); }
std::string spread_row(std::string_view what, const Spread& spread) {
  return fmt::format("{:<38}{:>12}{:>12}{:>12}\n", what, milliseconds(spread.p50), milliseconds(spread.p99),
                     milliseconds(spread.max));
}

std::string command_rows(const std::vector<CommandSummary>& commands, std::string_view of) {
  std::string text;
  for (const CommandSummary& command : commands) {
    text += fmt::format("{:<26}{:>12}{:>12}{:>12}{:>12}\n", fmt::format("{}{}", of, command.name), command.count,
                        milliseconds(command.waits_queued_ns), milliseconds(command.waits_submitted_ns),
                        milliseconds(command.runs_ns));
  }
  return text;
}

std::string device_rows(const RecordSummary& summary) {
  std::string text = spread_row("device: first queued to last ended", summary.span);
  text += spread_row("  of it a command runs", summary.busy);
  text += spread_row("  of it none runs", summary.waiting);
  text += spread_row("host - device", summary.beyond);
  text += fmt::format("\n{:<26}{:>12}{:>12}{:>12}{:>12}\n", "command, p50 in ms", "count", "queued", "submitted", "runs");
  text += command_rows(summary.commands, "") + command_rows(summary.drawing_commands, "visualization: ");
  if (summary.faster_ppm != 0)
    text += fmt::format("the device's clock against the host's: {:+.1f} ppm\n", summary.faster_ppm);
  if (summary.steps_beyond_host > 0)
    text += fmt::format(
        "not to be trusted: {} of {} steps took longer on the device than the host waited for them, up to {} ms more\n",
        summary.steps_beyond_host, summary.steps_on_device, milliseconds(summary.beyond_host_max_ns));
  return text;
}

}  // namespace

RecordSummary summarize(const SolverRecording& recording) {
  RecordSummary summary;
  std::vector<std::int64_t> host, visualizations;
  for (const SegmentTiming& segment : recording.segments) {
    ++summary.segments;
    if (segment.visualization) visualizations.push_back((segment.visualization->end - segment.visualization->begin).ns);
    for (const Interval& step : segment.steps) host.push_back((step.end - step.begin).ns);
  }
  if (!recording.segments.empty()) summary.length = recording.segments.back().end - recording.segments.front().begin;
  summary.steps = static_cast<std::int64_t>(host.size());
  summary.host = spread_of(std::move(host));
  summary.visualizations = static_cast<std::int64_t>(visualizations.size());
  summary.visualization = spread_of(std::move(visualizations));
  DeviceSums().add(recording, summary);
  return summary;
}

double load_now() { return internal::study_machine().load; }

RecordedMachine machine_here() {
  const internal::StudyMachine here = internal::study_machine();
  RecordedMachine machine;
  machine.processor = here.name;
  machine.processors = here.cpus;
  machine.load_before = here.load;
  utsname system{};
  if (::uname(&system) == 0) machine.system = fmt::format("{} {} {}", system.sysname, system.release, system.machine);
  machine.host_clock = first_line("/sys/devices/system/clocksource/clocksource0/current_clocksource");
  return machine;
}

std::string head_text(const RecordHead& head, const Scenario& scenario, const SolverInfo& info,
                      const SolverRecording& recording) {
  std::string text;
  const auto line = [&](const std::string& what) { text += "# " + one_line(what) + "\n"; };
  const RecordedMachine& machine = head.machine;
  line(fmt::format("{} (evenstep {}), {}", head.command, kVersion, head.date));
  line(fmt::format("scenario: {}; solver {}, {} particles, {} substeps", scenario.name, info.name, info.particles,
                   info.substeps));
  if (const OpenClDescription& device = machine.device; !device.device.empty()) {
    line(fmt::format("device: {}, {} compute units, at most {} MHz", device.device, device.compute_units, device.clock_MHz));
    line(fmt::format("driver: {}; platform {}, {}", device.driver, device.platform, device.version));
  }
  line(fmt::format("host: {} x {}, {}", machine.processors, machine.processor, machine.system));
  line(fmt::format("load: {:.2f} before, {:.2f} after (runnable processes, mean of a minute)", machine.load_before,
                   machine.load_after));
  std::string clock = fmt::format("clock: CLOCK_MONOTONIC ({})", machine.host_clock.empty() ? "?" : machine.host_clock);
  if (!recording.commands.empty()) {
    const std::int64_t unit_ns = machine.device.timer_resolution_ns;
    clock += unit_ns > 0 ? fmt::format("; the device's own, of {} ns, for its commands", unit_ns)
                         : "; the device does not say the times of its commands";
  }
  line(clock);
  if (const auto& rights = recording.rights; rights && rights->fifo)
    line(fmt::format("rights: SCHED_FIFO {}, as the solver of a live run", rights->priority));
  else
    line("rights: those of an ordinary program" + (rights ? ", because " + rights->refusal : std::string()));
  line(fmt::format("before it, not in it: {:.3f} s until kernels were built and had run once", machine.warm_up_s));
  line("in a visualization " + (head.visualization.empty()
                                    ? "nothing was drawn: it is a pause of the length that the scenario gives"
                                    : head.visualization));
  if (recording.interrupted) line("interrupted: shorter than asked for");
  return text;
}

std::string commands_csv(const SolverRecording& recording) {
  std::string csv = "segment,kind,index,name,queued_ns,submitted_ns,started_ns,ended_ns\n";
  const auto known = [](const RecordedCommand& one) { return one.command.has_times(); };
  const auto first = std::find_if(recording.commands.begin(), recording.commands.end(), known);
  if (first == recording.commands.end()) return csv;
  const auto zero = static_cast<std::int64_t>(first->command.queued_ns);
  const auto since = [&](std::uint64_t ns) { return static_cast<std::int64_t>(ns) - zero; };
  for (const auto& [segment, step, command] : recording.commands) {
    if (!command.has_times()) continue;
    fmt::format_to(std::back_inserter(csv), "{},{},{},{},{},{},{},{}\n", segment, step ? "step" : "visualization",
                   step.value_or(0), command.name, since(command.queued_ns), since(command.submitted_ns),
                   since(command.started_ns), since(command.ended_ns));
  }
  return csv;
}

std::string record_table(const RecordSummary& summary, const SolverRecording& recording) {
  std::string text =
      fmt::format("{} segments, {} visualizations and {} steps in {:.3f} s{}\n\n", summary.segments, summary.visualizations,
                  summary.steps, seconds(summary.length), recording.interrupted ? ", interrupted" : "");
  if (summary.visualizations > 0) {
    text += fmt::format("{:<38}{:>12}{:>12}{:>12}\n", "per visualization, ms", "p50", "p99", "max");
    text += spread_row("host: from its begin to its end", summary.visualization);
    if (!summary.drawing_commands.empty()) {
      text += spread_row("device: first queued to last ended", summary.drawing_span);
      text += spread_row("  of it a command runs", summary.drawing_busy);
    }
    text += "\n";
  }
  text += fmt::format("{:<38}{:>12}{:>12}{:>12}\n", "per step, ms", "p50", "p99", "max");
  text += spread_row("host: call to forces", summary.host);
  if (summary.steps_on_device > 0) text += device_rows(summary);
  text += "\n";
  if (recording.commands_over_limit > 0)
    text += fmt::format("left out: {} commands after the first {}\n", recording.commands_over_limit, kMostRecordedCommands);
  if (summary.commands_without_times > 0)
    text += fmt::format("left out: {} commands, whose times the device does not say, or not in order\n",
                        summary.commands_without_times);
  if (recording.rights && !recording.rights->fifo)
    text += fmt::format("not real-time, so a live run that is has shorter waits: {}\n", recording.rights->refusal);
  if (recording.full) text += fmt::format("ended early: {} steps are the most that are kept\n", kMostRecordedSteps);
  const auto late = [&](std::int64_t segments, const char* why) {
    if (segments > 0)
      text += fmt::format("{} segment{} began more than 1 ms late{}\n", segments, segments == 1 ? "" : "s", why);
  };
  late(recording.late_segments, ": the steps before them took longer than the scenario's segments are");
  late(recording.overslept_segments, ", although nothing was left to do: this machine woke up late");
  if (recording.late_segments + recording.overslept_segments > 0)
    text += fmt::format("the latest of them by {} ms\n", milliseconds(recording.latest.ns));
  return text;
}

}  // namespace evenstep
