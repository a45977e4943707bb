#include "evenstep/campaigns/advise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>

#include "choices.h"
#include "evenstep/campaigns/stiffness_limit.h"
#include "evenstep/harness/rendering.h"
#include "evenstep/harness/run.h"
#include "evenstep/harness/run_folder.h"
#include "evenstep/pages/campaign_pages.h"
#include "evenstep/recordings/timing_csv.h"
#include "evenstep/scheduler/parallel_for.h"

namespace evenstep {
namespace {

namespace fs = std::filesystem;
using internal::AdviceLatency;
using internal::AdvicePace;
using internal::AdviceRenderer;
using internal::AdviceSetting;

/// An error of up to a period of the device is that of the sample before the hand stopped; a larger one was made up. In
/// periods.
constexpr double kSampled = 1.001;
/// A larger jump is a choice if it saves a twentieth of the latency.
constexpr std::int64_t kWorthPart = 20;
constexpr const char* kTimingFile = "timing.csv";
/// The hand of the run must come to rest at this share of the law's stiffness: with jitter the largest stable stiffness was
/// up to 5 % below the law (docs/forces/stiffness.md).
constexpr double kTriedShare = 0.8;
/// Where the search begins again if the hand shakes even with what the map carries without prediction.
constexpr double kLeastSearched_N_per_m = 1;
/// The last eighth of what is judged is compared with earlier ones, and a hand of 0.2 kg at 20 N/m swings once in 0.6 s.
constexpr Duration kShortestRest{5'000'000'000};
/// The line's hand goes at most this far, so that its force stays below 2000 N with the stiffest springs (8 kN/m).
constexpr double kMostWay_m = 0.15, kMostSpeed_m_per_s = 0.1;

/// A folder among the temporary files, in which the scenarios lie while they are read.
class Staging {
 public:
  Staging() : folder_((fs::temp_directory_path() / "evenstep-advise-XXXXXX").string()) {
    if (::mkdtemp(folder_.data()) == nullptr)
      throw std::runtime_error(
          fmt::format("{} cannot be written; set TMPDIR to a folder that can", fs::temp_directory_path().string()));
  }
  ~Staging() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  Staging(const Staging&) = delete;
  Staging& operator=(const Staging&) = delete;

  std::string write(const std::string& name, const std::string& text) const {
    const fs::path path = fs::path(folder_) / name;
    std::ofstream file(path, std::ios::binary);
    if (!(file << text).flush()) throw std::runtime_error(fmt::format("{} cannot be written", path.string()));
    return path.string();
  }
  Scenario read(const std::string& name, const std::string& text) const {
    ReadResult scenario = read_scenario(write(name, text));
    if (!scenario) throw std::logic_error("a scenario of advise is refused: " + evenstep::text(scenario.error().front()));
    return *std::move(scenario);
  }

 private:
  std::string folder_;
};

/// To three digits, so that what is written in a scenario is what it runs with.
double three_digits(double value) { return std::strtod(fmt::format("{:.2e}", value).c_str(), nullptr); }

const SizeStrategy* sized(const SizeRecord& record, StrategyKind kind) {
  for (const SizeStrategy& strategy : record.strategies) {
    if (strategy.name == name_of(kind)) return &strategy;
  }
  return nullptr;
}

std::optional<double> metric(const Metrics& metrics, const std::string& signal, const std::string& name) {
  const auto found = metrics.find(signal);
  if (found == metrics.end()) return std::nullopt;
  const auto value = found->second.find(name);
  return value == found->second.end() ? std::nullopt : std::optional(value->second);
}

/// The part that is not judged: the first second, or the first half of what is shorter than two seconds, as in `size`.
Duration warmup_of(Duration length) { return std::min(Duration{1'000'000'000}, Duration{length.ns / 2}); }

/// Computes the record for segments that were sized.
class Adviser {
 public:
  Adviser(AdviseResult& result, const std::vector<SegmentTiming>& segments, const AdviseOptions& options)
      : result_(result), segments_(segments), options_(options) {
    const AdviceRecord& record = result.record;
    setting_ = {.input = fs::path(record.input).filename().string(),
                .sampling = options.sampling,
                .speed_m_per_s = record.speed_m_per_s,
                .mass_kg = options.mass_kg,
                .damping_N_s_per_m = options.damping_N_s_per_m,
                .firmware_rate = options.firmware_rate};
  }

  void run() {
    list();
    size();
    AdviceRecord& record = result_.record;
    if (std::erase_if(plans_, [&](const Plan& plan) { return plan.pace.at_rate && !latency_of(plan); }) > 0)
      record.notes.push_back(fmt::format("{:.3g} % of {} segments is less than one: a latency for that rate is left out.",
                                         100 * options_.rate, record.segments));
    std::erase_if(plans_, [&](const Plan& plan) { return plan.pace.jump && !is_worth_its_jump(plan); });
    record.choices.resize(plans_.size());
    std::atomic<std::size_t> done{0};
    parallel_for(plans_.size(), options_.threads, [&](std::size_t i) {
      if (interrupted()) return;
      record.choices[i] = choice(plans_[i], static_cast<int>(i) + 1);
      if (options_.progress) options_.progress(static_cast<double>(++done) / static_cast<double>(plans_.size()));
    });
    result_.interrupted = interrupted();
    rank(record);
  }

 private:
  /// The timing of a choice, with what it costs compared with the given one.
  struct Timing {
    std::string file = kTimingFile;
    std::optional<FrameGovernor> governor;  ///< over the segments of the file
    std::string key;                        ///< which change it is
    Duration warmup;                        ///< not judged
    double drawings_lost = 0, simulated_lost = 0;
    Duration drawings_later;
  };
  struct Plan {
    AdvicePace pace;
    const AdviceRenderer* renderer;
    Timing timing;
  };
  /// What the sizing says of a pace.
  struct Sized {
    std::optional<Duration> bound;
    AdviceLatency least;                   ///< for which nothing is late
    std::optional<AdviceLatency> at_rate;  ///< empty also if the rate is less than one segment
    std::optional<SizeUnseen> unseen;
  };

  bool interrupted() const { return options_.interrupted && *options_.interrupted; }

  bool long_enough() const { return result_.record.length - result_.record.warmup >= kShortestRest; }

  void put_timing(const std::string& file, const std::vector<SegmentTiming>& segments) {
    staging_.write(file, result_.timings[file] = format_timing_csv(segments));
  }

  void list() {
    std::vector<std::string>& notes = result_.record.notes;
    const bool has_pauses = result_.record.segments_from != "step";
    if (!has_pauses)
      notes.push_back(
          "No pause stands out, so every step is a segment of its own: paper makes no sense for that, there is no pause to "
          "shorten, and both are left out.");
    if (!long_enough())
      notes.push_back(
          fmt::format("After {:.3g} s nobody can tell whether the hand comes to rest: the stiffness is that of the "
                      "law, and was not tried; predict has no law and is left out. Record {:.3g} s or more.",
                      seconds(result_.record.length), seconds(result_.record.warmup + kShortestRest)));
    put_timing(kTimingFile, segments_);
    const bool has_own_clock = has_clock(segments_);
    std::vector<WhatIf> governors;
    if (has_pauses) governors = options_.governors.value_or(internal::default_governors(segments_));
    for (const AdvicePace& pace : internal::paces(has_pauses, has_own_clock, options_, governors)) {
      // No law says how stiff a spring this map carries, so a run with a hand has to find it.
      if (pace.map == StrategyKind::predict && !long_enough()) continue;
      const std::optional<Timing> timing = timing_of(pace);
      if (!timing) continue;
      for (const AdviceRenderer* renderer : internal::renderers_of(pace, options_.renderers))
        plans_.push_back({pace, renderer, *timing});
    }
  }

  /// Empty, with a note, if the change has no meaning for these segments.
  std::optional<Timing> timing_of(const AdvicePace& pace) {
    if (!pace.governor) return Timing{.warmup = result_.record.warmup};
    const Result<WhatIfTiming> changed = apply(causal(*pace.governor).value_or(*pace.governor), segments_, true);
    if (!changed) {
      result_.record.notes.push_back(fmt::format("{} is left out: {}.", text_of(*pace.governor), changed.error()));
      return std::nullopt;
    }
    const DrawingPrice before = price_of(segments_, segments_);
    Timing timing{.governor = changed->governor,
                  .key = text_of(*pace.governor),
                  .warmup = warmup_of(changed->segments.back().end - changed->segments.front().begin),
                  .simulated_lost = changed->price.segments_lost,
                  .drawings_later = changed->price.drawings_later};
    if (before.drawings_per_s > 0)
      timing.drawings_lost = std::max(0.0, 1 - changed->price.drawings_per_s / before.drawings_per_s);
    if (timing.governor) return timing;
    timing.file = fmt::format("timing-{}.csv", result_.timings.size());
    put_timing(timing.file, changed->segments);
    return timing;
  }

  /// Renderers that play forces alike are sized once.
  static std::string size_key(const Plan& plan) {
    return fmt::format("{}|{}|{}|{}|{}", name_of(plan.pace.map), plan.pace.bandwidth, plan.pace.jump.value_or(0),
                       plan.timing.key, std::string(plan.renderer->name) == "hold");
  }

  void size() {
    std::vector<std::pair<std::string, const Plan*>> wanted;
    for (const Plan& plan : plans_) {
      if (is_remap(plan.pace.map) && sizes_.try_emplace(size_key(plan)).second) wanted.emplace_back(size_key(plan), &plan);
    }
    parallel_for(wanted.size(), options_.threads, [&](std::size_t i) {
      if (!interrupted()) sizes_.at(wanted[i].first) = sized_pace(*wanted[i].second, i);
    });
  }

  Sized sized_pace(const Plan& plan, std::size_t number) const {
    const Scenario scenario = staging_.read(fmt::format("size-{}.toml", number), text(plan, {.name = "sizing"}));
    SizeOptions options;
    options.rate = options_.rate;
    const SizeRecord record = size_scenario(scenario, options).record;
    const SizeStrategy* strategy = sized(record, plan.pace.map);
    Sized out;
    if (strategy == nullptr) return out;
    out.least = {.latency = strategy->any_phase.latency, .lead = strategy->lead, .adaptive = true};
    if (strategy->path) out.bound = strategy->path->latency;
    if (!strategy->unseen.empty()) out.unseen = strategy->all_unseen();
    if (!strategy->rate || strategy->rate->allowed == 0) return out;
    const SizeRateNeed& need = strategy->rate->any_phase;
    out.at_rate = AdviceLatency{need.latency, need.lead,
                                static_cast<double>(need.underruns) / static_cast<double>(strategy->rate->segments)};
    return out;
  }

  bool is_worth_its_jump(const Plan& rougher) const {
    Plan plan = rougher;
    plan.pace.jump.reset();
    const Duration saved = sizes_.at(size_key(plan)).least.latency - sizes_.at(size_key(rougher)).least.latency;
    return saved * kWorthPart > sizes_.at(size_key(plan)).least.latency;
  }

  std::optional<AdviceLatency> latency_of(const Plan& plan) const {
    if (plan.pace.adaptive) return sizes_.at(size_key(plan)).least;
    return plan.pace.at_rate ? sizes_.at(size_key(plan)).at_rate : std::nullopt;
  }

  std::string text(const Plan& plan, internal::AdviceScenario own, bool stops = false) const {
    own.trace = plan.timing.file;
    own.governor = plan.timing.governor;
    own.warmup = plan.timing.warmup;
    return internal::scenario_text(setting_, plan.pace, *plan.renderer, own, stops);
  }

  AdviceChoice named(const Plan& plan, int number) const {
    AdviceChoice out;
    out.number = number;
    out.map = name_of(plan.pace.map);
    if (!plan.pace.bandwidth.empty()) out.bandwidth_Hz = parse_si(plan.pace.bandwidth, Dimension::rate).value();
    if (plan.pace.governor) out.governor = text_of(*plan.pace.governor);
    out.allowed_jump = plan.pace.jump.value_or(0);
    out.accepted_rate = plan.pace.at_rate ? options_.rate : 0;
    out.adaptive = plan.pace.adaptive;
    out.searched = plan.pace.map == StrategyKind::predict;
    out.renderer = plan.renderer->name;
    out.needs_stiffness = plan.renderer->needs_stiffness;
    out.needs_springs = plan.renderer->needs_springs;
    out.drawings_lost = plan.timing.drawings_lost;
    out.simulated_lost = plan.timing.simulated_lost;
    out.drawings_later = plan.timing.drawings_later;
    return out;
  }

  AdviceChoice choice(const Plan& plan, int number) const {
    AdviceChoice out = named(plan, number);
    const std::string file = choice_file(out);
    internal::AdviceScenario own{.name = name_of(out), .latency = latency_of(plan)};
    if (own.latency) out.late_any_phase = own.latency->late;
    // The law does not depend on the scene's stiffness, which is chosen by it.
    const Scenario first = staging_.read(file, text(plan, own));
    const LoopRecord loop = loop_record(first, evenstep::plan(first).front(), first.devices.back());
    out.stiffness_N_per_m = loop.stiffness_limit_N_per_m.value();
    if (out.searched) search(file, plan, own, out);
    out.scenario = text(plan, own);
    if (!out.failure.empty()) return out;
    out.tried_N_per_m = own.stiffness_N_per_m = three_digits(kTriedShare * out.stiffness_N_per_m);
    out.scenario = text(plan, own);
    run(staging_.read(file, out.scenario), out);
    if (is_remap(plan.pace.map) && !plan.pace.at_rate && !plan.pace.adaptive) {
      const Sized& sized = sizes_.at(size_key(plan));
      out.bound = sized.bound;
      out.unseen = sized.unseen;
    }
    if (traits_of(plan.pace.map).predicts && out.failure.empty()) stop(plan, own, out);
    if (out.failure.empty()) out.scenario += internal::expectations_text(out);
    return out;
  }

  /// The stiffness that `predict` carries: at most that of the law for its delay, which does not know that the map also runs
  /// on. On a long recording each run of the search takes seconds, so the search begins with what the map carries without
  /// prediction, or with half of its upper end if that is less.
  void search(const std::string& file, const Plan& plan, internal::AdviceScenario& own, AdviceChoice& out) const {
    own.search_to_N_per_m = three_digits(out.stiffness_N_per_m);
    own.search_from_N_per_m = three_digits(std::min(without_prediction_N_per_m(file, plan, own), out.stiffness_N_per_m / 2));
    StiffnessLimits found = searched(file, plan, own);
    if (!found.limits.empty() && found.limits.front().state == StiffnessLimit::State::below) {
      own.search_from_N_per_m = three_digits(std::min(kLeastSearched_N_per_m, own.search_from_N_per_m / 2));
      found = searched(file, plan, own);
    }
    if (found.limits.empty()) return;  // interrupted
    const StiffnessLimit& limit = found.limits.front();
    out.stiffness_N_per_m = limit.stable_N_per_m;
    if (limit.state == StiffnessLimit::State::below)
      out.failure = fmt::format("its hand shakes with {:.3g} N/m already", found.from_N_per_m);
  }

  /// The law for the least latency of the same map without prediction.
  double without_prediction_N_per_m(const std::string& file, const Plan& predicted, internal::AdviceScenario own) const {
    Plan plan = predicted;
    plan.pace.map = StrategyKind::phase_locked;
    const AdviceLatency& least = sizes_.at(size_key(plan)).least;
    own.latency = AdviceLatency{.latency = least.latency, .lead = least.lead};
    own.search_to_N_per_m = std::nullopt;
    const Scenario scenario = staging_.read(file, text(plan, own));
    return loop_record(scenario, evenstep::plan(scenario).front(), scenario.devices.back()).stiffness_limit_N_per_m.value();
  }

  StiffnessLimits searched(const std::string& file, const Plan& plan, const internal::AdviceScenario& own) const {
    StudyControl control;
    control.interrupted = options_.interrupted;
    Scenario scenario = staging_.read(file, text(plan, own));
    // The line's hand feels a spring of its own, so the hand that is searched for does not notice that the line is away.
    std::erase_if(scenario.devices, [](const DeviceSpec& device) { return !device.hand; });
    return run_stiffness_limits(scenario, control);
  }

  /// How far a map that predicts the hand runs on where the hand stops. All other maps give the solver where the hand was.
  void stop(const Plan& plan, const internal::AdviceScenario& own, AdviceChoice& out) const {
    out.stops_scenario = text(plan, own, true);
    const RunOutcome outcome = ran(staging_.read(stops_file(out), out.stops_scenario), out);
    if (!out.failure.empty()) return;
    out.stop_error_m = value(outcome, "stops", "interaction", "error_max", out);
    const double stop_s = out.stop_error_m / internal::stops_speed(result_.record.speed_m_per_s);
    out.runs_on_s = stop_s > kSampled * seconds(result_.record.sampling_period) ? stop_s : 0;
    out.stops_scenario += internal::stops_expectations_text(out);
  }

  RunOutcome ran(const Scenario& scenario, AdviceChoice& out) const {
    RunOptions options;
    options.threads = 1;
    options.allow_no_expectations = true;
    options.control.interrupted = options_.interrupted;
    RunOutcome outcome = run_scenario(scenario, options);
    out.failure = outcome.failure;
    return outcome;
  }

  static double value(const RunOutcome& outcome, const char* device, const char* kind, const char* name, AdviceChoice& out) {
    const std::optional<double> found = metric(outcome.metrics, fmt::format("{}.{}.{}", device, kind, out.map), name);
    if (!found && out.failure.empty()) out.failure = fmt::format("its run judged no {} of {}.{}", name, device, kind);
    return found.value_or(0);
  }

  void run(const Scenario& scenario, AdviceChoice& out) const {
    const RunOutcome outcome = ran(scenario, out);
    if (!out.failure.empty()) return;
    const auto of = [&](const char* device, const char* kind, const char* name) {
      return value(outcome, device, kind, name, out);
    };
    const Nominal nominal = nominal_of(scenario);
    const auto in_steps = [&](const char* kind) {
      return of("line", kind, "velocity_jump") / step_unit(nominal, fmt::format("line.{}.{}", kind, out.map)).value();
    };
    out.jump_step = in_steps("interaction");
    out.force_jump_step = in_steps("force");
    out.underrun_rate = of("line", "buffers", "underrun_rate");
    out.delay_s = of("closed_loop", "hand", "loop_delay");
    if (scenario.run_duration - scenario.warmup >= kShortestRest)
      out.comes_to_rest = of("closed_loop", "hand", "stable") > 0;
    out.latency = outcome.record.strategies.front().latency.latency;
    out.lead = outcome.record.strategies.front().latency.lead;
    if (!out.adaptive) return;
    out.latency_most = out.latency;
    out.latency = Duration{std::llround(1e9 * of("line", "force", "schedule_latency_mean"))};
    out.delay_s -= seconds(*out.latency_most) - seconds(out.latency);
  }

  AdviseResult& result_;
  const std::vector<SegmentTiming>& segments_;
  const AdviseOptions& options_;
  Staging staging_;
  AdviceSetting setting_;
  std::vector<Plan> plans_;
  std::map<std::string, Sized> sizes_;
};

/// Rounded down to one digit, and so slow that the line's springs are not stretched too far.
double speed_for(Duration length) {
  const double most = std::min(kMostWay_m / seconds(length), kMostSpeed_m_per_s);
  const double decade = std::pow(10, std::floor(std::log10(most) + 1e-9));
  return std::strtod(fmt::format("{:.0e}", std::floor(most / decade + 1e-9) * decade).c_str(), nullptr);
}

AdviseResult advised(SizeResult sized, const AdviseOptions& options) {
  AdviseResult result;
  const SizeRecord& size = sized.record;
  const auto refuse = [&](std::string message) {
    result.errors = {{size.input, 0, 0, std::move(message)}};
    return std::move(result);
  };
  if (size.steps > kMostAdviceSteps)
    return refuse(fmt::format("{} steps are more than the {} of which every choice can be run; give a part of them",
                              size.steps, kMostAdviceSteps));
  if (strategy_to_use(size) == nullptr || size.segments < 3)
    return refuse(
        fmt::format("{} steps in {} segments are too short to advise: a map has slots once it has seen a whole "
                    "segment, and its jumps are judged after that; record more",
                    size.steps, size.segments));
  AdviceRecord& record = result.record;
  record.input = size.input;
  record.segments_from = size.segments_from;
  record.steps = size.steps;
  record.segments = size.segments;
  record.length = size.length;
  record.slot = {size.length.ns / size.steps};
  record.warmup = warmup_of(size.length);
  record.sampling_period = size.sampling_period;
  record.pause_bound = size.held.pause;
  record.pause = size.pause;
  record.damping_N_s_per_m = options.damping_N_s_per_m;
  record.mass_kg = options.mass_kg;
  record.firmware_rate_Hz = static_cast<double>(options.firmware_rate.num) / static_cast<double>(options.firmware_rate.den);
  record.speed_m_per_s = speed_for(size.length);
  Adviser(result, sized.segments, options).run();
  return result;
}

}  // namespace

AdviseResult advise_recording(const std::string& path, const AdviseOptions& options, const RecordingOptions& recording) {
  SizeOptions size;
  size.sampling = options.sampling;
  size.step_size = options.step_size;
  SizeResult sized = size_recording(path, size, recording);
  if (!sized.errors.empty()) return {{}, {}, std::move(sized.errors), false};
  std::string damage = std::move(sized.damage);
  AdviseResult result = advised(std::move(sized), options);
  result.damage = std::move(damage);
  return result;
}

namespace {

/// The devices of the choices have no ages, so those of the scenario's own devices are not in the numbers.
std::string ages_left_out(const Scenario& scenario) {
  std::string devices;
  for (const DeviceSpec& device : scenario.devices) {
    const Duration age = largest_age(device);
    if (age.ns > 0)
      devices += fmt::format("{}{} (up to {:.3g} ms)", devices.empty() ? "" : ", ", device.name, seconds(age) * 1e3);
  }
  if (devices.empty()) return {};
  return fmt::format(
      "How old samples are is left out, those of {}: every latency needs about so much more, and `size` says how much.",
      devices);
}

}  // namespace

AdviseResult advise_scenario(const Scenario& scenario, const AdviseOptions& options) {
  if (scenario.timing.elsewhere)
    return {{},
            {},
            {{scenario.file, 0, 0,
              "the forces of a [source] are late by their way as well, which no choice here knows; `size` counts it"}},
            false};
  SizeResult sized = size_scenario(scenario, {});
  if (!sized.errors.empty()) return {{}, {}, std::move(sized.errors), false};
  AdviseOptions of_scenario = options;
  const auto slower = [](const DeviceSpec& a, const DeviceSpec& b) { return period_ceil(a.rate) > period_ceil(b.rate); };
  of_scenario.sampling = std::min_element(scenario.devices.begin(), scenario.devices.end(), slower)->rate;
  AdviseResult result = advised(std::move(sized), of_scenario);
  if (std::string note = ages_left_out(scenario); !note.empty() && result.errors.empty())
    result.record.notes.push_back(std::move(note));
  return result;
}

std::string choice_file(const AdviceChoice& choice) { return fmt::format("choice-{}.toml", choice.number); }

std::string stops_file(const AdviceChoice& choice) { return fmt::format("choice-{}-stops.toml", choice.number); }

std::string write_advice_folder(const std::string& folder, const AdviseResult& result, const std::string& reproduce) {
  const AdviceRecord& record = result.record;
  std::vector<FolderFile> files{
      {kAdviceFile, advice_json(record)}, {kReportFile, advice_page(record, reproduce)}, {"advice.svg", advice_svg(record)}};
  for (const auto& [name, text] : result.timings) files.emplace_back(name, text);
  for (const AdviceChoice& choice : record.choices) {
    files.emplace_back(choice_file(choice), choice.scenario);
    if (!choice.stops_scenario.empty()) files.emplace_back(stops_file(choice), choice.stops_scenario);
  }
  return write_folder(folder, files);
}

}  // namespace evenstep
