// [case]
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "src/field_rows.h"
#include "src/sections.h"

namespace evenstep::internal {
namespace {

/// The elements of `all` that are named, in the order of the file, each once.
template <class Kind, std::size_t count>
std::vector<Kind> read_names(const Table& table, std::string_view key, const std::array<Kind, count>& all, Errors& errors) {
  std::vector<Kind> kinds;
  for (const Value& name : table.at(key).list) {
    const Kind kind = *std::find_if(all.begin(), all.end(), [&](Kind k) { return name.text == name_of(k); });
    if (std::find(kinds.begin(), kinds.end(), kind) != kinds.end())
      errors.add(name.place, fmt::format("'{}' names \"{}\" twice", key, name.text));
    kinds.push_back(kind);
  }
  if (kinds.empty()) errors.add(table.place(key), fmt::format("'{}' is empty; name at least one", key));
  return kinds;
}

/// Appends evenly spaced values on a logarithmic scale; both ends are exact.
void append_decades(const Table& range, std::vector<double>& values, Errors& errors) {
  const double from = range.number("from"), to = range.number("to");
  const std::int64_t count = range.integer("count");
  if (!(from < to))
    errors.add(range.place("to"), fmt::format("'to': {} is not above from, {}; write the larger one", to, from));
  for (std::int64_t i = 0; i < count; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(count - 1);
    // Rounded to twelve digits, so that decades are exact.
    const std::string digits = fmt::format("{:.12g}", std::exp(std::log(from) + part * (std::log(to) - std::log(from))));
    const double value = std::strtod(digits.c_str(), nullptr);  // std::stod would throw for a denormal
    values.push_back(i == 0 ? from : i == count - 1 ? to : value);
  }
}

std::vector<double> read_values(const Table& table, Errors& errors) {
  const Value given = table.at("values");
  std::vector<double> values;
  const auto append = [&](const Value& one) {
    if (one.is(Value::Kind::table)) return append_decades(Table(&one, "case.values", one.place), values, errors);
    values.push_back(one.is(Value::Kind::integer) ? static_cast<double>(one.integer) : one.number);
  };
  if (given.is(Value::Kind::list)) {
    for (const Value& one : given.list) append(one);
  } else {
    append(given);
  }
  const auto falls = std::adjacent_find(values.begin(), values.end(), [](double a, double b) { return !(a < b); });
  if (falls != values.end())
    errors.add(given.place, fmt::format("'values': {} comes after {}; sort them, each once", falls[1], falls[0]));
  return values;
}

/// From [run] a case uses only the seed, for its irregular schedule.
void check_run(const ScenarioReading& reading) {
  const Value* run = reading.document.find("run");
  if (run == nullptr) return;
  for (const Entry& entry : run->table) {
    if (entry.key != "seed")
      reading.errors.add(entry.place, fmt::format("'{}' of [run] does not go with [case]; remove it", entry.key));
  }
}

/// What runs the case instead of `solvers`.
void read_foreign_solver(const ScenarioReading& reading, const Table& table, CaseSpec& spec) {
  Foreign part = read_foreign(reading, table.table("foreign"));
  ForeignScene& foreign = spec.foreign.emplace();
  foreign.make = maker_of("solver", part, reading.registry.solvers(), &Library::solver, reading.errors);
  foreign.name = part.name;
  foreign.options = part.options;
  foreign.seed = part.seed;
  spec.solvers = {SolverKind::cpu_double};
  if (!table.has("methods")) spec.methods = {Method::symplectic_euler};
  if (table.has("solvers"))
    reading.errors.add(table.place("solvers"),
                       "'solvers' does not go with 'foreign', which is the solver; remove one of them");
}

}  // namespace

void read_case(ScenarioReading& reading) {
  check_run(reading);
  if (!reading.sound("case")) return;
  const Table table = reading.section("case");
  CaseSpec spec;
  spec.kind = table.text("kind");
  spec.methods = read_names(table, "methods", kAllMethods, reading.errors);
  spec.solvers = read_names(table, "solvers", kAllSolvers, reading.errors);
  spec.values = read_values(table, reading.errors);
  if (table.exists("periods")) spec.periods = table.number("periods");
  if (table.exists("most_steps")) spec.most_steps = table.integer("most_steps");
  if (table.exists("duration")) spec.duration_s = seconds(table.duration("duration"));
  if (table.exists("step_size")) spec.step_size = table.duration("step_size");
  if (table.exists("particles")) spec.particles = table.integer("particles");
  if (table.exists("allow_unstable")) spec.allow_unstable = table.boolean("allow_unstable");
  if (table.has("iterations")) spec.iterations = static_cast<int>(table.integer("iterations"));
  if (table.has("foreign")) read_foreign_solver(reading, table, spec);
  reading.scenario.case_spec = std::move(spec);
}

// A key is a few full lines.
// clang-format off
const std::vector<Field>& case_fields() {
  static const std::vector<Field> rows{
      {.table = "case", .key = "kind", .forms = kWord,
       .meaning = "Which case: what is set up, what the values are and what the exact answer is (docs/forces/stability.md).",
       .words = "oscillator|stiffness|chain-order|edge|damping|moving-target|mass-ratio|stiff-in-soft|wall|free-fall|"
                "hanging-chain|standing-block|wave|energy|press|degenerate|crushed|numbering",
       .required = true, .example = "\"oscillator\""},
      {.table = "case", .key = "methods", .forms = kWord, .shape = Shape::list,
       .default_toml = "[\"symplectic-euler\", \"velocity-verlet\", \"rk4\", \"implicit-euler\", \"implicit-midpoint\", "
                       "\"vertex-block-descent\"]",
       .meaning = "One row of cells for each, with each solver.",
       .words = method_words()},
      {.table = "case", .key = "solvers", .forms = kWord, .shape = Shape::list, .default_toml = "[\"cpu-double\", \"cpu\"]",
       .meaning = "What computes it.",
       .words = "opencl|cpu|cpu-double"},
      {.table = "case", .key = "values", .forms = kNumber | kTable, .shape = Shape::one_or_list,
       .meaning = "One cell for each, strictly rising. A table is `count` of them, evenly spaced in their logarithms.",
       .required = true, .range = above(0), .example = "[1, 10, 100]"},
      {.table = "case", .key = "periods", .forms = kNumber, .default_toml = "1000",
       .meaning = "Number of the oscillator's periods to run.",
       .kinds = "oscillator", .range = above(0, 1e9)},
      {.table = "case", .key = "most_steps", .forms = kInteger, .default_toml = "20000",
       .meaning = "Steps to run; for an oscillator, the most that its periods may take.",
       .kinds = "oscillator|edge|wall|wave|energy|crushed", .range = between(1, 1e12)},
      {.table = "case", .key = "duration", .forms = kDuration, .default_toml = "\"10 s\"",
       .meaning = "Simulation time to run.",
       .kinds = "stiffness|chain-order|damping", .range = above(0, 1e4)},
      {.table = "case", .key = "step_size", .forms = kDuration, .default_toml = "\"1 ms\"",
       .meaning = "Simulation time per step.",
       .kinds = "free-fall", .range = above(0, 1)},
      {.table = "case", .key = "particles", .forms = kInteger, .default_toml = "64",
       .meaning = "In a chain, the particles that move; in a block, the particles along each edge.",
       .kinds = "chain-order|edge|hanging-chain|standing-block|wave", .range = between(2, 1000)},
      {.table = "case", .key = "iterations", .forms = kInteger,
       .meaning = "For the methods that iterate. Default: the number that the method itself chooses.",
       .range = between(1, kMaxIterations), .example = "10"},
      {.table = "case", .key = "allow_unstable", .forms = kBoolean, .default_toml = "false",
       .meaning = "Lets an unstable step size start.",
       .kinds = "oscillator|wall"},
      {.table = "case", .key = "foreign", .forms = kTable,
       .meaning = "A solver that the program has registered, instead of `solvers`. It is handed the particles and springs "
                  "(docs/parts/extending.md), and compared with the closed forms of `methods`, by default symplectic-euler.",
       .kinds = "oscillator|stiffness|chain-order|edge|wave"},
      {.table = "case.values", .key = "from", .forms = kNumber,
       .meaning = "The first one.",
       .required = true, .range = above(0), .example = "1e-4"},
      {.table = "case.values", .key = "to", .forms = kNumber,
       .meaning = "The last one.",
       .required = true, .range = above(0), .example = "1"},
      {.table = "case.values", .key = "count", .forms = kInteger,
       .meaning = "How many.",
       .required = true, .range = between(2, 1000), .example = "5"},
  };
  static const std::vector<Field> all = joined(rows, foreign_rows("case.foreign", ""));
  return all;
}
// clang-format on

}  // namespace evenstep::internal
