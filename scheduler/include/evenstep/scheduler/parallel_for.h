#pragma once
/// Runs independent pieces of work on several threads.

#include <cstddef>
#include <functional>
#include <string>

namespace evenstep {

/// Calls body(0) .. body(count - 1), each once, on up to `threads` threads (0: one per core). If any of them throw, the
/// exception of the lowest index is rethrown after all have ended, so it does not depend on the number of threads.
void parallel_for(std::size_t count, int threads, const std::function<void(std::size_t)>& body);

/// Calls make(0) .. make(count - 1) on up to `threads` threads (0: one per core), and passes each result to take(), in order
/// of index and one at a time, until take() returns false. Then, or if a call throws (rethrown), results that are still
/// being made are dropped.
void ordered_for(std::size_t count, int threads, const std::function<std::string(std::size_t)>& make,
                 const std::function<bool(std::size_t, const std::string&)>& take);

}  // namespace evenstep
