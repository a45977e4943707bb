#include "search.h"

#include <algorithm>
#include <numeric>

namespace evenstep::internal {
namespace {

using Set = std::vector<std::size_t>;

/// Piece `i` of `n` nearly equal pieces; without_piece is the set without it.
Set piece(const Set& set, std::size_t i, std::size_t n) {
  return {set.begin() + static_cast<std::ptrdiff_t>(i * set.size() / n),
          set.begin() + static_cast<std::ptrdiff_t>((i + 1) * set.size() / n)};
}
Set without_piece(const Set& set, std::size_t i, std::size_t n) {
  Set rest(set.begin(), set.begin() + static_cast<std::ptrdiff_t>(i * set.size() / n));
  rest.insert(rest.end(), set.begin() + static_cast<std::ptrdiff_t>((i + 1) * set.size() / n), set.end());
  return rest;
}

}  // namespace

std::vector<std::size_t> fewest(std::size_t count, const Fails& fails, const std::function<bool()>& go_on) {
  Set set(count);
  std::iota(set.begin(), set.end(), std::size_t{0});
  if (count == 0 || fails({})) return {};
  std::size_t n = 2;
  const auto smaller = [&](Set (*part)(const Set&, std::size_t, std::size_t)) {
    for (std::size_t i = 0; i < n && go_on(); ++i) {
      Set candidate = part(set, i, n);
      if (!fails(candidate)) continue;
      set = std::move(candidate);
      return true;
    }
    return false;
  };
  while (set.size() > 1 && go_on()) {
    n = std::min(n, set.size());
    if (smaller(piece)) {
      n = 2;
    } else if (n > 2 && smaller(without_piece)) {  // of two pieces, each is the other's rest
      n = std::max<std::size_t>(n - 1, 2);
    } else if (n < set.size()) {
      n = std::min(2 * n, set.size());
    } else {
      break;
    }
  }
  return set;
}

std::int64_t smallest(std::int64_t passing, std::int64_t failing, const std::function<bool(std::int64_t)>& fails,
                      const std::function<bool()>& go_on) {
  while (std::abs(failing - passing) > 1 && go_on()) {
    const std::int64_t middle = passing + (failing - passing) / 2;
    (fails(middle) ? failing : passing) = middle;
  }
  return failing;
}

}  // namespace evenstep::internal
