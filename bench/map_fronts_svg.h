#pragma once
/// The figure of bench_map_fronts: a panel per recording, least latency against velocity jump.

#include <string>
#include <vector>

namespace evenstep::bench {

/// A point of a map at one bandwidth, or of any path, which has no bandwidth.
struct FrontPoint {
  double bandwidth_Hz = 0;
  double jump = 0;  ///< the largest jump, in mean slots
  double latency_ms = 0;
};
struct MapFront {
  std::string name;
  std::vector<FrontPoint> points;
};
inline const FrontPoint& at_bandwidth(const MapFront& map, double bandwidth_Hz) {
  std::size_t i = 0;
  while (map.points[i].bandwidth_Hz != bandwidth_Hz) ++i;
  return map.points[i];
}

struct Fronts {
  std::string recording;
  double best_line_ms = 0, pause_ms = 0;
  std::vector<FrontPoint> any_path;  ///< in the order of rising jumps
  std::vector<MapFront> maps;
};

std::string fronts_svg(const std::vector<Fronts>& all);

}  // namespace evenstep::bench
