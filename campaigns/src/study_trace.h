#pragma once
/// One run of a study's scene: the same instants and the same motion for every step, method and solver.

#include <array>
#include <glm/vec3.hpp>
#include <vector>

#include "evenstep/format/scenario.h"
#include "evenstep/reports/study.h"
#include "evenstep/sim/solver.h"

namespace evenstep::internal {

inline constexpr std::int64_t kMostStudySamples = 64;

/// Steps of the scene: first `rest` of them with the tools still (a solver takes a tool's first position as its origin),
/// then `samples` times `stride` along the motion. Every step of the study ends at each sample.
struct StudyPlan {
  StudyPlan(const Scenario& scenario, const std::vector<StudyStep>& steps);
  std::int64_t rest = 1, stride = 1, samples = 0;
  double rest_s(const Scenario& scenario) const;
  double duration_s(const Scenario& scenario) const;  ///< of the motion
};

/// How the scene is stepped in one cell.
struct StudyRun {
  SolverKind solver = SolverKind::cpu_double;
  Method method = Method::rk4;
  int iterations = 0;
  StudyStep step;
};
/// Throws SolverError. `measured`: with the energy.
std::unique_ptr<Solver> make_study_solver(const Scenario& scenario, const StudyRun& run, bool measured);

/// What is compared, at the samples.
struct StudyTrace {
  std::vector<std::vector<glm::dvec3>> displacement_m;     // samples x particles
  std::vector<std::array<glm::dvec3, kMaxTools>> force_N;  // samples
  std::vector<double> energy_J;                            // samples
  std::int64_t first_bad_sample = -1;                      // a value is not finite; the trace ends before it
};
StudyTrace trace_of(Solver& solver, const Scenario& scenario, const StudyPlan& plan, StudyStep step);
/// The same steps, nothing read but the forces.
void step_through(Solver& solver, const Scenario& scenario, const StudyPlan& plan, StudyStep step);

/// Rms per quantity of a - b, in the quantities' SI units; of a where b is nullptr.
StudyValues rms(const StudyTrace& a, const StudyTrace* b);
/// The same as the cells' errors: force and energy over `scale`.
StudyValues error_of(const StudyTrace& a, const StudyTrace& reference, const StudyValues& scale);

struct StudyReferenceRun {
  StudyTrace trace;
  StudyReference info;
};
/// Throws RunFailure. `finest`: substeps per step of the scene in the finest cell; the reference is finer.
StudyReferenceRun solve_reference(const Scenario& scenario, const StudyPlan& plan, int finest);

}  // namespace evenstep::internal
