#include "evenstep/text/rational.h"

namespace evenstep::internal {

Rate reduced_rate(__int128 num, __int128 den) {
  // Convergents p/q of num/den; the last one is num/den itself in lowest terms.
  __int128 p_before = 0, q_before = 1, p = 1, q = 0;
  while (den != 0) {
    const __int128 whole = num / den;
    const __int128 p_next = whole * p + p_before, q_next = whole * q + q_before;
    if (q_next > kMostRateDen) break;
    p_before = p;
    q_before = q;
    p = p_next;
    q = q_next;
    const __int128 rest = num % den;
    num = den;
    den = rest;
  }
  return {static_cast<std::int64_t>(p), static_cast<std::int64_t>(q)};
}

}  // namespace evenstep::internal
