#include "evenstep/reports/rate_bound.h"

#include <boost/math/special_functions/beta.hpp>

namespace evenstep {

double rate_at_most(std::int64_t hits, std::int64_t runs, double confidence) {
  if (hits >= runs) return 1;
  return boost::math::ibeta_inv(static_cast<double>(hits + 1), static_cast<double>(runs - hits), confidence);
}

}  // namespace evenstep
