#pragma once
/// The tie order: which of two events on the same nanosecond happens first. It is defined only here.
///
///   completion < device < launch, then the order in which they were asked for.
///
/// So a step that finishes at the instant of a device tick is seen by that tick, and a step launched on a tick sees that
/// tick's sample. `--permute-ties` shuffles only the order in which events were asked for.

#include <cstdint>

namespace evenstep {

enum class Lane : std::uint8_t { completion = 0, device = 1, launch = 2 };

constexpr const char* lane_name(Lane lane) {
  switch (lane) {
    case Lane::completion:
      return "completion";
    case Lane::device:
      return "device";
    case Lane::launch:
      return "launch";
  }
  return "unknown";
}

}  // namespace evenstep
