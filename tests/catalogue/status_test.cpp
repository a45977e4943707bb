// What a cell says about a run: failures that are made on purpose, and what must not count as a failure.
#include <cmath>

#include "blocks.h"
#include "catch.h"
#include "degenerate.h"
#include "evenstep/catalogue/run_trial.h"
#include "evenstep/harness/run.h"
#include "oscillator.h"
#include "run_case.h"
#include "support.h"

using namespace evenstep;
using namespace evenstep::internal;
using Catch::Contains;

namespace {

/// A case of the kind oscillator with at most 500 steps.
CaseSpec oscillator() {
  CaseSpec spec;
  spec.kind = "oscillator";
  spec.periods = 1000;
  spec.most_steps = 500;
  return spec;
}

/// An oscillator whose closed form is that of another spring.
class WrongTrial final : public Trial {
 public:
  explicit WrongTrial(std::unique_ptr<Trial> right) : right_(std::move(right)) {
    scene = right_->scene;
    std::get<TissueScene>(scene.body).stiffness_N_per_m *= 1.0001;
    steps = right_->steps;
  }
  bool observe(std::int64_t n, const ToolResponse& r, Solver& solver) override { return right_->observe(n, r, solver); }
  void judge(Solver& solver, CaseCell& cell) override { right_->judge(solver, cell); }

 private:
  std::unique_ptr<Trial> right_;
};

/// Hands that remember what they did before, so that the inputs of the steps depend on who launches them.
class FickleTrial final : public Trial {
 public:
  FickleTrial() {
    TissueScene tissue;
    tissue.lattice = {3, 3, 3};
    tissue.particle_count = 27;
    tissue.tools = {{{5e-3, 5e-3, 10e-3}, 1e-3}};
    scene.body = tissue;
    steps = 10;
  }
  void hands(std::int64_t n, std::span<glm::dvec3> positions_m) const override {
    positions_m[0].x = static_cast<double>(n) * (1e-5 + static_cast<double>(calls_++ / 20) * 1e-9);
  }
  bool observe(std::int64_t, const ToolResponse&, Solver&) override {
    calls_ += 1;
    return true;
  }
  void judge(Solver&, CaseCell&) override {}

 private:
  mutable std::int64_t calls_ = 0;
};

CaseCell cell_of(const CaseSpec& spec, double value, Method method = Method::symplectic_euler,
                 SolverKind solver = SolverKind::cpu_double) {
  const CaseKind kind{"oscillator", "w h", "", make_oscillator};
  return run_cell(kind, {spec, value, method, solver}, 1, nullptr);
}

}  // namespace

TEST_CASE("A stable oscillator is ok in double and float, with errors at their rounding") {
  const CaseSpec spec = oscillator();
  const CaseCell in_double = cell_of(spec, 0.3),
                 in_float = cell_of(spec, 0.3, Method::symplectic_euler, SolverKind::cpu_float);
  CHECK(in_double.status == CellStatus::ok);
  CHECK(in_double.steps == 500);
  CHECK(in_double.metrics.at("closed_form_error") < 1e-12);
  CHECK(in_float.status == CellStatus::ok);
  // `float` really computes in float. In double the error would be far smaller.
  CHECK(in_float.metrics.at("closed_form_error") > 1e-9);
  CHECK_FALSE(in_double.schedule_differs);
}

TEST_CASE("A closed form that is wrong by a ten-thousandth of the stiffness is found out") {
  const CaseKind kind{"oscillator", "w h", "", [](const CellSpec& cell) -> std::unique_ptr<Trial> {
                        return std::make_unique<WrongTrial>(make_oscillator(cell));
                      }};
  const CaseSpec spec = oscillator();
  const CaseCell cell = run_cell(kind, {spec, 0.3, Method::symplectic_euler, SolverKind::cpu_double}, 1, nullptr);
  CHECK(cell.status == CellStatus::drifting);
  CHECK(*cell.shown > 1e-4);
}

TEST_CASE("Above the limit the solver refuses, and says the limit and the remedy") {
  const CaseCell cell = cell_of(oscillator(), 2.0001);
  CHECK(cell.status == CellStatus::refused);
  CHECK_THAT(cell.detail, Contains("above the limit"));
  CHECK_THAT(cell.detail, Contains("substeps"));
  CHECK(cell.metrics.at("step_over_limit") == Approx(1.00005).epsilon(1e-9));
  CHECK(cell.metrics.count("closed_form_error") == 0);
}

TEST_CASE("Let go above the limit it diverges, at a step that is named and comes sooner the farther above") {
  CaseSpec spec = oscillator();
  spec.allow_unstable = true;
  spec.most_steps = 100'000;
  spec.periods = 1e9;
  std::int64_t before = 100'000;
  for (const double value : {2.0001, 2.01, 3.0, 30.0}) {
    const CaseCell cell = cell_of(spec, value);
    CHECK(cell.status == CellStatus::diverged);
    CHECK(cell.steps < before);
    CHECK_FALSE(cell.schedule_differs);  // the first bad step is the same one
    before = cell.steps;
  }
}

TEST_CASE("Inputs that depend on who launches the steps are a schedule difference") {
  const CaseKind kind{"fickle", "", "",
                      [](const CellSpec&) -> std::unique_ptr<Trial> { return std::make_unique<FickleTrial>(); }};
  const CaseSpec spec;
  CHECK(run_cell(kind, {spec, 1, Method::symplectic_euler, SolverKind::cpu_double}, 1, nullptr).schedule_differs);
}

TEST_CASE("A degenerate scene is refused by the name of what it lacks, and a hand that is not a number by its step") {
  const CaseKind kind{"degenerate", "", "", make_degenerate};
  const CaseSpec spec;
  const std::pair<double, const char*> expected[] = {{8, "particle mass"},
                                                     {9, "0 particles"},
                                                     {10, "stiffness"},
                                                     {11, "step 100: the position of tool 0 is not finite"},
                                                     {12, "step 100"}};
  for (const auto& [value, words] : expected) {
    const CaseCell cell = run_cell(kind, {spec, value, Method::symplectic_euler, SolverKind::cpu_double}, 1, nullptr);
    INFO(value);
    CHECK(cell.status == CellStatus::refused);
    CHECK_THAT(cell.detail, Contains(words));
  }
}

TEST_CASE("The largest eigenvalue of a block at rest is that of its springs, and a chain's is known", "[sweep]") {
  TissueScene chain;
  chain.lattice = {1, 1, 40};
  chain.particle_count = 40;
  chain.fixed = FixedFaces::none();
  const double k_over_m = chain.stiffness_N_per_m / chain.particle_mass_kg;
  // A chain that is free at both ends has 4 k/m sin^2(p pi / 80), with p = 39 at most.
  CHECK(rest_lambda_per_s2(chain) == Approx(4 * k_over_m * std::pow(std::sin(39 * M_PI / 80), 2)).epsilon(1e-3));
  TissueScene block;
  block.lattice = {9, 9, 9};
  block.particle_count = 729;
  const double lambda = rest_lambda_per_s2(block) / k_over_m;
  CHECK(lambda < 12);  // 12 belongs to an infinite lattice
  CHECK(lambda > 11);
}

TEST_CASE("A device that computes something else is a device difference") {
  CaseRecord record{"crushed", "", "", {{"rk4", "cpu", {{}, {}, {}}}, {"rk4", "opencl", {{}, {}, {}}}}};
  for (CaseRow& row : record.rows) {
    for (std::size_t c = 0; c < 3; ++c) {
      row.cells[c].value = static_cast<double>(c);
      row.cells[c].status = CellStatus::ok;
    }
  }
  record.rows[1].cells[1].digest = 1;
  record.rows[1].cells[2].status = CellStatus::unavailable;
  compare_devices(record);
  const Metrics metrics = measure(record);
  CHECK(metrics.at("case.rk4.opencl").at("device_difference") == 1);
  CHECK(record.rows[1].cells[0].metrics.at("device_difference") == 0);
  CHECK(record.rows[1].cells[2].metrics.empty());
  CHECK(metrics.at("case.rk4.cpu").count("device_difference") == 0);
}

TEST_CASE("Every kind's cells are the same for any number of threads, and any seed of the irregular schedule") {
  const std::string text = R"(format = 1
[case]
kind = "oscillator"
methods = ["symplectic-euler"]
values = [0.1, 1, 3]
most_steps = 300
[[expect]]
signal = "case.*.*"
metric = "schedule_difference"
equals = 0
)";
  std::uint64_t hash = 0;
  for (const int threads : {1, 3}) {
    for (const std::uint64_t seed : {1, 2, 3}) {
      const ReadResult read = test::read_text(text, {{}, seed});
      INFO(test::errors_of(read));
      REQUIRE(read);
      RunOptions options;
      options.threads = threads;
      options.allow_no_expectations = true;
      const RunOutcome outcome = run_scenario(*read, options);
      CHECK(outcome.exit == ExitCode::pass);
      if (hash == 0) hash = outcome.record.trace_hash;
      CHECK(outcome.record.trace_hash == hash);
      CHECK(outcome.metrics.at("case.symplectic-euler.cpu").at("refused") == 1);
    }
  }
}

TEST_CASE("An expectation judges the cells of its range alone, and none is an error") {
  const auto outcome_of = [](const std::string& metric, const std::string& limit) {
    const ReadResult read = test::read_text(
        "format = 1\n[case]\nkind = \"oscillator\"\nmethods = [\"symplectic-euler\"]\nsolvers = [\"cpu-double\"]\n"
        "values = [0.1, 1, 3]\nmost_steps = 50\n[[expect]]\nsignal = \"case.symplectic-euler.cpu-double\"\nmetric = \"" +
        metric + "\"\n" + limit);
    REQUIRE(read);
    return run_scenario(*read, {});
  };
  CHECK(outcome_of("refused", "equals = 1").exit == ExitCode::pass);
  CHECK(outcome_of("refused", "equals = 0\nat = [0.1, 1]").exit == ExitCode::pass);
  CHECK(outcome_of("refused", "equals = 0\nat = [3, 3]").exit == ExitCode::expectation_failed);
  CHECK(outcome_of("cells", "equals = 2\nat = [0.5, 10]").exit == ExitCode::pass);
  CHECK(outcome_of("refused", "equals = 0\nat = [4, 5]").exit == ExitCode::usage);
  CHECK(outcome_of("closed_form_error", "max = 1\nat = [3, 3]").exit == ExitCode::usage);  // refused: no error to judge
  CHECK(outcome_of("order", "max = 1").exit == ExitCode::usage);                           // this kind has no order
}

TEST_CASE("A case has no wall clock") {
  const ReadResult read = test::read_text("format = 1\n[case]\nkind = \"oscillator\"\nvalues = [1]\n");
  REQUIRE(read);
  RunOptions options;
  options.clock = ClockKind::wall;
  CHECK(run_scenario(*read, options).exit == ExitCode::usage);
}
