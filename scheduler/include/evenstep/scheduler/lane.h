#pragma once
/// The tie order: the one place that says what happens first when two events fall on the same nanosecond.
///
///   completion < device < launch, then the order in which they were asked for.
///
/// A finished step is heard before the device tick of that instant, and a step launched on a tick sees that tick's
/// sample. `--permute-ties` shuffles only the last rule.

#include <cstdint>

namespace evenstep {

enum class Lane : std::uint8_t { completion = 0, device = 1, launch = 2 };

constexpr const char* lane_name(Lane lane) {
  switch (lane) {
    case Lane::completion: return "completion";
    case Lane::device: return "device";
    case Lane::launch: return "launch";
  }
  return "unknown";
}

}  // namespace evenstep
