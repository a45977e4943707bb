// The closed loop on a lattice: along one axis the law of one spring, two hands, contact that is made, slides and is left.

#include <fmt/format.h>

#include <cmath>

#include "../../../harness/scenarios.h"
#include "evenstep/campaigns/stiffness_limit.h"
#include "scenarios.h"
