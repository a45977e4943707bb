// Errors of methods, solvers and steps. Costs are measured, so the tests assert only what is always true of them.
#include <cmath>
#include <set>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/sim/stability.h"
#include "study_scenes.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

using State = StudyCell::State;

std::vector<const StudyCell*> cells_of(const StudyRecord& study, Method method, SolverKind solver = SolverKind::cpu_double) {
  std::vector<const StudyCell*> cells;
  for (const StudyCell& cell : study.cells) {
    if (cell.method == name_of(method) && cell.solver == name_of(solver)) cells.push_back(&cell);
  }
  return cells;
}

}  // namespace

TEST_CASE("Every cell of a study is there, and what was not measured says why", "[sweep]") {
  const Scenario block = small_study({"study.solvers=[\"cpu-double\", \"cpu\"]", "study.iterations=[2, 6]"});
  const StudyRecord study = run_study(block);
  for (const SolverKind solver : {SolverKind::cpu_double, SolverKind::cpu_float}) {
    for (const Method method : kAllMethods) {
      const auto cells = cells_of(study, method, solver);
      INFO(name_of(solver) << " " << name_of(method));
      // Explicit methods have one step above the limit and four below it, implicit ones four steps with each of two
      // iterations.
      CHECK(cells.size() == (iterates(method) ? 8 : 5));
      for (const StudyCell* cell : cells) CHECK(cell->reason.empty() == (cell->state == State::measured));
    }
    const auto explicit_cells = cells_of(study, Method::symplectic_euler, solver);
    CHECK(explicit_cells[0]->state == State::refused);
    CHECK_THAT(explicit_cells[0]->reason, Contains("above the limit of"));
    for (std::size_t i = 1; i < 5; ++i) CHECK(explicit_cells[i]->state == State::measured);
  }
  for (const StudyCell& cell : study.cells) {
    if (cell.state != State::measured) continue;
    CHECK(cell.repeats == 1);
    CHECK(cell.cpu.min > 0);
    CHECK(cell.cpu.min <= cell.cpu.median);
    CHECK(cell.cpu.median <= cell.cpu.max);
  }
}

TEST_CASE("A ladder of iterations is run: each cell says how many it took, and more of them come closer") {
  const Scenario block = small_study({"study.solvers=[\"cpu-double\"]",
                                      "study.methods=[\"implicit-euler\", "
                                      "\"implicit-midpoint\", \"vertex-block-descent\"]",
                                      "study.step_sizes=[\"1 ms\"]", "study.iterations=[1, 3, 30]"});
  const StudyRecord study = run_study(block);
  for (const Method method : {Method::implicit_euler, Method::implicit_midpoint, Method::vertex_block_descent}) {
    INFO(name_of(method));
    const auto cells = cells_of(study, method);
    REQUIRE(cells.size() == 3);
    CHECK(cells[0]->iterations == 1);
    CHECK(cells[1]->iterations == 3);
    CHECK(cells[2]->iterations == 30);
    for (const StudyCell* cell : cells) REQUIRE(cell->state == State::measured);
    CHECK(cells[2]->error[StudyQuantity::position] < 0.9 * cells[0]->error[StudyQuantity::position]);
  }
}

TEST_CASE("A cell that is tens of times farther off than the motion has diverged, though it is finite") {
  // 2 ms is 2.7 times the limit; after 12 ms the fastest mode is 36.5 times the motion.
  const Scenario block =
      small_study({"scene.allow_unstable=true", "study.methods=[\"symplectic-euler\"]", "study.duration=\"12 ms\"",
                   "study.step_sizes=[\"2 ms\", \"0.5 ms\"]", "study.solvers=[\"cpu-double\"]"});
  const StudyRecord study = run_study(block);
  REQUIRE(study.cells.size() == 2);
  CHECK(study.cells[0].state == State::diverged);
  CHECK_THAT(study.cells[0].reason, Contains("36.5 times the motion"));
  CHECK(study.cells[1].state == State::measured);
}

TEST_CASE("On a swinging chain every method has the order that it is known for") {
  struct {
    Method method;
    double order;
  } const rows[] = {{Method::symplectic_euler, 1}, {Method::velocity_verlet, 2},   {Method::rk4, 4},
                    {Method::implicit_euler, 1},   {Method::implicit_midpoint, 2}, {Method::vertex_block_descent, 1}};
  for (const int p : {1, 2}) {
    // 40 iterations are enough: conjugate gradients end after as many as there are particles, and each sweep leaves only
    // h^2 k / m = 0.01 of the error.
    const Scenario chain = ChainMode{p}.scenario({"study.step_sizes=[\"0.25 ms\", \"0.125 ms\", \"62.5 us\"]",
                                                  "study.iterations=[40]", "study.solvers=[\"cpu-double\"]"});
    const StudyRecord study = run_study(chain);
    for (const auto& row : rows) {
      INFO("mode " << p << " " << name_of(row.method));
      const auto cells = cells_of(study, row.method);
      REQUIRE(cells.size() == 3);
      for (const StudyCell* cell : cells) REQUIRE(cell->state == State::measured);
      for (std::size_t i = 1; i < 3; ++i) {
        // The next term of the error is w h times the first: 0.06 and 0.12 at the coarsest step.
        CHECK(cells[i]->order[StudyQuantity::position] == Approx(row.order).margin(0.1));
        CHECK(cells[i]->order[StudyQuantity::force] == Approx(row.order).margin(0.1));
      }
    }
  }
}

TEST_CASE("Where a method must be better than another it is, on every step that both take") {
  const Scenario block =
      small_study({"scene.axial_damping=\"0 N s/m\"", "study.step_sizes=[\"0.5 ms\", \"0.25 ms\", \"0.125 ms\"]",
                   "study.iterations=[40]", "study.solvers=[\"cpu-double\"]"});
  const StudyRecord study = run_study(block);
  const auto euler = cells_of(study, Method::implicit_euler), midpoint = cells_of(study, Method::implicit_midpoint);
  const auto descent = cells_of(study, Method::vertex_block_descent), rk4 = cells_of(study, Method::rk4);
  const auto symplectic = cells_of(study, Method::symplectic_euler), verlet = cells_of(study, Method::velocity_verlet);
  for (std::size_t i = 0; i < 3; ++i) {
    for (const auto* cells : {&euler, &midpoint, &descent, &rk4, &symplectic, &verlet}) {
      REQUIRE((*cells)[i]->state == State::measured);
      for (const StudyQuantity q : kStudyQuantities) {
        if (i > 0) CHECK((*cells)[i]->error[q] < (*cells)[i - 1]->error[q]);  // a shorter step is a smaller error
      }
    }
    for (const StudyQuantity q : kStudyQuantities) {
      INFO(euler[i]->substep_s << " " << name_of(q));
      CHECK(midpoint[i]->error[q] < euler[i]->error[q]);
      CHECK(rk4[i]->error[q] < midpoint[i]->error[q]);
      CHECK(rk4[i]->error[q] < symplectic[i]->error[q]);
      CHECK(symplectic[i]->error[q] < euler[i]->error[q]);
      // Both solve the same implicit equations: implicit Euler linearises them once, vertex block descent takes Newton
      // steps.
      CHECK(descent[i]->error[q] == Approx(euler[i]->error[q]).epsilon(0.1));
    }
    // From rest and without damping Verlet follows the path of symplectic Euler, except for rounding by 1e-12 of the motion.
    // But its velocities, and so the energy, belong to whole steps.
    CHECK(verlet[i]->error[StudyQuantity::energy] < symplectic[i]->error[StudyQuantity::energy]);
    CHECK(verlet[i]->error[StudyQuantity::position] == Approx(symplectic[i]->error[StudyQuantity::position]).epsilon(1e-6));
  }
}

TEST_CASE("The errors of a study are the same again, bit for bit", "[sweep]") {
  const Scenario block = small_study({"study.solvers=[\"cpu\", \"opencl\"]", "study.methods=[\"symplectic-euler\"]"});
  const StudyRecord first = run_study(block), again = run_study(block);
  REQUIRE(first.cells.size() == again.cells.size());
  for (std::size_t i = 0; i < first.cells.size(); ++i) {
    REQUIRE(first.cells[i].state == again.cells[i].state);
    for (const StudyQuantity q : kStudyQuantities) {
      if (first.cells[i].state == State::measured) CHECK(first.cells[i].error[q] == again.cells[i].error[q]);
    }
  }
  // cpu (float) and opencl take the same path.
  const auto cpu = cells_of(first, Method::symplectic_euler, SolverKind::cpu_float);
  const auto opencl = cells_of(first, Method::symplectic_euler, SolverKind::opencl);
  REQUIRE(cpu.size() == opencl.size());
  for (std::size_t i = 0; i < cpu.size(); ++i) {
    if (opencl[i]->state == State::unavailable) continue;  // no OpenCL device here: said in the cell
    CHECK(cpu[i]->state == opencl[i]->state);
    if (cpu[i]->state != State::measured) continue;
    CHECK(cpu[i]->error[StudyQuantity::position] == opencl[i]->error[StudyQuantity::position]);
    CHECK(cpu[i]->error[StudyQuantity::force] == opencl[i]->error[StudyQuantity::force]);
  }
  CHECK_FALSE(first.opencl_device.empty());
}

TEST_CASE("A step that is not stable diverges where it is let start, and the cell says so", "[sweep]") {
  const Scenario block =
      small_study({"scene.allow_unstable=true", "study.methods=[\"symplectic-euler\"]", "study.duration=\"200 ms\"",
                   "study.step_sizes=[\"4 ms\", \"2 ms\", \"0.25 ms\"]", "study.solvers=[\"cpu-double\"]"});
  const StudyRecord study = run_study(block);
  REQUIRE(study.cells.size() == 3);
  CHECK(study.cells[0].state == State::diverged);
  CHECK(study.cells[1].state == State::diverged);
  CHECK_FALSE(study.cells[1].reason.empty());
  CHECK(study.cells[2].state == State::measured);
  CHECK(std::isnan(study.cells[2].order[StudyQuantity::position]));  // nothing to compare with
}

TEST_CASE("Interrupted in its reference or in a cell, a study has the cells before, and says what is missing") {
  std::atomic<bool> interrupted{true};
  StudyControl control;
  control.interrupted = &interrupted;
  const StudyRecord none = run_study(small_study(), control);
  CHECK(none.cells.empty());
  CHECK(none.interrupted);
  CHECK_THAT(study_table(none), Contains("reference    none: it was interrupted") && Contains("cells are missing"));
  interrupted = false;
  control.progress = [&](double fraction) { interrupted = fraction > 0; };
  const StudyRecord one = run_study(small_study(), control);
  CHECK(one.cells.size() == 1);
  CHECK(one.interrupted);
  CHECK_THAT(study_table(one), Contains("reference    rk4") && Contains("cells are missing"));
  // Any error would do, so the one cell would be the cheapest; those that are missing may be cheaper.
  const StudyAdvice advice = advise(one, *parse_goal("100000 % force"));
  CHECK(advice.cell == nullptr);
  CHECK_THAT(advice.text, Contains("no advice on 100000 % force: the study was interrupted"));
  CHECK(advise(none, *parse_goal("1 % force")).text == no_advice_if_interrupted(*parse_goal("1 % force")));
}

TEST_CASE("A spring is refused") {
  const ReadResult spring = read_scenario(std::string(EVENSTEP_SOURCE_DIR) + "/scenarios/paper/figure-1-spring.toml");
  REQUIRE(spring);
  CHECK_THROWS_WITH(run_study(*spring), Contains("kind = \"tissue\""));
}

TEST_CASE("A cell's cost is no more than the processor time that it took, over the rest before the motion and the motion",
          "[sweep]") {
  // The longest step makes the rest before the motion as long as the motion. With many iterations, a repeat of the other
  // cell takes longer than the time for which short repeats are repeated. A cost over the motion alone would be twice the
  // real one.
  const Scenario block = small_study({"scene.lattice=[7, 7, 7]", "device.left.grab.center=[\"15 mm\", \"15 mm\", \"30 mm\"]",
                                      "study.duration=\"64 ms\"", "study.repeats=4", "study.solvers=[\"cpu-double\"]",
                                      "study.methods=[\"implicit-euler\"]", "study.iterations=[300]",
                                      "study.step_sizes=[\"64 ms\", \"1 ms\"]"});
  std::vector<double> began_s;  // the begin of each cell, and the end
  const StudyRecord study = run_study(block, {nullptr, [&](double) { began_s.push_back(process_cpu_seconds()); }});
  CHECK(study.rest_s == Approx(0.064));
  CHECK(study.duration_s == Approx(0.064));
  REQUIRE(study.cells.size() == 2);
  REQUIRE(began_s.size() == 3);
  for (std::size_t i = 0; i < 2; ++i) {
    const StudyCell& cell = study.cells[i];
    REQUIRE(cell.state == State::measured);
    CHECK(cell.cpu.min * cell.repeats * (study.rest_s + study.duration_s) <= began_s[i + 1] - began_s[i]);
  }
}
