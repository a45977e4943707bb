#pragma once
/// What a [case] asks for: an entry of the catalogue of stiff and extreme cases, and the values it is run over.

#include <cstdint>
#include <string>
#include <vector>

#include "evenstep/sim/scene.h"
#include "evenstep/time/time.h"

namespace evenstep {

/// [case]: an entry of the catalogue of stiff and extreme cases. It drives the solver itself, for every method and solver over
/// every value. What its kind has no use for keeps the value here.
struct CaseSpec {
  std::string kind;
  std::vector<Method> methods;
  std::vector<SolverKind> solvers;
  std::vector<double> values;                   ///< strictly rising; what they are is up to the kind
  double periods = 0;
  std::int64_t most_steps = 0;
  double duration_s = 0;                        ///< of simulation time
  std::int64_t particles = 0;
  Duration step_size;
  int iterations = 0;                           ///< of methods that iterate; 0: their default
  bool allow_unstable = false;
};

}  // namespace evenstep
