#pragma once
/// Independent runs side by side.

#include <cstddef>
#include <functional>
#include <string>

namespace evenstep {

/// Calls body(0) .. body(count - 1), each once, on up to `threads` threads (0: one per core). Rethrows the exception of the
/// lowest index that threw, after all have ended: what is reported does not depend on the number of threads.
void parallel_for(std::size_t count, int threads, const std::function<void(std::size_t)>& body);

/// make(0) .. make(count - 1) on up to `threads` threads (0: one per core), and each result to take(), in order of index and
/// one at a time, until it returns false. Then, or after an exception of either (rethrown), what is being made is dropped.
void ordered_for(std::size_t count, int threads, const std::function<std::string(std::size_t)>& make,
                 const std::function<bool(std::size_t, const std::string&)>& take);

}  // namespace evenstep
