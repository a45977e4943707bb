// [study]
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>

#include "evenstep/text/rational.h"
#include "src/field_rows.h"
#include "src/sections.h"

namespace evenstep::internal {
namespace {

constexpr Duration kStateDuration{64'000'000};
constexpr std::array kFeltMethods{Method::symplectic_euler, Method::rk4, Method::implicit_euler};

/// The names of a list, each once, in the file's order.
std::vector<std::string> names_of(const Table& study, std::string_view key, Errors& errors) {
  std::vector<std::string> names;
  for (const Value& name : study.at(key).list) {
    if (std::find(names.begin(), names.end(), name.text) != names.end())
      errors.add(name.place, fmt::format("'{}' names \"{}\" twice", key, name.text));
    names.push_back(name.text);
  }
  if (names.empty()) errors.add(study.place(key), fmt::format("'{}' is empty; name at least one", key));
  return names;
}

Rate step_rate_of(const std::string& text) {
  const Result<Rate> rate = parse_rate(text);
  return rate ? *rate : reduced_rate(1'000'000'000, parse_duration(text)->ns);
}

/// How many steps of the scene fit into the duration of the study.
std::int64_t steps_within(Duration duration, Rate rate) {
  return floor_mul_div(duration.ns, rate.num, rate.den * 1'000'000'000);
}

StudyStep read_step(const Value& value, const Scenario& scenario, Errors& errors) {
  const Rate scene = scenario.scene.step_rate, wanted = step_rate_of(value.text);
  const __int128 finer = static_cast<__int128>(wanted.num) * scene.den,
                 coarser = static_cast<__int128>(scene.num) * wanted.den;
  const std::int64_t most_steps = steps_within(scenario.study.duration, scene);
  if (finer % coarser == 0 && finer / coarser <= kMaxSubsteps) return {static_cast<int>(finer / coarser), 1};
  if (coarser % finer == 0 && coarser / finer <= most_steps) return {1, static_cast<int>(coarser / finer)};
  const std::string step = fmt::format("{:.6g} ms", 1e3 * period_s(scene));
  if (coarser % finer == 0)
    errors.add(
        value.place,
        fmt::format("'step_sizes': \"{}\" is longer than the study; write a shorter one, or a longer duration", value.text));
  else if (finer % coarser == 0)
    errors.add(value.place, fmt::format("'step_sizes': \"{}\" cuts the scene's step of {} into more than {}", value.text,
                                        step, kMaxSubsteps));
  else
    errors.add(
        value.place,
        fmt::format("'step_sizes': \"{}\" is no whole part of the scene's step of {} and no multiple of it; write one, or "
                    "another [scene] step_size",
                    value.text, step));
  return {};
}

void read_steps(const Table& study, Scenario& scenario, Errors& errors) {
  if (!study.has("step_sizes")) return;
  const Value sizes = study.at("step_sizes");
  const std::size_t before = errors.count();
  std::int64_t together = 1;
  for (const Value& value : sizes.list) {
    const StudyStep step = read_step(value, scenario, errors);
    together = std::min<std::int64_t>(std::lcm(together, std::int64_t{step.steps}), INT32_MAX);
    for (const StudyStep& other : scenario.study.steps) {
      if (other.steps == step.steps && other.substeps == step.substeps && errors.count() == before)
        errors.add(value.place, fmt::format("'step_sizes': \"{}\" is there already", value.text));
    }
    scenario.study.steps.push_back(step);
  }
  if (sizes.list.empty()) errors.add(sizes.place, "'step_sizes' is empty; name at least one, or leave it out");
  if (errors.count() == before && together > steps_within(scenario.study.duration, scenario.scene.step_rate))
    errors.add(sizes.place,
               "'step_sizes': these steps never end at the same instant within the duration; write multiples of each other");
  std::stable_sort(scenario.study.steps.begin(), scenario.study.steps.end(), [](const StudyStep& a, const StudyStep& b) {
    return std::int64_t{a.steps} * b.substeps > std::int64_t{b.steps} * a.substeps;
  });
}

void read_stiffness_limit(const Table& study, Scenario& scenario, Errors& errors) {
  const Table search = study.table("stiffness_limit");
  scenario.study.stiffness_limit = {search.si("from"), search.si("to"), static_cast<int>(search.integer("seeds"))};
  scenario.study.stiffness_limit->scales_mass = search.text("mass") == "in-proportion";
  if (search.has("mass") && !std::holds_alternative<TissueScene>(scenario.scene.body))
    errors.add(search.place("mass"), "'mass' is that of a tissue's particles, and this scene has none; remove it");
  if (scenario.study.stiffness_limit->from_N_per_m >= scenario.study.stiffness_limit->to_N_per_m)
    errors.add(search.place("to"), "'stiffness_limit': 'to' is not above 'from'; exchange them, or look further");
  if (!has_stiffness(scenario.scene))
    errors.add(study.place("stiffness_limit"),
               "'stiffness_limit' changes [scene] stiffness, and a scene of this kind has none");
  if (!has_hand(scenario))
    errors.add(
        study.place("stiffness_limit"),
        "'stiffness_limit' needs a hand that feels the force: a programmed motion is stable at any stiffness; write "
        "motion = { kind = \"hand\", mass = \"0.2 kg\", damping = \"1 N s/m\", offset = [\"5 mm\", \"0 mm\", \"0 mm\"] }");
  for (const char* key : {"error", "methods", "solvers", "step_sizes", "iterations", "repeats", "duration"}) {
    if (study.has(key))
      errors.add(study.place(key), fmt::format("'{}' does not go with 'stiffness_limit', which runs the scenario as it is; "
                                               "remove one of them",
                                               key));
  }
}

/// The duration, and what is wrong with it.
void read_duration(const Table& study, Scenario& scenario, Errors& errors) {
  StudySpec& spec = scenario.study;
  const bool felt = spec.error == StudyError::felt_force;
  const Duration judged = std::max(scenario.run_duration - scenario.warmup, Duration{});
  spec.duration = felt ? judged : kStateDuration;
  if (!study.has("duration")) return;
  spec.duration = study.span("duration", scenario.nominal, errors);
  if (felt && spec.duration > judged) {
    errors.add(study.place("duration"),
               fmt::format("'duration': {} is more than the {} that the run judges; leave it out, or write a longer [run] "
                           "duration",
                           in_ms(spec.duration), in_ms(judged)));
  }
}

/// What does not go with the error of the felt force.
void refuse_for_felt_force(const Table& study, const Scenario& scenario, Errors& errors) {
  if (!std::holds_alternative<TissueScene>(scenario.scene.body)) {
    const bool is_foreign = std::holds_alternative<ForeignScene>(scenario.scene.body);
    for (const char* key : {"methods", "solvers", "step_sizes", "iterations"}) {
      if (study.has(key) && !(is_foreign && key == std::string_view("step_sizes")))
        errors.add(study.place(key), fmt::format("'{}' is that of a tissue, and this scene has no {} to choose; remove it",
                                                 key, is_foreign ? "such thing" : "step"));
    }
  }
  if (!study.has("step_sizes")) return;
  for (std::size_t i = 0; i < scenario.study.steps.size(); ++i) {
    if (scenario.study.steps[i].steps == 1) continue;
    errors.add(study.place("step_sizes"),
               "'step_sizes': a step that is longer than the scene's does not fit the [timing], which says when each step "
               "runs; write whole parts of the scene's step, or error = \"state\"");
    return;
  }
}

}  // namespace

void read_study(ScenarioReading& reading) {
  if (!reading.sound("study") || !reading.sound("scene") || !reading.sound("device") || !reading.scenario.nominal.known)
    return;
  const Table study = reading.section("study");
  Scenario& scenario = reading.scenario;
  StudySpec& spec = scenario.study;
  spec.error = study.text("error") == "state" ? StudyError::state : StudyError::felt_force;
  read_duration(study, scenario, reading.errors);
  if (study.has("methods")) {
    for (const std::string& name : names_of(study, "methods", reading.errors))
      spec.methods.push_back(
          *std::find_if(kAllMethods.begin(), kAllMethods.end(), [&](Method m) { return name == name_of(m); }));
  } else if (spec.error == StudyError::state) {
    spec.methods.assign(kAllMethods.begin(), kAllMethods.end());
  } else {
    spec.methods.assign(kFeltMethods.begin(), kFeltMethods.end());
  }
  for (const std::string& name : names_of(study, "solvers", reading.errors))
    spec.solvers.push_back(
        *std::find_if(kAllSolvers.begin(), kAllSolvers.end(), [&](SolverKind s) { return name == name_of(s); }));
  spec.repeats = static_cast<int>(study.integer("repeats"));
  if (study.has("iterations")) {
    for (const Value& count : study.at("iterations").list) spec.iterations.push_back(static_cast<int>(count.integer));
  }
  const Value* written = reading.document.find("study");
  if (written == nullptr) return;
  if (study.has("stiffness_limit")) return read_stiffness_limit(study, scenario, reading.errors);
  if (spec.error == StudyError::state && !std::holds_alternative<TissueScene>(scenario.scene.body)) {
    reading.errors.add(study.place("error"),
                       "error = \"state\" compares the steps of a tissue, and this scene has none; write error = "
                       "\"felt-force\" or kind = \"tissue\"");
  } else if (study.has("duration") && steps_within(spec.duration, scenario.scene.step_rate) < 1) {
    reading.errors.add(study.place("duration"), fmt::format("'duration': {} is less than one step of the scene, {:.6g} ms",
                                                            in_ms(spec.duration), 1e3 * period_s(scenario.scene.step_rate)));
  } else {
    read_steps(study, scenario, reading.errors);
  }
  if (spec.error == StudyError::felt_force) refuse_for_felt_force(study, scenario, reading.errors);
}

// A key is a few full lines.
// clang-format off
const std::vector<Field>& study_fields() {
  static const std::vector<Field> rows{
      {.table = "study", .key = "error", .forms = kWord, .default_toml = "\"felt-force\"",
       .meaning =
           "`felt-force`: of the force that the hand feels, with every strategy, in the timing of the run and over what it "
           "judges. `state`: of positions, forces and energy of a tissue, on even steps without strategies and devices.",
       .words = "felt-force|state"},
      {.table = "study", .key = "duration", .forms = kSpan,
       .meaning = "Simulated time that is judged. `felt-force`: from the end of the warm-up on, by default all that the run "
                  "judges. "
                  "`state`: from the begin of the first motion on, by default 64 ms.",
       .range = above(0, kLongestRun_s), .example = "\"0.2 s\""},
      {.table = "study", .key = "methods", .forms = kWord, .shape = Shape::list,
       .meaning = "Methods to compare, as in [scene] `method`. Default: `felt-force` symplectic-euler, rk4 and "
                  "implicit-euler, `state` "
                  "all of them.",
       .words = method_words(), .example = "[\"symplectic-euler\", \"rk4\"]"},
      {.table = "study", .key = "solvers", .forms = kWord, .shape = Shape::list, .default_toml = "[\"cpu\"]",
       .meaning = "Solvers to compare, as in [scene] `solver`.",
       .words = "opencl|cpu|cpu-double"},
      {.table = "study", .key = "step_sizes", .forms = kDuration | kRate, .shape = Shape::list,
       .meaning =
           "Of the methods: whole parts of the scene's step, or (`state` only) multiples of it. Default of `felt-force`: "
           "for "
           "each method the step of substeps = \"auto\", its half and its quarter. Default of `state`: halvings of the "
           "scene's; "
           "for explicit methods from the first one above the limit to the fourth below it, for implicit ones down to an "
           "eighth.",
       .range = above(0), .example = "[\"1 ms\", \"0.5 ms\"]"},
      {.table = "study", .key = "iterations", .forms = kInteger, .shape = Shape::list,
       .meaning =
           "Numbers of iterations; every method that iterates is run with each of them. Default: each method's own number.",
       .range = between(1, kMostIterations), .example = "[5, 20]"},
      {.table = "study", .key = "repeats", .forms = kInteger, .default_toml = "5",
       .meaning = "Times that each cost is measured: least, median and greatest are reported.",
       .range = between(1, 1000)},
      {.table = "study", .key = "stiffness_limit", .forms = kTable,
       .meaning =
           "Look for the largest [scene] `stiffness` at which every strategy is stable in a `hand`, and for nothing else."},
      {.table = "study.stiffness_limit", .key = "from", .forms = kQuantity,
       .meaning = "Where the search begins; the loop should be stable there.",
       .required = true, .dimension = D::stiffness, .range = above(0), .example = "\"20 N/m\""},
      {.table = "study.stiffness_limit", .key = "to", .forms = kQuantity,
       .meaning = "Where it gives up.",
       .required = true, .dimension = D::stiffness, .range = above(0), .example = "\"30000 N/m\""},
      {.table = "study.stiffness_limit", .key = "seeds", .forms = kInteger, .default_toml = "1",
       .meaning =
           "Number of seeds, from [run] `seed` on; a stiffness counts as stable if it is stable with every one of them.",
       .range = between(1, 1000)},
      {.table = "study.stiffness_limit", .key = "mass", .forms = kWord, .default_toml = "\"kept\"",
       .meaning = "For a tissue, whose regions and tools become stiffer in proportion. `kept`: masses stay, so a stiffer "
                  "tissue swings faster. `in-proportion`: masses and axial damping grow too, so that its frequencies stay, "
                  "as those of a `mode` do.",
       .words = "kept|in-proportion"},
  };
  return rows;
}
// clang-format on

}  // namespace evenstep::internal
