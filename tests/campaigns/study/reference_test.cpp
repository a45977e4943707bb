// The reference of a study, compared with closed forms.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "evenstep/reports/run_failure.h"
#include "src/study/trace.h"
#include "study_scenes.h"

using namespace evenstep;
using namespace evenstep::internal;
using namespace evenstep::test;

namespace evenstep::test {

double ChainMode::shape(int j) const { return std::sin(p * j * std::numbers::pi / (kMobile + 1)); }

double ChainMode::omega_per_s() const {
  return 2 * std::sqrt(20 / 1e-4) * std::sin(p * std::numbers::pi / (2.0 * (kMobile + 1)));
}

Scenario ChainMode::scenario(const std::vector<std::string>& set) const {
  std::vector<std::string> all{fmt::format("scene.lattice=[{}, 1, 1]", kMobile + 2),
                               "scene.fixed=left",
                               "scene.axial_damping=\"0 N s/m\"",
                               fmt::format("device.left.grab.center=[\"{} mm\", \"0 mm\", \"0 mm\"]", 5 * (kMobile + 1)),
                               "device.left.grab.radius=\"1 mm\"",
                               "device.left.motion={ kind = \"still\" }"};
  all.insert(all.end(), set.begin(), set.end());
  Scenario chain = small_study(all);
  auto& tissue = std::get<TissueScene>(chain.scene.body);
  tissue.initial_displacement_m.assign(kMobile + 2, glm::dvec3(0));
  for (int j = 1; j <= kMobile; ++j) tissue.initial_displacement_m[static_cast<std::size_t>(j)].x = amplitude_m * shape(j);
  return chain;
}

}  // namespace evenstep::test

namespace {

/// The exact trace at the samples of the study.
StudyTrace exact(const ChainMode& mode, const Scenario& chain, const StudyPlan& plan) {
  StudyTrace trace;
  const double omega = mode.omega_per_s(), k = 20;
  double energy = 0;  // at t = 0 all of it is in the springs
  for (int j = 0; j <= ChainMode::kMobile; ++j) {
    const double stretch = mode.amplitude_m * (mode.shape(j + 1) - mode.shape(j));
    energy += k * stretch * stretch / 2;
  }
  for (std::int64_t s = 1; s <= plan.samples; ++s) {
    const double t = plan.rest_s(chain) + static_cast<double>(s * plan.stride) * period_s(chain.scene.step_rate);
    std::vector<glm::dvec3> u(ChainMode::kMobile + 2, glm::dvec3(0));
    for (int j = 1; j <= ChainMode::kMobile; ++j)
      u[static_cast<std::size_t>(j)].x = mode.amplitude_m * mode.shape(j) * std::cos(omega * t);
    // The last spring pulls the tool towards the last mobile particle: k (u_n - 0).
    trace.force_N.push_back({glm::dvec3(k * u[ChainMode::kMobile].x, 0, 0), glm::dvec3(0)});
    trace.displacement_m.push_back(std::move(u));
    trace.energy_J.push_back(energy);
  }
  return trace;
}

}  // namespace

TEST_CASE("The reference of a swinging chain is the cosine that it is, to within the error that it states") {
  for (const int p : {1, 2, 3, 7, 14}) {
    const ChainMode mode{p};
    const Scenario chain = mode.scenario();
    const StudyPlan plan(chain, {{1, 1}});
    REQUIRE(plan.samples == 16);
    const StudyReferenceRun reference = solve_reference(chain, plan, 1);
    const StudyValues error = error_of(reference.trace, exact(mode, chain, plan), reference.info.scale);
    for (const StudyQuantity q : kStudyQuantities) {
      INFO("mode " << p << " " << name_of(q) << " order " << reference.info.order[q]);
      // Some 1e4 additions round by 1e-16 each, in units of the motion. The energy is a sum of squares.
      const double rounding = 1e-12 * (q == StudyQuantity::position ? reference.info.scale[q] : 1);
      CHECK(error[q] <= reference.info.estimate[q] + rounding);
      CHECK(reference.info.estimate[q] < 1e-4);
    }
  }
}

TEST_CASE("The errors are what their definitions say: metres for the position, shares of the rms for force and energy") {
  StudyTrace a, r;  // two samples of two particles and one tool
  a.displacement_m = {{{3, 0, 0}, {0, 0, 0}}, {{0, 0, 0}, {0, 4, 0}}};
  r.displacement_m = {{{0, 0, 0}, {0, 0, 0}}, {{0, 0, 0}, {0, 0, 0}}};
  a.force_N = {{{{1, 2, 2}, {0, 0, 0}}}, {{{0, 0, 0}, {0, 0, 0}}}};
  r.force_N = {{{{1, 2, 2}, {0, 0, 0}}}, {{{0, 0, 4}, {0, 0, 0}}}};
  a.energy_J = {2, 2};
  r.energy_J = {1, 7};
  const StudyValues scale = rms(r, nullptr), error = error_of(a, r, scale);
  CHECK(scale[StudyQuantity::position] == 0);
  CHECK(scale[StudyQuantity::force] == Approx(std::sqrt((9 + 16) / 2.0)));
  CHECK(scale[StudyQuantity::energy] == Approx(5));
  CHECK(error[StudyQuantity::position] == Approx(std::sqrt(25 / 4.0)));
  CHECK(error[StudyQuantity::force] == Approx(4 / 5.0));
  CHECK(error[StudyQuantity::energy] == Approx(std::sqrt(26 / 2.0) / 5));
  StudyValues nothing = scale;
  nothing[StudyQuantity::force] = 0;
  CHECK(std::isnan(error_of(a, r, nothing)[StudyQuantity::force]));  // there is no scale for a relative error
}

TEST_CASE("The reference states twice what the last two of its extrapolations differ by") {
  const Scenario block = small_study();
  const StudyPlan plan(block, {{1, 1}});
  const StudyReferenceRun reference = solve_reference(block, plan, 1);
  REQUIRE(reference.info.method == "rk4");
  const auto coarsest = static_cast<int>(std::lround(period_s(block.scene.step_rate) / reference.info.coarsest_substep_s));
  const auto run = [&](int substeps) {
    const StudyStep step{substeps, 1};
    return trace_of(*make_study_solver(block, {SolverKind::cpu_double, Method::rk4, 0, step}, true), block, plan, step);
  };
  StudyTrace first = run(coarsest);
  const StudyTrace second = run(2 * coarsest);
  // At order 4, the error that is left with half the step is a fifteenth of the difference. `first` becomes the
  // extrapolation.
  const auto extrapolate = [](auto& coarse, const auto& fine) { coarse = fine + (fine - coarse) / 15.0; };
  for (std::size_t s = 0; s < first.energy_J.size(); ++s) {
    for (std::size_t p = 0; p < first.displacement_m[s].size(); ++p)
      extrapolate(first.displacement_m[s][p], second.displacement_m[s][p]);
    extrapolate(first.force_N[s][0], second.force_N[s][0]);
    extrapolate(first.energy_J[s], second.energy_J[s]);
  }
  const StudyValues differ = error_of(first, reference.trace, reference.info.scale);
  for (const StudyQuantity q : kStudyQuantities) {
    INFO(name_of(q));
    CHECK(differ[q] > 1e-15);                                                  // otherwise there is nothing to compare
    CHECK(reference.info.estimate[q] == Approx(2 * differ[q]).epsilon(1e-3));  // the same sums, in another order
  }
}

TEST_CASE("A finer reference agrees with a coarser one to within what the coarser one states", "[sweep]") {
  const Scenario block = small_study();
  const StudyPlan plan(block, {{1, 1}});
  const StudyReferenceRun coarse = solve_reference(block, plan, 1), fine = solve_reference(block, plan, 64);
  CHECK(fine.info.coarsest_substep_s < coarse.info.coarsest_substep_s / 2);
  const StudyValues difference = error_of(coarse.trace, fine.trace, fine.info.scale);
  for (const StudyQuantity q : kStudyQuantities) {
    INFO(name_of(q));
    CHECK(difference[q] <= coarse.info.estimate[q]);
    CHECK(fine.info.estimate[q] <= coarse.info.estimate[q]);
  }
}

TEST_CASE("A plan lets every step end at every sample, whatever the steps, and takes at most 64 samples") {
  const Scenario block = small_study({"study.duration=\"1 s\""});
  for (const std::vector<StudyStep>& steps :
       {std::vector<StudyStep>{{1, 1}}, {{4, 1}, {1, 2}}, {{1, 3}, {1, 5}, {7, 1}}, {{1, 100}}}) {
    const StudyPlan plan(block, steps);
    CHECK(plan.samples >= 1);
    CHECK(plan.samples <= kMostStudySamples);
    CHECK(plan.samples * plan.stride <= 1000);  // steps of 1 ms
    CHECK(plan.samples * plan.stride > 1000 / 2);
    for (const StudyStep& step : steps) {
      CHECK(plan.stride % step.steps == 0);
      CHECK(plan.rest % step.steps == 0);
    }
  }
}

TEST_CASE("A stiffness that would need more substeps than there are is a failure with a remedy") {
  const Scenario block = small_study({"scene.stiffness=\"1e9 kN/m\"", "scene.axial_damping=\"0 N s/m\""});
  try {
    solve_reference(block, StudyPlan(block, {{1, 1}}), 1);
    FAIL("no failure");
  } catch (const RunFailure& failure) {
    CHECK(failure.reason == "limit");
    CHECK_THAT(failure.what(), Catch::Contains("substeps per step of the scene"));
    CHECK_FALSE(failure.remedy.empty());
  }
}
