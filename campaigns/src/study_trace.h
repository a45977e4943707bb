#pragma once
/// One run of a study's scene: the same instants and the same motion for every step, method and solver.

#include <array>
#include <glm/vec3.hpp>
#include <vector>

#include "evenstep/format/scenario.h"
#include "evenstep/reports/study_record.h"
#include "evenstep/sim/solver.h"

namespace evenstep::internal {

inline constexpr std::int64_t kMostStudySamples = 64;

/// The steps of the scene: first `rest` steps with the tools at rest (a solver takes the first position of a tool as its
/// origin), then `samples` times `stride` steps along the motion. The steps of all cells end together at each sample.
struct StudyPlan {
  StudyPlan(const Scenario& scenario, const std::vector<StudyStep>& steps);
  std::int64_t rest = 1, stride = 1, samples = 0;
  double rest_s(const Scenario& scenario) const;
  double duration_s(const Scenario& scenario) const;  ///< duration of the motion
};

/// How the scene is stepped in one cell.
struct StudyRun {
  SolverKind solver = SolverKind::cpu_double;
  Method method = Method::rk4;
  int iterations = 0;
  StudyStep step;
};
/// Throws SolverError. `measured`: the solver also computes the energy.
std::unique_ptr<Solver> make_study_solver(const Scenario& scenario, const StudyRun& run, bool measured);

/// The values at the samples that are compared.
struct StudyTrace {
  std::vector<std::vector<glm::dvec3>> displacement_m;     // samples x particles
  std::vector<std::array<glm::dvec3, kMaxTools>> force_N;  // samples
  std::vector<double> energy_J;                            // samples
  std::int64_t first_bad_sample = -1;                      // first with a value that is not finite; the trace ends before
};
StudyTrace trace_of(Solver& solver, const Scenario& scenario, const StudyPlan& plan, StudyStep step);
/// The same steps, but only the forces are read.
void step_through(Solver& solver, const Scenario& scenario, const StudyPlan& plan, StudyStep step);

/// The rms of a - b for each quantity, in its SI unit; that of a if b is nullptr.
StudyValues rms(const StudyTrace& a, const StudyTrace* b);
/// The errors of a cell: the rms, with force and energy divided by `scale`.
StudyValues error_of(const StudyTrace& a, const StudyTrace& reference, const StudyValues& scale);

struct StudyReferenceRun {
  StudyTrace trace;
  StudyReference info;
};
/// Throws RunFailure. `finest`: substeps per step of the scene in the finest cell; the reference is finer.
StudyReferenceRun solve_reference(const Scenario& scenario, const StudyPlan& plan, int finest);

}  // namespace evenstep::internal
