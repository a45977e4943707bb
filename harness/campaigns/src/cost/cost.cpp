#include "evenstep/campaigns/cost.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/device/hid/hidapi_transport.h"
#include "evenstep/harness/run_folder.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/harness/strategy_lanes.h"
#include "pairs.h"

namespace evenstep {
namespace {

using internal::Opened;
using internal::Side;
using internal::StepPairs;
using internal::ToolPath;

constexpr int kChildren = 7;
constexpr std::int64_t kLongestPath = 100'000;
/// The first run is at least this long; from its CPU time follows how long the measured ones are.
constexpr Duration kFirstRun{100'000'000};

bool is_tissue(const Scenario& scenario) { return std::holds_alternative<TissueScene>(scenario.scene.body); }

/// The tools on the intended motions of the devices, at the even instants of the steps.
ToolPath path_of(const Scenario& scenario) {
  const Rate rate = scenario.scene.step_rate;
  const std::int64_t steps = floor_mul_div(scenario.run_duration.ns, rate.num, rate.den * 1'000'000'000);
  ToolPath path(static_cast<std::size_t>(std::clamp<std::int64_t>(steps, 1, kLongestPath)));
  for (std::size_t n = 0; n < path.size(); ++n) {
    for (std::size_t tool = 0; tool < scenario.devices.size() && tool < kMaxTools; ++tool)
      path[n][tool] = position_m(scenario.devices[tool].motion, tick_time(rate, static_cast<std::int64_t>(n), RealTime{0}));
  }
  return path;
}

/// The parts that are asked for by one flag of the scene each.
struct SceneFlag {
  const char* part;
  bool is_on;
  std::string why;
  Scene without;
};

std::vector<SceneFlag> flags_of(const Scenario& scenario, const Scene& scene) {
  std::vector<SceneFlag> flags;
  const auto add = [&](const char* part, bool is_on, std::string why, auto switch_off) {
    Scene without = scene;
    switch_off(without);
    flags.push_back({part, is_on, std::move(why), without});
  };
  const auto energy = std::find_if(scenario.expectations.begin(), scenario.expectations.end(),
                                   [](const Expectation& one) { return one.metric.starts_with("energy_"); });
  add("energy", scene.needs_energy && accounts_energy(scene),
      energy == scenario.expectations.end()
          ? ""
          : fmt::format("{} of {}, {}:{}", energy->metric, energy->signal, energy->place.file, energy->place.line),
      [](Scene& off) { off.needs_energy = false; });
  add("state digest", scene.needs_state_digest, "the trace hash", [](Scene& off) { off.needs_state_digest = false; });
  add("local model", scene.local_model != LocalModel::none, "a device's render: it reads the contacts",
      [](Scene& off) { off.local_model = LocalModel::none; });
  return flags;
}

/// Whether a solver does nothing for a part that was asked for: a spring has no state to digest.
bool is_left_out(const std::string& part, const Scene& scene) {
  const std::vector<std::string> names = left_out(scene);
  return std::find(names.begin(), names.end(), part) != names.end();
}

void put_pairs(const StepPairs& pairs, PartCost& cost) {
  std::vector<double> percent;
  for (std::size_t n = 0; n < pairs.with_s.size(); ++n) {
    const double whole_s = cost.is_kept ? pairs.with_s[n] : pairs.without_s[n];
    percent.push_back(whole_s > 0 ? 100 * (pairs.with_s[n] - pairs.without_s[n]) / whole_s : 0);
  }
  cost.of = "a step";
  cost.percent = measured(percent);
  cost.bits = pairs.same_bits ? PartCost::Bits::equal : PartCost::Bits::differ;
  cost.compared = fmt::format("forces{} of {} steps", pairs.compared_particles ? " and particles" : "", pairs.steps);
}

class Measurement {
 public:
  Measurement(const Scenario& scenario, const CostOptions& options)
      : scenario_(scenario), options_(options), plans_(plan(scenario)), scene_(scenario.scene), path_(path_of(scenario)) {
    scene_.variable_step = traits_of(scenario.live).varies_step;
  }

  CostReport report() {
    libraries();
    solver_parts();
    run_parts();
    std::stable_sort(report_.parts.begin(), report_.parts.end(),
                     [](const PartCost& a, const PartCost& b) { return a.is_kept > b.is_kept; });
    return std::move(report_);
  }

 private:
  bool stopped() const { return options_.interrupted && *options_.interrupted; }
  bool uses_opencl() const { return is_tissue(scenario_) && scenario_.solver == SolverKind::opencl; }
  void announce(const std::string& part) const {
    if (options_.progress) options_.progress(part);
  }
  PartCost& add(const std::string& part, bool is_kept, const std::string& why) {
    announce(part);
    return report_.parts.emplace_back(PartCost{.part = part, .is_kept = is_kept, .why = why});
  }
  Side side(const Scene& scene) const { return {make_solver(scenario_.solver, scene, scenario_.solver_options), scene}; }

  void libraries() {
    // Once per process, because after that the process itself has opened OpenCL.
    static const Opened opencl = internal::opened_in_children([] { open_opencl(); }, kChildren);
    static const Opened hidapi = internal::opened_in_children([] { hid_devices(); }, kChildren);
    put_library(add("OpenCL", uses_opencl(), uses_opencl() ? "solver = \"opencl\"" : "not loaded: no solver needs it"),
                opencl);
    put_library(add("hidapi", false, "not loaded: no --device"), hidapi);
  }
  static void put_library(PartCost& cost, const Opened& opened) {
    if (!opened.error.empty()) {
      cost.why += "; " + opened.error;
      return;
    }
    cost.cpu_ms = opened.cpu_ms;
    cost.resident_MiB = opened.resident_MiB;
  }

  void solver_parts() {
    report_.steps = describe(scenario_.scene);
    for (const SceneFlag& flag : flags_of(scenario_, scene_)) {
      if (!flag.is_on || is_left_out(flag.part, scene_) || stopped()) continue;
      Side with = side(scene_), without = side(flag.without);
      put_pairs(step_pairs(with, without, path_, options_), add(flag.part, true, flag.why));
    }
    for (const std::string& feature : left_out(scene_)) {
      if (!stopped()) absent_part(add(feature, false, ""));
    }
    if (uses_opencl() && !stopped()) opencl_or_cpu();
  }

  /// The program's own solver is asked for the part although the scene does not need it. If it still leaves the part out, it
  /// has none.
  void absent_foreign_part(PartCost& cost) {
    Scene scene = scene_;
    scene.variable_step |= cost.part == "variable step";
    scene.needs_state_digest |= cost.part == "state digest";
    scene.needs_energy |= cost.part == "energy";
    if (cost.part == "local model") scene.local_model = LocalModel::instantaneous;
    try {
      if (is_left_out(cost.part, scene)) {
        cost.why = "the solver has none";
        return;
      }
      Side with = side(scene), without = side(scene_);
      put_pairs(step_pairs(with, without, path_, options_), cost);
    } catch (const SolverError& error) {
      cost.why = fmt::format("not measured: {}", error.what());
    }
  }

  void absent_part(PartCost& cost) {
    if (std::holds_alternative<ForeignScene>(scenario_.scene.body)) return absent_foreign_part(cost);
    Scene scene = scene_;
    scene.variable_step |= cost.part == "variable step";
    scene.needs_state_digest |= cost.part == "state digest";
    try {
      Side with{make_solver_with(cost.part, scenario_.solver, scene_, scenario_.solver_options), scene},
          without = side(scene_);
      if (with.solver) return put_pairs(step_pairs(with, without, path_, options_), cost);
      cost.why = is_tissue(scenario_) ? "not measured: with it, it would be another scene" : "a scene of this kind has none";
    } catch (const SolverError& error) {
      cost.why = fmt::format("not measured: {}", error.what());
    }
  }

  void opencl_or_cpu() {
    Side with = side(scene_), without{make_solver(SolverKind::cpu_float, scene_, scenario_.solver_options), scene_};
    put_pairs(step_pairs(with, without, path_, options_), add("OpenCL instead of cpu", true, "solver = \"opencl\""));
  }

  /// A variant of the run: the run without one part.
  struct Variant {
    std::size_t part;  ///< in the report
    Scenario scenario;
    std::vector<StrategyPlan> plans;
    int threads = 1;
    std::vector<double> percent;
    bool same_bits = true;
  };

  void run_parts() {
    shorten();
    std::vector<Variant> variants = run_variants();
    const std::size_t metrics = report_.parts.size();
    add("metrics", true, "summary.json and the expectations");
    add("figures", true, "the run folder");
    add("other files", true, "the run folder");
    std::array<std::vector<double>, 3> outputs;
    for (int round = 0; round < options_.run_pairs && !stopped(); ++round) {
      announce(fmt::format("run {} of {}", round + 1, options_.run_pairs));
      RunOutcome outcome;
      const double base_s = timed([&] { outcome.record = record_run(short_, plans_, one_thread()); });
      const std::array made_s{timed([&] {
                                outcome.metrics = measure(outcome.record);
                                add_growths(outcome.record, outcome.metrics);
                              }),
                              timed([&] { write_nowhere(figures(short_, outcome)); }),
                              timed([&] { write_nowhere(data_files(short_, outcome, "")); })};
      for (std::size_t n = 0; n < outputs.size(); ++n)
        outputs[n].push_back(100 * made_s[n] / (base_s + made_s[0] + made_s[1] + made_s[2]));
      for (Variant& variant : variants) run_variant(variant, outcome.record, base_s);
    }
    for (const Variant& variant : variants) put_variant(variant);
    for (std::size_t n = 0; n < outputs.size(); ++n) {
      report_.parts[metrics + n].of = "the run";
      report_.parts[metrics + n].percent = measured(outputs[n]);
    }
  }

  static void write_nowhere(const std::vector<FolderFile>& files) {
    std::ostringstream bytes;
    for (const FolderFile& file : files) file.write(bytes);
  }

  template <class Work>
  static double timed(Work work) {
    const double began_s = process_cpu_seconds();
    work();
    return process_cpu_seconds() - began_s;
  }
  RunOptions one_thread() const {
    RunOptions options;
    options.threads = 1;
    options.control.interrupted = options_.interrupted;
    return options;
  }

  /// Cuts the run short, if it takes long.
  void shorten() {
    short_ = scenario_;
    short_.interrupt.reset();
    // It must reach what is judged and drawn.
    const Duration judged_too{scenario_.warmup.ns / 4 * 5};
    short_.run_duration = std::min(scenario_.run_duration, std::max(kFirstRun, judged_too));
    const double first_s = timed([&] { record_run(short_, plans_, one_thread()); });
    const double times = std::clamp(options_.run_seconds / std::max(first_s, 1e-9), 1.0, 1e6);
    if (short_.run_duration.ns < scenario_.run_duration.ns) {
      const double ns = static_cast<double>(short_.run_duration.ns) * times;
      short_.run_duration =
          Duration{static_cast<std::int64_t>(std::min(ns, static_cast<double>(scenario_.run_duration.ns)))};
    }
    report_.run = fmt::format("{:.3g} of {:.3g} s, {} strategies, one thread", seconds(short_.run_duration),
                              seconds(scenario_.run_duration), plans_.size());
  }

  std::vector<Variant> run_variants() {
    std::vector<Variant> variants;
    const auto add_variant = [&](const std::string& part, const std::string& why) -> Variant& {
      add(part, true, why);
      return variants.emplace_back(Variant{report_.parts.size() - 1, short_, plans_, 1, {}, true});
    };
    for (std::size_t n = 0; n < plans_.size(); ++n) {
      const std::string part = fmt::format("strategy {}", name_of(plans_[n].kind));
      if (plans_.size() == 1) {
        add(part, true, "[run] strategies; the only one, so it is the run");
        continue;
      }
      std::vector<StrategyPlan>& others = add_variant(part, "[run] strategies").plans;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(n));
    }
    const auto asks_for_twins = [](const Expectation& one) { return compares_with_twin(one.metric); };
    std::vector<Expectation>& asked = short_.expectations;
    if (std::any_of(asked.begin(), asked.end(), asks_for_twins)) {
      Variant& variant = add_variant("ideal twins", "deviation_from_ideal: those that [run] strategies does not name");
      std::vector<Expectation>& kept = variant.scenario.expectations;
      kept.erase(std::remove_if(kept.begin(), kept.end(), asks_for_twins), kept.end());
    }
    if (short_.needs_undelayed && !costs_little(short_.scene))
      add_variant("undelayed solver", "an error against the undelayed force").scenario.needs_undelayed = false;
    if (short_.keep_rows) add_variant("events", "[run] keep = \"all\": events.bin").scenario.keep_rows = false;
    if (plans_.size() > 1) add_variant("threads", "--threads: CPU time that side by side costs; it saves time by the clock");
    return variants;
  }

  void run_variant(Variant& variant, const RunRecord& base, double base_s) {
    const bool is_threads = report_.parts[variant.part].part == "threads";
    RunOptions options = one_thread();
    if (is_threads) options.threads = 0;
    RunRecord record;
    const double variant_s = timed([&] { record = record_run(variant.scenario, variant.plans, options); });
    // For threads the variant is the run with the part, not without it.
    const double with_s = is_threads ? variant_s : base_s, without_s = is_threads ? base_s : variant_s;
    variant.percent.push_back(with_s > 0 ? 100 * (with_s - without_s) / with_s : 0);
    for (const StrategyRecord& strategy : record.strategies) {
      const auto same = std::find_if(base.strategies.begin(), base.strategies.end(),
                                     [&](const StrategyRecord& other) { return other.name == strategy.name; });
      variant.same_bits = variant.same_bits && same != base.strategies.end() && same->trace_hash == strategy.trace_hash;
    }
  }

  void put_variant(const Variant& variant) {
    PartCost& cost = report_.parts[variant.part];
    if (variant.percent.empty()) return;
    cost.of = "the run";
    cost.percent = measured(variant.percent);
    cost.bits = variant.same_bits ? PartCost::Bits::equal : PartCost::Bits::differ;
    cost.compared = fmt::format("trace hashes of {} strategies", variant.plans.size());
  }

  const Scenario& scenario_;
  const CostOptions& options_;
  std::vector<StrategyPlan> plans_;
  Scene scene_;  // as the live strategy's solver has it
  ToolPath path_;
  Scenario short_;
  CostReport report_;
};

}  // namespace

bool CostReport::same_bits() const {
  return std::none_of(parts.begin(), parts.end(), [](const PartCost& one) { return one.bits == PartCost::Bits::differ; });
}

CostReport measure_costs(const Scenario& scenario, const CostOptions& options) {
  return Measurement(scenario, options).report();
}

}  // namespace evenstep
