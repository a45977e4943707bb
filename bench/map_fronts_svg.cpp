#include "map_fronts_svg.h"

namespace evenstep::bench {
std::string fronts_svg(const std::vector<Fronts>&) { return ""; }
}  // namespace evenstep::bench
