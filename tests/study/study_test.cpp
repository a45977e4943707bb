// Errors of methods, solvers and steps. Costs are measured, so of them only what is always so is asserted.
#include <cmath>
#include <set>

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

TEST_CASE("Every cell of a study is there, and what was not measured says why") {
  const Scenario block = small_study({"study.solvers=[\"cpu-double\", \"cpu\"]", "study.iterations=[2, 6]"});
  const StudyRecord study = run_study(block);
  for (const SolverKind solver : {SolverKind::cpu_double, SolverKind::cpu_float}) {
    for (const Method method : kAllMethods) {
      const auto cells = cells_of(study, method, solver);
      INFO(name_of(solver) << " " << name_of(method));
      // Explicit: one above the limit, four below it. Implicit: four steps with each of two iterations.
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

TEST_CASE("The errors of a study are the same again, bit for bit") {
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

TEST_CASE("A step that is not stable diverges where it is let start, and the cell says so") {
  const Scenario block = small_study({"scene.allow_unstable=true", "study.methods=[\"symplectic-euler\"]", "study.duration=\"200 ms\"",
                                      "study.step_sizes=[\"4 ms\", \"2 ms\", \"0.25 ms\"]", "study.solvers=[\"cpu-double\"]"});
  const StudyRecord study = run_study(block);
  REQUIRE(study.cells.size() == 3);
  CHECK(study.cells[0].state == State::diverged);
  CHECK(study.cells[1].state == State::diverged);
  CHECK_FALSE(study.cells[1].reason.empty());
  CHECK(study.cells[2].state == State::measured);
  CHECK(std::isnan(study.cells[2].order[StudyQuantity::position]));  // nothing to compare with
}

TEST_CASE("Interrupted before its first cell, a study has none and says so") {
  const std::atomic<bool> interrupted{true};
  StudyControl control;
  control.interrupted = &interrupted;
  const StudyRecord study = run_study(small_study(), control);
  CHECK(study.cells.empty());
  CHECK(study.interrupted);
  CHECK_THAT(study_table(study), Contains("interrupted: cells are missing"));
}

TEST_CASE("A spring is refused") {
  const ReadResult spring = read_scenario(std::string(EVENSTEP_SOURCE_DIR) + "/scenarios/paper/figure-1-spring.toml");
  REQUIRE(spring.scenario);
  CHECK_THROWS_WITH(run_study(*spring.scenario), Contains("kind = \"tissue\""));
}
