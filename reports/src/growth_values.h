#pragma once
/// The growth of each error of a signal, from its bins.

#include <map>
#include <string>
#include <vector>

#include "evenstep/reports/growth.h"
#include "evenstep/reports/measures.h"

namespace evenstep::internal {

/// The curves of a fit depend only on the times of the bins, which most signals of a run have in common.
using GrowthFits = std::map<std::vector<double>, GrowthFit>;

/// "<error>_growth" and "<error>_growth_min" of each error that could be fitted.
std::map<std::string, double> growth_values(const std::vector<BinRow>& rows, GrowthFits& fits);

}  // namespace evenstep::internal
