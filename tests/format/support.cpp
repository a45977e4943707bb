#include "support.h"

#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>

namespace evenstep::test {
namespace {

std::string at(const Duration& d) { return fmt::format("{} ns", d.ns); }
std::string at(const Rate& r) { return fmt::format("{}/{}", r.num, r.den); }
std::string at(const glm::dvec3& v) { return fmt::format("({}, {}, {})", v.x, v.y, v.z); }
std::string at(const std::optional<Limit>& l) { return l ? fmt::format("{} '{}'", l->number, l->unit) : "none"; }
std::string at(const Budget& b) { return fmt::format("{} {}", static_cast<int>(b.kind), b.fixed.ns); }

struct MotionText {
  std::string operator()(const Still& m) const { return "still " + at(m.position_m); }
  std::string operator()(const ConstantVelocity& m) const {
    return fmt::format("velocity {} start {}", at(m.velocity_m_per_s), at(m.smooth_start));
  }
  std::string operator()(const BackAndForth& m) const {
    return fmt::format("{} back-and-forth {} {}", (*this)(m.start), m.straight.ns, m.turn.ns);
  }
  std::string operator()(const Sine& m) const { return fmt::format("sine {} {}", at(m.amplitude_m), at(m.frequency)); }
  std::string operator()(const RampStop& m) const { return fmt::format("{} stop {}", (*this)(m.ramp), m.stop.ns); }
  std::string operator()(const StickSlip& m) const {
    return fmt::format("stick-slip {} {} {}", at(m.velocity_m_per_s), m.stick.ns, m.slip.ns);
  }
  std::string operator()(const RecordedMotion& m) const {
    std::string out = "recorded";
    for (const auto& [time, position] : m.rows) out += fmt::format(" {}:{}", time.ns, at(position));
    return out;
  }
  std::string operator()(const MinimumJerk& m) const {
    std::string out = "minimum-jerk";
    for (const MinimumJerk::Move& move : m.moves)
      out += fmt::format(" {} {} {}", at(move.to_m), at(move.duration), at(move.rest));
    return out;
  }
};

std::string hand_text(const HandSpec& h) {
  std::string out = fmt::format(" hand {} {} {} push {} offset {} velocity {}", h.mass_kg, h.damping_N_s_per_m,
                                h.stiffness_N_per_m, at(h.push_N), at(h.offset_m), at(h.velocity_m_per_s));
  if (h.arm) out += fmt::format(" arm {} {} {}", h.arm->mass_kg, h.arm->damping_N_s_per_m, h.arm->stiffness_N_per_m);
  return out;
}

std::string faces(const FixedFaces& f) {
  return fmt::format("{:d}{:d}{:d}{:d}{:d}{:d}", f.x_min, f.x_max, f.y_min, f.y_max, f.z_min, f.z_max);
}

struct SceneText {
  std::string operator()(const SpringScene& s) const { return fmt::format("spring {}", s.stiffness_N_per_m); }
  std::string operator()(const WallScene& s) const {
    return fmt::format("wall {} {} {} {}", s.stiffness_N_per_m, at(s.normal), s.surface_m, s.hardening_m);
  }
  std::string operator()(const ModeScene& s) const {
    return fmt::format("mode {} {} {} {} {} {}", s.stiffness_N_per_m, s.frequency_Hz, s.damping_ratio, s.one_sided,
                       at(s.normal), s.surface_m);
  }
  std::string operator()(const TissueScene& s) const {
    std::string out =
        fmt::format("tissue {} {} {} spacing {} mass {} stiffness {} damping {} fixed {} substeps {} particles {}",
                    s.lattice[0], s.lattice[1], s.lattice[2], s.spacing_m, s.particle_mass_kg, s.stiffness_N_per_m,
                    s.damping_per_s, faces(s.fixed), s.substeps, s.particle_count);
    out += fmt::format(" axial {} gravity {} method {} iterations {}", s.axial_damping_N_s_per_m, at(s.gravity_m_per_s2),
                       name_of(s.method), s.iterations);
    for (const MaterialRegion& region : s.regions) {
      out += fmt::format(" region {} {} {} {}", at(region.min_m), at(region.max_m), region.stiffness_N_per_m,
                         region.particle_mass_kg);
    }
    for (const ToolCoupling& grab : s.tools) {
      out += fmt::format(" grab {} {} {} {} {}", at(grab.center_m), grab.radius_m, static_cast<int>(grab.kind),
                         grab.stiffness_N_per_m, grab.damping_N_s_per_m);
    }
    return out;
  }
  std::string operator()(const ForeignScene& s) const { return fmt::format("foreign {} {}", s.name, s.options); }
};

struct RenderText {
  std::string operator()(const ForceRender&) const { return " render force\n"; }
  std::string operator()(const LocalRender& r) const {
    return fmt::format(" render local {} alpha {} stiffness {} gap {} cap {} {}\n", r.by_device, r.alpha.value_or(0),
                       static_cast<int>(r.stiffness), r.knows_gap, static_cast<int>(r.cap.kind), r.cap.fixed_N_per_m);
  }
  std::string operator()(const SmithRender& r) const {
    return fmt::format(" render smith {} {} {} factor {}\n", r.mode.frequency_Hz.value_or(0),
                       r.mode.damping_ratio.value_or(0), r.mode.static_N_per_m.value_or(0), r.factor);
  }
};

std::string timing_text(const TimingSpec& t) {
  const ProgrammedTiming& p = t.programmed;
  std::string out =
      fmt::format("segment {} V {} N {} s {} order {} cv {} {} seed {} paced {} real {}", at(p.segment), at(p.visualization),
                  fmt::join(p.steps, ","), p.step ? at(*p.step) : "fill", static_cast<int>(p.order),
                  p.visualization_variation, p.step_variation, p.seed, p.paced, t.real_steps);
  out += fmt::format(" first {} slowdown {} drift {} dropped {} merged {}", p.first_step, p.slowdown, p.drift_per_s,
                     p.dropped_visualization, p.merged_visualization);
  if (p.spikes) out += fmt::format(" spikes {} {}", p.spikes->rate_Hz, at(p.spikes->cost));
  if (p.preemption)
    out += fmt::format(" preemption {} {} {} {}", p.preemption->rate_Hz, at(p.preemption->least), at(p.preemption->most),
                       p.preemption->tail);
  if (p.regimes) out += fmt::format(" regimes {} {} {}", p.regimes->factor, p.regimes->mean_length, p.regimes->slow_share);
  if (p.hitch) out += fmt::format(" hitch {} {}", at(p.hitch->every), at(p.hitch->visualization));
  if (p.accumulator)
    out += fmt::format(" accumulator {} {} {} {}", at(p.accumulator->step_rate), p.accumulator->max_steps.value_or(0),
                       at(p.accumulator->jitter_fix), at(p.accumulator->refresh_jitter));
  out += fmt::format(" law {} {}", static_cast<int>(p.visualization_law), static_cast<int>(p.step_law));
  for (const TimingChange& change : p.changes) {
    out += fmt::format(" change {} V {} s {} N {}", change.at.ns, change.visualization ? at(*change.visualization) : "same",
                       change.step ? at(*change.step) : "same", fmt::join(change.steps, ","));
  }
  out += " trace";
  for (const SegmentTiming& segment : t.trace) {
    out += fmt::format(" [{} {} {}", segment.index, segment.begin.ns, segment.end.ns);
    if (segment.visualization)
      out += fmt::format(" V {} {}", segment.visualization->begin.ns, segment.visualization->end.ns);
    for (const Interval& step : segment.steps) out += fmt::format(" {} {}", step.begin.ns, step.end.ns);
    out += "]";
  }
  return out + "\n";
}

std::string pid_text(const PidSpec& p) {
  const PidOptions& o = p.options;
  std::string out = fmt::format(" pid {} {} {} scale {} gain {} duration {}", o.travel_m.x, o.travel_m.y, o.travel_m.z,
                                o.full_scale_N.value_or(-1), o.gain, o.effect_duration ? o.effect_duration->ns : -1);
  out += fmt::format(" flavour {} board {} pool {} error {}", static_cast<int>(p.flavour),
                     p.board ? static_cast<int>(*p.board) : -1, p.pool_effects, p.block_load_error_at);
  for (std::size_t axis = 0; axis < pid::kAxes; ++axis)
    out += fmt::format(" {} {}", o.reversed_force[axis], o.reversed_spring[axis] ? *o.reversed_spring[axis] : -1);
  out += " events";
  for (const PidDeviceEvent& e : p.events) out += fmt::format(" {} {} {}", static_cast<int>(e.kind), e.at.ns, e.on);
  return out;
}

std::string evdev_text(const EvdevSpec& e) {
  const EvdevOptions& o = e.options;
  std::string out = fmt::format(" evdev {} {} {} scale {} gain {} duration {} updates {} {} still {}", o.travel_m.x,
                                o.travel_m.y, o.travel_m.z, o.full_scale_N.value_or(-1), o.gain, o.effect_duration.ns,
                                o.update_rate.num, o.update_rate.den, o.still.ns);
  for (std::size_t axis = 0; axis < 2; ++axis)
    out += fmt::format(" {} {}", o.reversed_force[axis], o.reversed_spring[axis] ? *o.reversed_spring[axis] : -1);
  return out + fmt::format(" effects {} {} {} {} interval {}", e.effects, e.foreign_effects, e.held,
                           e.meddled_at ? e.meddled_at->ns : -1, e.report_interval ? e.report_interval->ns : -1);
}

std::string inverse3_text(const Inverse3Spec& i) {
  const Inverse3Options& o = i.options;
  return fmt::format(" inverse3 {} {} {} shared {} updates {} {} hold {} remote {} in use {} uncalibrated {}", o.origin_m.x,
                     o.origin_m.y, o.origin_m.z, o.shared, i.update_rate.num, i.update_rate.den, i.hold.ns, i.remote,
                     i.in_use, i.uncalibrated_at ? i.uncalibrated_at->ns : -1);
}

std::string case_text(const CaseSpec& c) {
  std::string out =
      fmt::format("case {} values {} periods {} most {} duration {} step {} particles {} iterations {} unstable {}", c.kind,
                  fmt::join(c.values, ","), c.periods, c.most_steps, c.duration_s, at(c.step_size), c.particles,
                  c.iterations, c.allow_unstable);
  for (const Method method : c.methods) out += fmt::format(" {}", name_of(method));
  for (const SolverKind solver : c.solvers) out += fmt::format(" {}", name_of(solver));
  return out + "\n";
}

}  // namespace

const char* const kSpring = R"(format = 1
name = "spring"
because = "the smallest good file"
tags = ["ci"]
[run]
duration = "4 s"
warmup = "8 segments"
[timing]
segment = "30 Hz"
visualization = "11.1 ms"
steps = 15
[scene]
kind = "spring"
stiffness = "200 N/m"
[[device]]
name = "left"
motion = { kind = "constant-velocity", velocity = ["0.1 m/s", "0 m/s", "0 m/s"], start = "smooth 0.2 s" }
[[expect]]
signal = "left.interaction.direct"
metric = "velocity_jump"
min = "4 step"
)";

const char* const kTissue = R"(format = 1
[run]
duration = "1 s"
strategies = ["ideal", "phase_locked"]
[timing]
segment = "30 Hz"
visualization = "11.1 ms"
steps = [14, 15, 16]
jitter = { visualization = "lognormal 10 %", step = "lognormal 2.5%" }
[scene]
kind = "tissue"
lattice = [9, 9, 10]
particles = 800
damping = "1 mN s/m"
[[device]]
name = "left"
grab = { center = ["20 mm", "20 mm", "45 mm"], radius = "6 mm" }
motion = { kind = "ramp-stop", velocity = ["10 mm/s", "0 m/s", "0 m/s"], start = "smooth 0.1 s", stop = "0.5 s" }
[[device]]
name = "right"
phase = "0.5 ms"
queue = "libusb"
grab = { center = ["20 mm", "0 mm", "45 mm"], radius = "6 mm" }
motion = { kind = "sine", amplitude = ["1 mm", "0 m", "0 m"], frequency = "1/3 Hz", delay = "0.1 s" }
render = { kind = "force", emission = "hold" }
[remap]
latency = "2 segments"
[[expect]]
signal = "*.force.*"
metric = "jump_max"
max = 0.5
[[expect]]
signal = "solver.phase_locked"
metric = "energy_growth"
max = 1
[expect_stop]
reason = "diverged"
at_most_step = 100
)";

const char* const kPid = R"(format = 1
[run]
duration = "4 s"
interrupt = "3 s"
[timing]
segment = "30 Hz"
visualization = "11.1 ms"
steps = 15
[scene]
kind = "spring"
stiffness = "200 N/m"
[[device]]
name = "left"
driver = "pid"
faults = [
  { kind = "unread", at = "1.0005 s", ticks = 3 },
  { kind = "write-lost", at = "0.5 s", amount = 7 },
]
events = [{ kind = "actuator-power", at = "2 s", on = false }]
unplug = "3.5 s"
[device.pid]
travel = ["0.2 m", "0.1 m", "0 m"]
full_scale = "5 N"
gain = 0.5
effect_duration = "2 s"
flavour = "array"
firmware = "openffboard-2"
reversed_force = ["x"]
springs = ["x", "-y"]
pool = 3
block_load_error = 2
[expect_stop]
reason = "interrupted"
message = "at 3 s"
at_least_step = 1300
at_most_step = 1400
)";

ReadResult read_text(const std::string& text, const ReadOptions& options) {
  const TemporaryFolder folder;
  return read_scenario(folder.write("scenario.toml", text), options);
}

std::string errors_of(const ReadResult& result) {
  std::string out;
  for (Diagnostic error : result.error_or({})) {
    if (error.line != 0 || error.file.rfind("--", 0) != 0)
      error.file = std::filesystem::path(error.file).filename().string();
    out += text(error) + "\n";
  }
  return out;
}

std::string describe(const Scenario& s) {
  std::string out =
      fmt::format("name {}\nbecause {}\ntags {}\nduration {} warmup {} seed {} live {} strategies", s.name, s.because,
                  fmt::join(s.tags, ","), at(s.run_duration), at(s.warmup), s.seed, name_of(s.live));
  for (const StrategyKind kind : s.strategies) out += fmt::format(" {}", name_of(kind));
  out += "\n" + timing_text(s.timing);
  out +=
      fmt::format("solver {} {} step_rate {} tools {} energy {} unstable {} model {} group {}\n", static_cast<int>(s.solver),
                  std::visit(SceneText{}, s.scene.body), at(s.scene.step_rate), s.scene.tool_count, s.scene.needs_energy,
                  s.scene.allow_unstable, static_cast<int>(s.scene.local_model), s.solver_options.work_group_size);
  for (const DeviceSpec& d : s.devices) {
    out += fmt::format("device {} {} phase {} queue {} {} begin {} emission {} limits {} {} {} delay {}{}\n", d.name,
                       at(d.rate), at(d.phase), static_cast<int>(d.queue), std::visit(MotionText{}, d.motion.shape),
                       d.motion.begin.ns, static_cast<int>(d.emission), d.limits.max_N, d.limits.max_slew_N_per_s,
                       d.expects_saturation, at(d.force_delay), d.hand ? hand_text(*d.hand) : "");
    out += std::visit(RenderText{}, d.render);
  }
  for (const DeviceSpec& d : s.devices) {
    out +=
        fmt::format("device {} unplug {} {} faults", d.name, d.unplug ? d.unplug->ns : -1, d.returns ? d.returns->ns : -1);
    for (const ReportFault& f : d.faults) out += fmt::format(" {} {} {}", static_cast<int>(f.kind), f.tick, f.amount);
    if (const auto* pid = std::get_if<PidSpec>(&d.driver)) out += pid_text(*pid);
    if (const auto* evdev = std::get_if<EvdevSpec>(&d.driver)) out += evdev_text(*evdev);
    if (const auto* inverse3 = std::get_if<Inverse3Spec>(&d.driver)) out += inverse3_text(*inverse3);
    if (const auto* foreign = std::get_if<ForeignDriverSpec>(&d.driver))
      out += fmt::format(" foreign {} {}", foreign->part.name, foreign->part.options);
    out += "\n";
  }
  out += fmt::format("remap {} {} {} {} {} {} {} {} predict {} filter {} {} {} dropped {}\n", s.remap.estimate_weight,
                     s.remap.estimate_steps == StepCount::last ? "last" : "average", s.remap.bandwidth_Hz, s.remap.jump,
                     at(s.remap.latency), at(s.remap.lead), name_of(s.remap.interaction_underrun),
                     name_of(s.remap.force_underrun), s.remap.predict_window.ns, s.remap.filter.index(),
                     s.remap.filter_window.ns, s.remap.filter_force, s.remap.dropped_jump.value_or(0));
  if (s.timing.source) out += fmt::format(" source {} {}\n", s.timing.source->name, s.timing.source->options);
  if (s.remap.foreign) out += fmt::format(" foreign {} {}\n", s.remap.foreign->name, s.remap.foreign->options);
  const AdaptiveLatencyOptions& adapt = s.remap.adapt;
  out += fmt::format(" adapt {} {} {} {} {} {}\n", at(adapt.start), at(adapt.least), at(adapt.most), at(adapt.window),
                     at(adapt.margin), adapt.slew_ppm);
  out += fmt::format("study {} {} repeats {} iterations {}", static_cast<int>(s.study.error), at(s.study.duration),
                     s.study.repeats, fmt::join(s.study.iterations, ","));
  for (const Method method : s.study.methods) out += fmt::format(" {}", name_of(method));
  for (const SolverKind solver : s.study.solvers) out += fmt::format(" {}", name_of(solver));
  for (const StudyStep& step : s.study.steps) out += fmt::format(" {}/{}", step.steps, step.substeps);
  if (s.study.stiffness_limit)
    out += fmt::format(" stiffness {} {} {} {}", s.study.stiffness_limit->from_N_per_m, s.study.stiffness_limit->to_N_per_m,
                       s.study.stiffness_limit->seeds, s.study.stiffness_limit->scales_mass);
  out += fmt::format("\nkeep {} undelayed {}\n", s.keep_rows, s.needs_undelayed);
  for (const Expectation& e : s.expectations) {
    out += fmt::format("expect {} {} '{}' min {} max {} fail {}", e.signal, e.metric, e.because, at(e.min), at(e.max),
                       e.expect_fail);
    out += e.at ? fmt::format(" at {} {}\n", (*e.at)[0], (*e.at)[1]) : "\n";
  }
  if (s.case_spec) out += case_text(*s.case_spec);
  if (s.expect_stop)
    out += fmt::format("stop {} '{}' {} {}\n", s.expect_stop->reason, s.expect_stop->message,
                       s.expect_stop->at_least_step.value_or(-1), s.expect_stop->at_most_step.value_or(-1));
  if (s.interrupt) out += fmt::format("interrupt {}\n", s.interrupt->ns);
  return out + fmt::format("nominal {} {} {} {}\n", at(s.nominal.segment), at(s.nominal.visualization), at(s.nominal.slot),
                           at(s.nominal.step_run_time));
}

std::string with_timing(const std::string& timing) {
  std::string text = kSpring;
  text.erase(text.find("warmup"), text.find("[timing]") - text.find("warmup"));
  const std::size_t from = text.find("segment = "), to = text.find("[scene]");
  return text.replace(from, to - from, timing + "\n");
}

}  // namespace evenstep::test
