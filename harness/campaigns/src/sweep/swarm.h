#pragma once
/// Swarm testing (A. Groce, C. Zhang, E. Eide, Y. Chen, J. Regehr, "Swarm Testing", ISSTA 2012): each test leaves out a
/// random part of what could happen. A fault that is always there can hide the effect of another one: a stall that empties
/// every buffer hides what a lost report does to a full buffer. Random subsets have each pair in all four combinations.

#include <cstdint>
#include <string>
#include <vector>

namespace evenstep::internal {

/// The faults that stay on with this seed, in their order: each with probability 1/2, by a stream of its own, so that adding
/// a fault to a scenario changes no draw of the others.
std::vector<std::string> faults_on(const std::vector<std::string>& faults, std::uint64_t seed);

}  // namespace evenstep::internal
