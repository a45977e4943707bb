#pragma once
/// One run of a study's scene: the same instants and the same motion for every step, method and solver.

#include <array>
#include <atomic>
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
/// Throws SolverError. `measured`: the solver also computes the energy. A scene that is no tissue takes from `run` the
/// solver and the length of its steps, a foreign scene its substeps.
std::unique_ptr<Solver> make_study_solver(const Scenario& scenario, const StudyRun& run, bool measured);

/// The values at the samples that are compared.
struct StudyTrace {
  std::vector<std::vector<glm::dvec3>> displacement_m;     // samples x particles
  std::vector<std::array<glm::dvec3, kMaxTools>> force_N;  // samples
  std::vector<double> energy_J;                            // samples
  std::int64_t first_bad_sample = -1;                      // first with a value that is not finite; the trace ends before
};
/// What a study throws between two steps once its `interrupted` is set. A reference can take minutes.
struct StudyInterrupted {};
/// Throws StudyInterrupted; without `interrupted` nothing ends it early.
StudyTrace trace_of(Solver& solver, const Scenario& scenario, const StudyPlan& plan, StudyStep step,
                    const std::atomic<bool>* interrupted = nullptr);
/// The same steps, but only the forces are read.
void step_through(Solver& solver, const Scenario& scenario, const StudyPlan& plan, StudyStep step,
                  const std::atomic<bool>* interrupted);

/// The rms of a - b for each quantity, in its SI unit; that of a if b is nullptr.
StudyValues rms(const StudyTrace& a, const StudyTrace* b);
/// The errors of a cell: the rms, with force and energy divided by `scale`.
StudyValues error_of(const StudyTrace& a, const StudyTrace& reference, const StudyValues& scale);

struct StudyReferenceRun {
  StudyTrace trace;
  StudyReference info;
};
/// A method of references. The substep of the coarsest of its three runs is at most the method's limit / `limit_parts`,
/// where the method shows its order.
struct ReferenceMethod {
  Method method;
  int order;
  int limit_parts;
};
/// Explicit ones, the most accurate first.
inline constexpr std::array kReferenceMethods{ReferenceMethod{Method::rk4, 4, 8},
                                              ReferenceMethod{Method::velocity_verlet, 2, 16},
                                              ReferenceMethod{Method::symplectic_euler, 1, 32}};
/// The errors of the extrapolations fall by 2^q from one to the next, so the error of the last one is their difference
/// divided by 2^q - 1. That is at most twice the difference for q >= 0.6. A smooth motion has q > order, a contact that
/// opens or closes about 1.
inline constexpr double kReferenceSafety = 2;
/// The substeps of the coarsest run per step of the scene; the finest has four times as many. Throws RunFailure.
int coarsest_substeps(const Scenario& scenario, const ReferenceMethod& method, int finest_cell);

/// Throws RunFailure and StudyInterrupted. `finest`: substeps per step of the scene in the finest cell; the reference is
/// finer.
StudyReferenceRun solve_reference(const Scenario& scenario, const StudyPlan& plan, int finest,
                                  const std::atomic<bool>* interrupted = nullptr);

}  // namespace evenstep::internal
