#pragma once
/// Delta debugging, independent of what is shrunk.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace evenstep::internal {

/// Whether the subset that is kept still fails.
using Fails = std::function<bool(const std::vector<std::size_t>&)>;

/// ddmin: from 0 .. count - 1, which fail together, finds a subset that fails and of which no single element can be left
/// out. In rising order; empty if it fails even with nothing. When `go_on` returns false, the search ends with the smallest
/// set so far.
std::vector<std::size_t> fewest(std::size_t count, const Fails& fails, const std::function<bool()>& go_on);

/// The least whole number in (passing, failing] that fails, provided that all above it fail as well; `failing` is known to
/// fail. With both negative it is the one nearest to `passing`.
std::int64_t smallest(std::int64_t passing, std::int64_t failing, const std::function<bool(std::int64_t)>& fails,
                      const std::function<bool()>& go_on);

}  // namespace evenstep::internal
