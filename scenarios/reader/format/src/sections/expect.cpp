// [[expect]] and [expect_stop]
#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

#include <algorithm>

#include "evenstep/text/suggest.h"
#include "evenstep/text/units.h"
#include "src/field_rows.h"
#include "src/sections.h"

namespace evenstep::internal {
namespace {

/// The names that signals may contain. They are read leniently, so that a mistake in [[device]] does not make every signal
/// unknown.
struct Names {
  std::vector<std::string_view> devices, strategies;
  std::vector<std::string_view> methods, solvers;  ///< for a case
  bool certain = true;  ///< there were no errors, so a name that is not listed here does not exist
};

Names collect_names(const ScenarioReading& reading) {
  Names names;
  names.certain = reading.sound("run") && reading.sound("device");
  if (const Value* devices = reading.document.find("device")) {
    for (const Value& device : devices->list) {
      const Value* name = device.find("name");
      if (name != nullptr && name->is(Value::Kind::text)) names.devices.push_back(name->text);
    }
  }
  for (const StrategyKind kind : reading.scenario.strategies) names.strategies.push_back(name_of(kind));
  if (!reading.scenario.case_spec) return names;
  for (const Method method : reading.scenario.case_spec->methods) names.methods.push_back(name_of(method));
  if (reading.scenario.case_spec->foreign) {
    names.solvers = {reading.scenario.case_spec->foreign->name};
    return names;
  }
  for (const SolverKind solver : reading.scenario.case_spec->solvers) names.solvers.push_back(name_of(solver));
  return names;
}

std::vector<std::string_view> split_signal(std::string_view signal) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t dot = signal.find('.');
    parts.push_back(signal.substr(0, dot));
    if (dot == std::string_view::npos) return parts;
    signal.remove_prefix(dot + 1);
  }
}

std::string unknown_part(std::string_view what, std::string_view part, const std::vector<std::string_view>& known) {
  if (part == "*" || std::find(known.begin(), known.end(), part) != known.end()) return {};
  return fmt::format("there is no {} '{}'; this scenario has: {}", what, part, fmt::join(known, ", "));
}

std::string case_signal_error(std::string_view signal, const Names& names) {
  const std::vector<std::string_view> parts = split_signal(signal);
  if (parts.size() != 3 || parts[0] != "case")
    return fmt::format("'{}' is not a signal of a case; write case.<method>.<solver>", signal);
  const std::string error = unknown_part("method", parts[1], names.methods);
  return error.empty() ? unknown_part("solver", parts[2], names.solvers) : error;
}

/// What is wrong with a signal; empty if its form is right and everything that it names exists.
std::string signal_error(std::string_view signal, const Names& names) {
  const std::vector<std::string_view> parts = split_signal(signal);
  static const std::vector<std::string_view> kDeviceSignals{"interaction", "force", "buffers"};
  const bool empty_part = std::any_of(parts.begin(), parts.end(), [](std::string_view part) { return part.empty(); });
  std::string error;
  if (!empty_part && parts.size() == 1 && parts[0] == "run") return {};
  if (!empty_part && parts.size() == 2 && (parts[0] == "solver" || parts[0] == "*")) {
    error = unknown_part("strategy", parts[1], names.strategies);
  } else if (!empty_part && parts.size() == 3 && parts[0] == "events") {
    return {};
  } else if (!empty_part && parts.size() == 3 && parts[0] == "closed_loop") {
    error = unknown_part("device", parts[1], names.devices);
    if (error.empty()) error = unknown_part("strategy", parts[2], names.strategies);
  } else if (!empty_part && parts.size() == 3) {
    if (parts[1] != "*" && std::find(kDeviceSignals.begin(), kDeviceSignals.end(), parts[1]) == kDeviceSignals.end()) {
      return fmt::format("'{}' is not a signal of a device{}", parts[1], suggestion(parts[1], kDeviceSignals));
    }
    error = unknown_part("device", parts[0], names.devices);
    if (error.empty()) error = unknown_part("strategy", parts[2], names.strategies);
  } else {
    return fmt::format(
        "'{}' is not a signal; write <device>.interaction.<strategy>, <device>.force.<strategy>, "
        "<device>.buffers.<strategy>, closed_loop.<device>.<strategy>, "
        "solver.<strategy>, events.<lane>.<name> or run",
        signal);
  }
  return names.certain ? error : "";
}

Limit read_limit(const Table& expect, std::string_view key) {
  const Value value = expect.at(key);
  if (value.is(Value::Kind::text)) return *parse_limit(value.text);
  return {expect.number(key), ""};
}

/// Whether min > max, as far as the units tell without a nominal speed.
bool contradict(const Limit& min, const Limit& max, const NominalUnits& nominal) {
  if (min.unit == max.unit) return min.number > max.number;
  const Unit* min_unit = find_unit(min.unit);
  const Unit* max_unit = find_unit(max.unit);
  if (min_unit == nullptr || max_unit == nullptr || min_unit->dimension != max_unit->dimension) return false;
  const std::string_view base = info(min_unit->dimension).base;
  const Result<double> least = in_base(min, base, 0, nominal), most = in_base(max, base, 0, nominal);
  return least && most && *least > *most;
}

void read_limits(const Table& expect, Expectation& expectation, const NominalUnits& nominal, Errors& errors) {
  const bool bounded = expect.has("min") || expect.has("max");
  if (expect.has("equals")) {
    if (bounded) errors.add(expect.place("equals"), "'equals' is min and max in one; remove the other");
    expectation.min = expectation.max = read_limit(expect, "equals");
    expectation.written.min = expectation.written.max = expect.place("equals");
    return;
  }
  if (!bounded) errors.add(expectation.place, fmt::format("[[{}]] has no limit; write min, max or equals", expect.name()));
  if (expect.has("min")) expectation.min = read_limit(expect, "min");
  if (expect.has("max")) expectation.max = read_limit(expect, "max");
  expectation.written.min = expect.place("min");
  expectation.written.max = expect.place("max");
  if (expectation.min && expectation.max && contradict(*expectation.min, *expectation.max, nominal)) {
    errors.add(expect.place("min"),
               fmt::format("'min': {} {} is above max, {} {}; nothing can hold", expectation.min->number,
                           expectation.min->unit, expectation.max->number, expectation.max->unit));
  }
}

void read_range(const Table& expect, bool of_case, Expectation& expectation, Errors& errors) {
  const auto number = [](const Value& value) {
    return value.is(Value::Kind::integer) ? static_cast<double>(value.integer) : value.number;
  };
  const Value at = expect.at("at");
  if (!of_case) return errors.add(at.place, "'at' picks cells of a [case], and there is none; remove it");
  if (at.list.size() != 2 || number(at.list[0]) > number(at.list[1]))
    return errors.add(at.place, "'at' must be the least and the greatest value, such as [0.1, 1]");
  expectation.at = {number(at.list[0]), number(at.list[1])};
}

/// Reads `confidence` and `seeds`. They are only allowed for an upper limit on a rate of underruns, and only if different
/// seeds give different runs.
void read_confidence(ScenarioReading& reading, const Table& expect, Expectation& expectation) {
  Errors& errors = reading.errors;
  if (expect.has("seeds") && !expect.has("confidence"))
    return errors.add(expect.place("seeds"), "'seeds' goes with 'confidence'; add confidence = \"95 %\", or remove it");
  if (!expect.has("confidence")) return;
  expectation.confidence = expect.si("confidence");
  if (expect.has("seeds")) expectation.seeds = expect.integer("seeds");
  const Place place = expect.place("confidence");
  if (expectation.metric != "underrun_rate")
    return errors.add(place, fmt::format("'confidence' is that of an underrun_rate; '{}' has none", expectation.metric));
  if (!expectation.max || expectation.min)
    return errors.add(place, "'confidence' needs a max, and no min or equals: it bounds the rate from above");
  if (reading.scenario.remap.latency.kind == Budget::Kind::adaptive)
    return errors.add(place,
                      "'confidence' judges a latency that stays as it is, and [remap] latency is \"adaptive\"; judge "
                      "the underruns of this run without it, or give a duration");
  const Result<double> most = in_base(*expectation.max, "1", 0, reading.scenario.nominal);
  if (!most) return errors.add(expect.place("max"), fmt::format("'max': {}", most.error()));
  if (*most <= 0 || *most >= 1)
    errors.add(expect.place("max"), "'max': no number of seeds shows a rate of 0, and any shows 1; write one between");
}

/// What an expectation and a state of [[sometimes]] have in common.
Expectation read_condition(ScenarioReading& reading, const Table& expect, const Place& place, const Names& names) {
  Expectation expectation;
  expectation.place = place;
  expectation.signal = expect.text("signal");
  expectation.metric = expect.text("metric");
  expectation.written.signal = expect.place("signal");
  expectation.written.metric = expect.place("metric");
  const bool of_case = reading.document.find("case") != nullptr;
  const std::string error = !of_case                     ? signal_error(expectation.signal, names)
                            : reading.scenario.case_spec ? case_signal_error(expectation.signal, names)
                                                         : "";
  if (!error.empty()) reading.errors.add(expect.place("signal"), fmt::format("'signal': {}", error));
  if (expectation.metric.empty())
    reading.errors.add(expect.place("metric"), "'metric' is empty; name a number of docs/reference/metrics.md");
  read_limits(expect, expectation, reading.scenario.nominal, reading.errors);
  // Energy costs a pass over all springs per step, so the scene computes it only if it is asked for.
  if (expectation.metric.starts_with("energy_") && !expectation.signal.starts_with("closed_loop."))
    reading.scenario.scene.needs_energy = true;
  // These metrics need a second solver that makes a step of the tissue at every tick.
  for (const char* metric : {"error_max", "error_rms", "error_share", "error_at_stop", "error_growth", "error_growth_min",
                             "onset_delay", "ghost_force"})
    reading.scenario.needs_undelayed |=
        expectation.metric == metric && expectation.signal.find(".interaction.") == std::string::npos;
  return expectation;
}

void read_expectation(ScenarioReading& reading, const Value& value, const Names& names) {
  const Table expect(&value, "expect", value.place);
  Expectation expectation = read_condition(reading, expect, value.place, names);
  expectation.because = expect.text("because");
  expectation.expect_fail = expect.boolean("expect_fail");
  if (expect.has("clock")) expectation.clock = expect.text("clock");
  const bool of_case = reading.document.find("case") != nullptr;
  if (of_case && expect.has("clock")) reading.errors.add(expect.place("clock"), "'clock': a [case] has none; remove it");
  if (expect.has("at")) read_range(expect, of_case, expectation, reading.errors);
  read_confidence(reading, expect, expectation);
  reading.scenario.expectations.push_back(std::move(expectation));
}

void read_sometimes(ScenarioReading& reading, const Names& names) {
  const Value* states = reading.document.find("sometimes");
  if (states == nullptr) return;
  if (reading.document.find("sweep") == nullptr)
    reading.errors.add(states->place,
                       "[[sometimes]] is about the points of a sweep, and there is no [sweep]: nothing would ever judge it");
  for (const Value& value : states->list) {
    if (!reading.check.sound(&value)) continue;
    const Table state(&value, "sometimes", value.place);
    const std::string name = state.text("name");
    for (const Sometimes& earlier : reading.scenario.sometimes) {
      if (earlier.name == name) reading.errors.add(state.place("name"), fmt::format("'name': \"{}\" is there twice", name));
    }
    if (name.empty()) reading.errors.add(state.place("name"), "'name' is empty; say which state must be reached");
    reading.scenario.sometimes.push_back({name, read_condition(reading, state, value.place, names)});
  }
}

}  // namespace

void read_expectations(ScenarioReading& reading) {
  const Names names = collect_names(reading);
  if (const Value* expect = reading.document.find("expect")) {
    for (const Value& value : expect->list) {
      if (reading.check.sound(&value)) read_expectation(reading, value, names);
    }
  }
  read_sometimes(reading, names);
  const Value* stop = reading.document.find("expect_stop");
  if (stop == nullptr || !reading.check.sound(stop)) return;
  const Table table(stop, "expect_stop", stop->place);
  Scenario::ExpectStop expected{table.text("reason"), table.text("message"), std::nullopt, std::nullopt, stop->place};
  if (table.has("at_least_step")) expected.at_least_step = table.integer("at_least_step");
  if (table.has("at_most_step")) expected.at_most_step = table.integer("at_most_step");
  if (expected.at_least_step && expected.at_most_step && *expected.at_least_step > *expected.at_most_step) {
    reading.errors.add(table.place("at_least_step"),
                       fmt::format("'at_least_step': {} is above at_most_step, {}; nothing can hold",
                                   *expected.at_least_step, *expected.at_most_step));
  }
  reading.scenario.expect_stop = std::move(expected);
}

// A key is a few full lines.
// clang-format off
const std::vector<Field>& expect_fields() {
  static const std::vector<Field> rows{
      {.table = "expect", .key = "signal", .forms = kText,
       .meaning = "`<device>.interaction.<strategy>`, `<device>.force.<strategy>`, "
                  "`<device>.buffers.<strategy>`, `closed_loop.<device>.<strategy>`, `solver.<strategy>`, "
                  "`events.<lane>.<name>` or `run`; `*` for any one part. Of a case: `case.<method>.<solver>`.",
       .required = true, .example = "\"left.interaction.phase_locked\""},
      {.table = "expect", .key = "metric", .forms = kText,
       .meaning = "A number of that signal: docs/reference/metrics.md.",
       .required = true, .example = "\"velocity_jump\""},
      {.table = "expect", .key = "min", .forms = kLimit, .meaning = "The value must not be below.", .example = "\"4 step\""},
      {.table = "expect", .key = "max", .forms = kLimit,
       .meaning = "The value must not be above.",
       .example = "\"1e-6 step\""},
      {.table = "expect", .key = "equals", .forms = kLimit, .meaning = "min and max in one.", .example = "0"},
      {.table = "expect", .key = "at", .forms = kNumber, .shape = Shape::list,
       .meaning = "In a case: judge only the cells whose values lie between these two.",
       .example = "[0.1, 1]"},
      {.table = "expect", .key = "confidence", .forms = kQuantity,
       .meaning = "Of an `underrun_rate`: how sure the `max` must be. What is judged is the upper bound of Clopper and "
                  "Pearson on the share of segments with an underrun; for this the maps alone run over `seeds`.",
       .dimension = D::ratio, .range = above(0, 0.999999), .example = "\"95 %\""},
      {.table = "expect", .key = "seeds", .forms = kInteger,
       .meaning =
           "With `confidence`: the seeds to run, this run's and the ones after it. Default: the fewest that suffice if none "
           "underruns.",
       .range = between(1, 1e6), .example = "100"},
      {.table = "expect", .key = "because", .forms = kText, .default_toml = "\"\"", .meaning = "Why it must hold."},
      {.table = "expect", .key = "expect_fail", .forms = kBoolean, .default_toml = "false",
       .meaning = "A known fault: if the expectation holds, that counts as a failure."},
      {.table = "expect", .key = "clock", .forms = kWord,
       .meaning =
           "Judge it on this clock only; on the other one it is skipped. Default: on both. `wall` is for what says how "
           "well the machine kept real time: if it does not hold, the run is `degraded`, not failed.",
       .words = "virtual|wall", .example = "\"wall\""},
      {.table = "sometimes", .key = "name", .forms = kText,
       .meaning = "The state, in words: what is said if no point reached it.",
       .required = true, .example = "\"a force came too late\""},
      {.table = "sometimes", .key = "signal", .forms = kText,
       .meaning = "As of an expectation; with `*` one signal is enough.",
       .required = true, .example = "\"left.force.phase_locked\""},
      {.table = "sometimes", .key = "metric", .forms = kText,
       .meaning = "A number of that signal: docs/reference/metrics.md.",
       .required = true, .example = "\"late\""},
      {.table = "sometimes", .key = "min", .forms = kLimit, .meaning = "The value is not below.", .example = "1"},
      {.table = "sometimes", .key = "max", .forms = kLimit, .meaning = "The value is not above.", .example = "\"1 ms\""},
      {.table = "sometimes", .key = "equals", .forms = kLimit, .meaning = "min and max in one.", .example = "0"},
      {.table = "expect_stop", .key = "reason", .forms = kWord,
       .meaning = "Why the run stops.",
       .words = "unstable-step|diverged|bad-input|device|interrupted", .required = true, .example = "\"diverged\""},
      {.table = "expect_stop", .key = "message", .forms = kText, .default_toml = "\"\"",
       .meaning = "What the run says when it stops contains this."},
      {.table = "expect_stop", .key = "at_least_step", .forms = kInteger,
       .meaning = "The run has made at least this many steps when it stops.",
       .range = between(0, 1e12), .example = "90"},
      {.table = "expect_stop", .key = "at_most_step", .forms = kInteger,
       .meaning = "It stops at this step or before.",
       .range = between(0, 1e12), .example = "100"},
  };
  return rows;
}
// clang-format on

}  // namespace evenstep::internal
