#pragma once
/// One cell of a case: a scene, what the hands do, and what the exact answer is. A kind of case makes them; run_trial.h
/// runs them.

#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "evenstep/catalogue/case_spec.h"
#include "evenstep/reports/case_record.h"
#include "evenstep/sim/solver.h"

namespace evenstep::internal {

class Trial {
 public:
  virtual ~Trial() = default;
  Scene scene;
  std::int64_t steps = 1;
  std::int64_t observe_every = 1;  ///< steps; the last one is always observed
  /// Positions of the tools at the end of step n: a function of n alone, so that no schedule can change them.
  virtual void hands(std::int64_t, std::span<glm::dvec3>) const {}
  /// After `steps` steps. False: it has diverged, and the run ends here.
  virtual bool observe(std::int64_t steps, const ToolResponse& response, Solver& solver) = 0;
  /// Status, number shown and metrics of a run that came to its end.
  virtual void judge(Solver& solver, CaseCell& cell) = 0;
};

/// What a cell is made from.
struct CellSpec {
  const CaseSpec& spec;
  double value = 0;
  Method method = Method::symplectic_euler;
  SolverKind solver = SolverKind::cpu_double;
  bool is_float() const { return solver != SolverKind::cpu_double; }
};

struct CaseKind {
  std::string_view name;        ///< as in [case] kind
  std::string_view value_name, value_unit;
  std::unique_ptr<Trial> (*make)(const CellSpec& cell);
  /// What can be said only of neighbouring cells, as the order of convergence. May be nullptr.
  void (*compare)(std::span<CaseCell> cells) = nullptr;
};
const std::vector<CaseKind>& case_kinds();

}  // namespace evenstep::internal
