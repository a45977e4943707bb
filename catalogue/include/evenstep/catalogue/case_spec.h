#pragma once
/// The contents of a scenario's [case]: an entry of the catalogue of stiff and extreme cases, and the values it is run over.

#include <cstdint>
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
};

}  // namespace evenstep
