#include "swarm.h"

#include "evenstep/scheduler/random.h"

namespace evenstep::internal {

std::vector<std::string> faults_on(const std::vector<std::string>& faults, std::uint64_t seed) {
  std::vector<std::string> on;
  for (const std::string& fault : faults) {
    if (RandomStream(seed, "swarm." + fault).below(0, 2) == 1) on.push_back(fault);
  }
  return on;
}

}  // namespace evenstep::internal
