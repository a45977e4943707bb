// The closed loop on a lattice: along one axis it follows the law of one spring; two hands; contact that begins, slides and
// ends.

#include <fmt/format.h>

#include <cmath>

#include "../../../harness/scenarios.h"
#include "evenstep/campaigns/stiffness_limit.h"
#include "scenarios.h"
