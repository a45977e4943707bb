#pragma once
/// What goes over the pipes of a process solver, as bytes (docs/parts/process-protocol.md).

#include <string>
#include <string_view>
#include <vector>

#include "evenstep/sim/foreign_solver.h"
#include "evenstep/time/result.h"

namespace evenstep::internal {

inline constexpr int kProcessProtocol = 1;
inline constexpr std::size_t kLongestGreeting = 4096;  // bytes, with its line end

/// The line, with its end, that the process is sent first.
std::string greeting(const SolverRequest& request);
/// The capabilities in the line that it answers with; without `particles`, for which the protocol has no record.
Result<SolverCapabilities, std::string> read_greeting(std::string_view line);

enum class RequestKind : std::uint32_t { step = 1, reset = 2 };
/// `n` and `positions_m` are of a step; a reset has n = 0.
std::string request_record(RequestKind kind, std::uint64_t n, double step_s, std::span<const glm::dvec3> positions_m);

/// The other parts of an answer are as in plugin.h.
struct ProcessAnswer {
  std::uint32_t status = 0;
  std::uint64_t state_digest = 0;
  double energy_J = 0;
  ToolResponse response;
  std::vector<ToolContact> contacts;  ///< one per tool if the solver has them
};
std::size_t answer_size(std::size_t tools, bool contacts);
/// `bytes` has answer_size bytes. The error says what is wrong with the first 16: the answer belongs to another request.
Result<ProcessAnswer, std::string> read_answer(std::string_view bytes, std::size_t tools, bool contacts, RequestKind kind,
                                               std::uint64_t n);

}  // namespace evenstep::internal
