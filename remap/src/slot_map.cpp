#include "evenstep/remap/slot_map.h"

#include <cassert>

namespace evenstep {

Slot SlotMap::read(std::int64_t n, RealTime began, Duration postponed) {
  assert(n == next_step_ && !step_open_ && "read(n) comes once per step, in order, after emission(n - 1)");
  step_open_ = true;
  this->began(n, began - postponed);
  const std::optional<RealTime> at = slot(n);
  current_ = at ? Slot{*at - lead_, SlotKind::mapped} : Slot{began, unmapped_kind()};
  return current_;
}

RealTime SlotMap::emission(std::int64_t n, RealTime ended, Duration postponed) {
  assert(n == next_step_ && step_open_ && "emission(n) follows read(n)");
  step_open_ = false;
  ++next_step_;
  this->ended(n, ended - postponed);
  return current_.kind == SlotKind::mapped ? latency_.emission(current_.read, ended) : latency_.emission(ended);
}

}  // namespace evenstep
