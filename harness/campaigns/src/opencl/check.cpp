#include "evenstep/campaigns/opencl_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/harness/run.h"
#include "evenstep/harness/visualization.h"
#include "evenstep/harness/watched_solver.h"
#include "evenstep/reports/run_failure.h"

namespace evenstep {
namespace {

using RowState = OpenClCheckRow::State;

constexpr int kComparedSteps = 40;
constexpr double kSpacing_m = 5e-3;

// Positions and lengths are sums and products only: nothing that is compared bit by bit may depend on libm.

std::array<glm::dvec3, kMaxTools> tools_at(int n) {
  const double t = n / 100.0;
  return {glm::dvec3(0.01 * t * t, -0.004 * t * (1 - t), 0.012 * t),
          glm::dvec3(0.002 - 0.01 * t, 0.003 * t, -0.008 * t * t)};
}

std::vector<ToolCoupling> tools_of(CouplingKind first, CouplingKind second) {
  const auto tool = [](CouplingKind kind, const glm::dvec3& site) -> ToolCoupling {
    if (kind == CouplingKind::grab) return {site * kSpacing_m, 0.6 * kSpacing_m};
    if (kind == CouplingKind::spring) return {site * kSpacing_m, 1.1 * kSpacing_m, kind, 60, 0.02};
    return {(site + glm::dvec3(0.1, 0.2, 1.5)) * kSpacing_m, 1.8 * kSpacing_m, kind, 35};  // touches the top layer
  };
  return {tool(first, {1, 1, 3}), tool(second, {4, 2, 3})};
}

/// 6 x 4 x 5 sites with a ragged top layer; `rich`: with every material and force that a tissue can have.
Scene small_scene(Method method, const std::vector<ToolCoupling>& tools, bool rich) {
  TissueScene tissue;
  tissue.lattice = {6, 4, 5};
  tissue.particle_count = 6 * 4 * 5 - 7;
  tissue.spacing_m = kSpacing_m;
  tissue.particle_mass_kg = 1e-4;
  tissue.stiffness_N_per_m = 20;
  tissue.method = method;
  tissue.tools = tools;
  if (rich) {
    tissue.damping_per_s = 20;
    tissue.axial_damping_N_s_per_m = 2e-3;
    tissue.gravity_m_per_s2 = {0.5, 0, -9.81};
    tissue.regions = {{{-1, -1, 6e-3}, {12e-3, 1, 1}, 55, 3e-4}, {{8e-3, 4e-3, 0}, {1, 1, 16e-3}, 7, 0.4e-4}};
  }
  Scene scene{std::move(tissue)};
  scene.step_rate = {1000, 1};
  scene.tool_count = static_cast<int>(tools.size());
  scene.needs_state_digest = true;
  scene.needs_energy = scene.variable_step = rich;
  return scene;
}

bool same_steps(Solver& cpu, Solver& opencl, bool rich) {
  for (int n = 0; n < kComparedSteps; ++n) {
    const auto at_m = tools_at(n);
    const std::optional<double> length_s = rich ? std::optional(1e-3 + 1e-4 * (n % 3)) : std::nullopt;
    const ToolResponse a = cpu.step(at_m, length_s), b = opencl.step(at_m, length_s);
    const double energy_a = cpu.verdict().energy_J, energy_b = opencl.verdict().energy_J;
    if (std::memcmp(&a.force_N, &b.force_N, sizeof a.force_N) != 0 || cpu.state_digest() != opencl.state_digest() ||
        std::memcmp(&energy_a, &energy_b, sizeof energy_a) != 0)
      return false;
  }
  return true;
}

/// A block with a tool that is dragged to and fro, four substeps a step, as Figure 1 has.
Scene timed_scene(const TimedBlock& block) {
  const std::array<int, 3>& lattice = block.lattice;
  TissueScene tissue;
  tissue.lattice = lattice;
  tissue.particle_count = block.particles;
  tissue.damping_per_s = 20;
  tissue.substeps = 4;
  const glm::dvec3 middle(lattice[0] / 2, lattice[1] / 2, lattice[2] - 2);
  tissue.tools = {{middle * tissue.spacing_m, 1.5 * tissue.spacing_m}};
  Scene scene{std::move(tissue)};
  scene.step_rate = {450, 1};
  scene.tool_count = 1;
  return scene;
}

std::string in_ms(std::int64_t ns) { return fmt::format("{:.3f}", static_cast<double>(ns) * 1e-6); }

class Check {
 public:
  Check(const OpenClListed& device, const OpenClCheckOptions& options) : options_(options) {
    check_.device = device;
    with_.opencl_device = opencl_text({device}, 0);
  }

  OpenClCheck run() {
    row("what it is", [&] { return describe(); });
    row("bits of small scenes with every feature, against cpu", [&] { return bits(); });
    row("Figure 1 in virtual time, against cpu", [&] { return figure_1(); });
    for (const TimedBlock& block : options_.blocks)
      row(fmt::format("steps of {} particles, 4 substeps", block.particles), [&] { return speed(block); });
    for (const char* visualization : {"11.1 ms", "burn 11.1 ms", "render"})
      row(fmt::format("recording of Figure 1, visualization \"{}\"", visualization), [&] { return record(visualization); });
    row("live run of scenarios/live/figure-1-gpu.toml", [&] { return live(); });
    return std::move(check_);
  }

 private:
  /// Adds what `find` finds; where it throws, the reason.
  template <class Find>
  void row(const std::string& what, Find find) {
    if (options_.interrupted && *options_.interrupted) return;
    if (options_.progress) options_.progress(what);
    OpenClCheckRow row{what, "", RowState::found};
    try {
      row.text = find();
    } catch (const Different& different) {
      row.state = RowState::differs;
      row.text = different.what;
    } catch (const SolverError& error) {
      row.state = RowState::missing;
      row.text = std::string(error.what()) + "; " + error.remedy();
    } catch (const RunFailure& failure) {
      row.state = RowState::missing;
      row.text = std::string(failure.what()) + "; " + failure.remedy;
    }
    check_.rows.push_back(std::move(row));
  }
  struct Different {
    std::string what;
  };

  std::string describe() {
    check_.description = describe_opencl(with_);
    const OpenClDescription& said = check_.description;
    return fmt::format(
        "{}, driver {}, {}; {} compute units, at most {} MHz, {}", check_.device.is_gpu ? "GPU" : "processor", said.driver,
        said.version, said.compute_units, said.clock_MHz,
        said.timer_resolution_ns > 0 ? fmt::format("times of {} ns", said.timer_resolution_ns) : "no times of commands");
  }

  std::string bits() {
    constexpr std::array kKinds{CouplingKind::grab, CouplingKind::spring, CouplingKind::probe};
    int scenes = 0, equal = 0;
    for (const Method method : {Method::symplectic_euler, Method::velocity_verlet, Method::implicit_euler}) {
      for (std::size_t kind = 0; kind < kKinds.size(); ++kind) {
        for (const bool rich : {false, true}) {
          const Scene scene = small_scene(method, tools_of(kKinds[kind], kKinds[(kind + 1) % kKinds.size()]), rich);
          const auto cpu = make_solver(SolverKind::cpu_float, scene), opencl = make_solver(SolverKind::opencl, scene, with_);
          ++scenes;
          equal += same_steps(*cpu, *opencl, rich);
        }
      }
    }
    const std::string text =
        fmt::format("{} of {} equal: forces, state and energy of {} steps each", equal, scenes, kComparedSteps);
    if (equal < scenes) throw Different{text};
    return text;
  }

  Scenario read(const std::string& file, std::vector<std::string> set) {
    set.insert(set.end(), options_.overrides.begin(), options_.overrides.end());
    ReadResult read = options_.read(file, set);
    if (!read)
      throw RunFailure("scenario", text(read.error().front()), "install evenstep's scenarios, or run it where they are");
    Scenario scenario = *std::move(read);
    scenario.solver_options.opencl_device = with_.opencl_device;
    if (const auto missing = missing_in_build(scenario, ClockKind::wall); !missing.empty())
      throw RunFailure("build", text(missing.front()), "another build");
    return scenario;
  }

  std::string figure_1() {
    Scenario scenario = read("scenarios/paper/figure-1.toml", {});
    std::array<std::uint64_t, 2> trace{};
    for (const SolverKind kind : {SolverKind::opencl, SolverKind::cpu_float}) {
      scenario.solver = kind;
      const RunOutcome outcome = run_scenario(scenario, {});
      if (!outcome.failure.empty()) throw RunFailure("run", outcome.failure, outcome.remedy);
      trace[kind == SolverKind::cpu_float ? 1 : 0] = outcome.record.trace_hash;
    }
    if (trace[0] != trace[1]) throw Different{fmt::format("trace {:016x}, of cpu {:016x}", trace[0], trace[1])};
    return fmt::format("trace {:016x}, the same", trace[0]);
  }

  std::string speed(const TimedBlock& block) {
    SolverOptions logging = with_;
    logging.log_commands = true;
    const Scene scene = timed_scene(block);
    std::int64_t n = 0;
    const auto step = [&](Solver& solver) {
      const auto phase = static_cast<double>(n++ % 40);
      solver.step(std::array{glm::dvec3(1e-4 * (phase < 20 ? phase : 40 - phase), 0, 0)});
    };
    const auto solver = make_solver(SolverKind::opencl, scene, with_);
    for (int warm = 0; warm < 20; ++warm) step(*solver);
    std::int64_t steps = 0;
    const double began_s = monotonic_seconds(), end_s = began_s + seconds(options_.timed);
    double now_s = began_s;
    for (; now_s < end_s || steps < 10; now_s = monotonic_seconds(), ++steps) step(*solver);
    const double us = 1e6 * (now_s - began_s) / static_cast<double>(steps);
    const auto logged = make_solver(SolverKind::opencl, scene, logging);
    for (int warm = 0; warm < 20; ++warm) step(*logged);
    logged->command_log()->take();
    constexpr int kLogged = 20;
    for (int more = 0; more < kLogged; ++more) step(*logged);
    const std::vector<DeviceCommand> commands = logged->command_log()->take();
    return fmt::format("{:.1f} us a step, {:.0f} a second; {}", us, 1e6 / us, check_text(commands, kLogged));
  }

  std::string record(const std::string& visualization) {
    const Scenario scenario =
        read("scenarios/paper/figure-1.toml", {fmt::format("timing.visualization=\"{}\"", visualization)});
    WatchedSolver solver(make_recorded_solver(scenario, true), scenario.scene.tool_count);
    const auto work = make_visualization(scenario, solver);
    WallClock clock(WallEpoch::in(Duration{100'000'000}));
    const RecordSummary summary = summarize(
        record_solver(scenario, solver, clock,
                      {.length = options_.recorded, .interrupted = options_.interrupted, .visualization = work.get()}));
    return check_text(summary) + (work ? "; " + work->text() : "");
  }

  std::string live() {
    Scenario scenario = read("scenarios/live/figure-1-gpu.toml", {fmt::format("run.duration=\"{} ns\"", options_.live.ns)});
    RunOptions options;
    options.clock = ClockKind::wall;
    options.control.interrupted = options_.interrupted;
    const RunOutcome outcome = run_scenario(scenario, options);
    if (!outcome.failure.empty()) throw RunFailure("run", outcome.failure, outcome.remedy);
    const auto tick = [&](const char* metric) { return value_or_0(outcome.metrics, "events.device.tick", metric); };
    std::string text =
        fmt::format("{}: lateness p99 {:.3f}, max {:.3f} ms, {:g} of {:g} ticks missed", name_of(outcome.verdict),
                    1e3 * tick("lateness_p99"), 1e3 * tick("lateness_max"), tick("deadline_misses"), tick("ticks_run"));
    for (const DeviceSpec& device : scenario.devices) {
      const std::string signal = device.name + ".buffers." + name_of(scenario.live);
      text += fmt::format(", {:g} underruns of {}", value_or_0(outcome.metrics, signal, "underruns"), device.name);
    }
    return text + (outcome.record.visualization.empty() ? "" : "; " + outcome.record.visualization);
  }

  const OpenClCheckOptions& options_;
  SolverOptions with_;
  OpenClCheck check_;
};

/// In a cell of a table a driver's bar or line break would begin another one.
std::string cell(std::string text) {
  for (char& c : text)
    if (c == '|' || static_cast<unsigned char>(c) < 0x20) c = ' ';
  return text;
}

}  // namespace

bool OpenClCheck::any(OpenClCheckRow::State state) const {
  return std::any_of(rows.begin(), rows.end(), [&](const OpenClCheckRow& row) { return row.state == state; });
}

std::string check_text(const std::vector<DeviceCommand>& commands, std::int64_t steps) {
  const auto count = static_cast<std::int64_t>(commands.size());
  std::string text = fmt::format("on the device {} commands a step, ", count / steps);
  if (!std::all_of(commands.begin(), commands.end(), std::mem_fn(&DeviceCommand::has_times)))
    return text + "whose times it does not say";
  double busy_us = 0;
  for (const DeviceCommand& command : commands) busy_us += 1e-3 * static_cast<double>(command.ended_ns - command.started_ns);
  return text + fmt::format("which run for {:.1f} us", busy_us / static_cast<double>(steps));
}

std::string check_text(const RecordSummary& summary) {
  std::string text = fmt::format("a step p50 {}, p99 {}, max {} ms, ", in_ms(summary.host.p50), in_ms(summary.host.p99),
                                 in_ms(summary.host.max));
  text += summary.steps_on_device > 0
              ? fmt::format("on the device p50 {}, p99 {}", in_ms(summary.span.p50), in_ms(summary.span.p99))
              : "on the device unknown";
  text +=
      fmt::format("; a visualization p50 {}, max {} ms", in_ms(summary.visualization.p50), in_ms(summary.visualization.max));
  if (summary.steps_beyond_host > 0)
    text += fmt::format("; {} steps longer on the device than on the host", summary.steps_beyond_host);
  return text;
}

OpenClCheck check_opencl(const OpenClListed& device, const OpenClCheckOptions& options) {
  return Check(device, options).run();
}

std::string check_table(const std::vector<OpenClCheck>& checks, const RecordedMachine& machine) {
  constexpr const char* kMarks[] = {"", "DIFFERS: ", "missing: "};
  std::string table;
  for (const OpenClCheck& check : checks) {
    table += fmt::format("| {} | |\n|---|---|\n", cell(opencl_text({check.device}, 0)));
    table += fmt::format("| host | {} x {}, {} |\n", machine.processors, cell(machine.processor), cell(machine.system));
    for (const OpenClCheckRow& row : check.rows)
      table += fmt::format("| {} | {}{} |\n", cell(row.what), kMarks[static_cast<int>(row.state)], cell(row.text));
    table += "\n";
  }
  return table;
}

}  // namespace evenstep
