// A case that is stopped: every form of the result says what was not run.
#include "catch.h"
#include "evenstep/catalogue/run_trial.h"
#include "evenstep/harness/run.h"
#include "evenstep/harness/run_folder.h"
#include "oscillator.h"
#include "support.h"

using namespace evenstep;
using namespace evenstep::internal;
using Catch::Contains;

namespace {

/// An oscillator that is stopped after this many steps of its two runs.
class StoppedTrial final : public Trial {
 public:
  StoppedTrial(std::unique_ptr<Trial> right, std::int64_t stop_at, std::atomic<bool>& interrupted)
      : right_(std::move(right)), left_(stop_at), interrupted_(interrupted) {
    scene = right_->scene;
    steps = right_->steps;
  }
  void hands(std::int64_t, std::span<glm::dvec3>) const override {
    if (--left_ == 0) interrupted_ = true;
  }
  bool observe(std::int64_t n, const ToolResponse& r, Solver& solver) override { return right_->observe(n, r, solver); }
  void judge(Solver& solver, CaseCell& cell) override { right_->judge(solver, cell); }

 private:
  std::unique_ptr<Trial> right_;
  mutable std::int64_t left_;
  std::atomic<bool>& interrupted_;
};

std::atomic<bool> stopped;
std::int64_t stop_at = 0;

std::unique_ptr<Trial> make_stopped(const CellSpec& cell) {
  return std::make_unique<StoppedTrial>(make_oscillator(cell), stop_at, stopped);
}

}  // namespace

TEST_CASE("A cell that is stopped in either of its two runs is interrupted and has no numbers") {
  CaseSpec spec;
  spec.kind = "oscillator";
  spec.periods = 1000;
  spec.most_steps = 50;
  const CaseKind kind{"oscillator", "w h", "", make_stopped};
  const auto cell_stopped_at = [&](std::int64_t step) {
    stopped = false;
    stop_at = step;
    return run_cell(kind, {spec, 0.5, Method::symplectic_euler, SolverKind::cpu_double}, 1, &stopped);
  };
  for (const std::int64_t step : {1, 25, 50, 51, 75, 99}) {
    INFO(step);
    const CaseCell cell = cell_stopped_at(step);
    CHECK(cell.status == CellStatus::interrupted);
    CHECK(cell.value == 0.5);
    CHECK(cell.metrics.empty());
    CHECK_FALSE(cell.schedule_differs);
    CHECK(stop_at == step);
  }
  const CaseCell whole = cell_stopped_at(101);
  CHECK(whole.status == CellStatus::ok);
  CHECK(whole.steps == 50);
}

TEST_CASE("A case that is stopped before its first cell shows none of them as run, in text, CSV, picture and summary") {
  const ReadResult read = test::read_text(
      "format = 1\nname = \"stopped\"\n[case]\nkind = \"oscillator\"\nmethods = [\"rk4\"]\nsolvers = [\"cpu\"]\n"
      "values = [0.5, 1]\n[[expect]]\nsignal = \"case.*.*\"\nmetric = \"refused\"\nequals = 0\n");
  REQUIRE(read);
  const std::atomic<bool> interrupted{true};
  RunOptions options;
  options.control.interrupted = &interrupted;
  const RunOutcome outcome = run_scenario(*read, options);
  CHECK(outcome.exit == ExitCode::interrupted);
  CHECK(outcome.results.empty());
  const std::string table = case_table(*outcome.case_record);
  CHECK_THAT(table, Contains("rk4 cpu  not run  not run") && !Contains(" ok"));
  CHECK_THAT(cells_csv(*outcome.case_record), Contains("rk4,cpu,0.5,interrupted,") && Contains("rk4,cpu,1,interrupted,"));
  CHECK_THAT(case_strip_svg(*outcome.case_record, ""), Contains(">not run<"));
  CHECK(outcome.metrics.at("case.rk4.cpu").at("interrupted") == 2);
  CHECK(outcome.metrics.at("case.rk4.cpu").at("ok") == 0);
  CHECK_THAT(summary_of(outcome), Contains("\"interrupted\":2") && Contains("\"ok\":0"));
}
