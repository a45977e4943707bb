#pragma once
/// Delta debugging, whatever is shrunk.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace evenstep::internal {

/// Whether what is kept still fails.
using Fails = std::function<bool(const std::vector<std::size_t>&)>;

/// ddmin: of 0 .. count - 1, which fail together, a subset that fails and of which no single one can be left out. In rising
/// order; empty if nothing is needed to fail. `go_on` false ends the search with the smallest set so far.
std::vector<std::size_t> fewest(std::size_t count, const Fails& fails, const std::function<bool()>& go_on);

/// The least whole number in (passing, failing] for which `fails`, if it fails from there on; `failing` is known to. The
/// same with both negative, towards `passing`.
std::int64_t smallest(std::int64_t passing, std::int64_t failing, const std::function<bool(std::int64_t)>& fails,
                      const std::function<bool()>& go_on);

}  // namespace evenstep::internal
