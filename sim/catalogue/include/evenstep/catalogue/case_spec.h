#pragma once
/// The contents of a scenario's [case]: an entry of the catalogue of stiff and extreme cases, and the values it is run over.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/sim/scene.h"
#include "evenstep/time/time.h"

namespace evenstep {

/// An entry of the catalogue. It drives the solver itself, with every method and solver, for every value. Members that its
/// kind does not use keep these defaults.
struct CaseSpec {
  std::string kind;
  std::vector<Method> methods;
  std::vector<SolverKind> solvers;
  std::vector<double> values;  ///< strictly rising; their meaning depends on the kind
  double periods = 0;
  std::int64_t most_steps = 0;
  double duration_s = 0;  ///< of simulation time
  std::int64_t particles = 0;
  Duration step_size;
  int iterations = 0;  ///< for methods that iterate; 0: their default
  bool allow_unstable = false;
  /// A solver that the program has registered. It runs instead of `solvers`, which then holds only the one that computes in
  /// double. `methods` are then the methods that it claims to implement: its results are compared with their closed forms.
  std::optional<ForeignScene> foreign;

  /// The solvers of a method's rows, in their order.
  std::vector<std::string> solver_names() const {
    if (foreign) return {foreign->name};
    std::vector<std::string> names;
    for (const SolverKind solver : solvers) names.emplace_back(name_of(solver));
    return names;
  }
};

}  // namespace evenstep
