#pragma once
/// The reference of a felt-force study: the force that the scene gives for the programmed motions without any delay, at the
/// accuracy of a Richardson extrapolation in double; and the file in which it is kept.

#include <functional>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "evenstep/format/scenario.h"
#include "evenstep/harness/strategy_run.h"
#include "evenstep/reports/felt_study_record.h"
#include "runs.h"

namespace evenstep::internal {

/// Cubic through the four nearest instants.
struct FeltReference {
  EvenForces forces;
  FeltReferenceInfo info;  ///< but for its scale, which is that of the judged ticks
  glm::dvec3 at_N(std::size_t tool, double t_s) const;
};

/// How the reference of a scenario is computed. A tissue: three runs of the most accurate explicit method that can compute
/// it, on steps of `rate` cut into 1, 2 and 4 parts. Other scenes have no step to cut: one run on steps of `rate`.
struct ReferencePlan {
  Rate rate;
  RealTime until;
  Method method = Method::rk4;
  int order = 0;  ///< of the method; 0: not a tissue
};
/// `finest`: the substeps per step of the scene in the finest cell; the reference is finer. Throws RunFailure.
ReferencePlan plan_reference(const Scenario& scenario, int finest);
std::unique_ptr<Solver> make_reference_solver(const Scenario& scenario, const ReferencePlan& plan, int parts);

/// Everything that the reference depends on, as lines of text: version, plan, scene, and a digest of the positions of the
/// hands at the reference's instants.
std::string reference_key(const Scenario& scenario, const ReferencePlan& plan);
/// The file for a key; its name has the digest of the key.
std::string reference_file(const std::string& folder, const std::string& key);

/// Reads a file. Returns false if there is none. If there is one that cannot be used, says why in `objection`.
bool read_reference(const std::string& file, const std::string& key, FeltReference& reference, std::string& objection);
/// Writes it under another name and renames it. Returns what went wrong; empty if nothing did.
std::string write_reference(const std::string& file, const std::string& key, const FeltReference& reference);

/// Throws RunFailure.
FeltReference solve_felt_reference(const Scenario& scenario, const ReferencePlan& plan, const RunControl& control);

}  // namespace evenstep::internal
