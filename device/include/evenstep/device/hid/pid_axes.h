#pragma once
/// Along which axes a PID device has a force, by its report descriptor: those that Axes Enable lists (on a wheel X alone,
/// and Y is a pedal); if it has no Axes Enable, X and Y where an effect has a direction, otherwise X.

#include <array>

#include "evenstep/device/hid/pid_layout.h"

namespace evenstep {

std::array<bool, pid::kAxes> pid_force_axes(const PidLayout& layout);

}  // namespace evenstep
