#pragma once
/// Independent runs side by side.

#include <cstddef>
#include <functional>

namespace evenstep::internal {

/// Calls body(0) .. body(count - 1), each once, on up to `threads` threads (0: one per core). Rethrows the exception of the
/// lowest index that threw, after all have ended: what is reported does not depend on the number of threads.
void parallel_for(std::size_t count, int threads, const std::function<void(std::size_t)>& body);

}  // namespace evenstep::internal
