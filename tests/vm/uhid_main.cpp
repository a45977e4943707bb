#include "skipping_main.h"
#include "uhid_device.h"

std::string why_all_are_skipped() {
  const std::string refusal = UhidDevice::refusal();
  return refusal.empty() ? "" : refusal + " (the vm_ tests run the same on a kernel of their own)";
}
