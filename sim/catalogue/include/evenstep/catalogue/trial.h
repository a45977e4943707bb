#pragma once
/// One cell of a case: a scene, the motion of the hands, and the exact answer. Kinds of cases make trials; run_trial.h runs
/// them.

#include <atomic>
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
  std::int64_t observe_every = 1;  ///< observe() is called every so many steps, and always after the last one
  /// The positions of the tools at the end of step n. They depend on nothing but n, so no schedule can change them.
  virtual void hands(std::int64_t, std::span<glm::dvec3>) const {}
  /// Called after `steps` steps. Returns false if the run has diverged; it then ends.
  virtual bool observe(std::int64_t steps, const ToolResponse& response, Solver& solver) = 0;
  /// Sets status, number shown and metrics after a complete run.
  virtual void judge(Solver& solver, CaseCell& cell) = 0;
};

/// What determines a cell.
struct CellSpec {
  const CaseSpec& spec;
  double value = 0;
  Method method = Method::symplectic_euler;
  SolverKind solver = SolverKind::cpu_double;
  const std::atomic<bool>* interrupted = nullptr;  ///< set by run_cell(); what takes long to make stops early then
  bool is_float() const { return solver != SolverKind::cpu_double; }
};

struct CaseKind {
  std::string_view name;  ///< as in [case] kind
  std::string_view value_name, value_unit;
  std::unique_ptr<Trial> (*make)(const CellSpec& cell);
  /// Computes what needs neighbouring cells, such as the order of convergence. May be nullptr.
  void (*compare)(std::span<CaseCell> cells) = nullptr;
};
const std::vector<CaseKind>& case_kinds();

}  // namespace evenstep::internal
