// evenstep devices
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "commands.h"
#include "evenstep/device/haptic_device.h"
#include "evenstep/device/hid/hidapi_transport.h"
#include "evenstep/device/hid/pid_axes.h"
#include "evenstep/device/hid/pid_layout.h"
#include "evenstep/device/hid/reference_device.h"
#include "evenstep/device/hid/report_descriptor.h"

namespace evenstep::app {
namespace {

struct DevicesArguments {
  bool json = false;
};

/// What evenstep can do with a device.
struct Ability {
  std::string kind;  ///< "reference", "pid" or "none"
  std::string text;
};

std::string pid_ability(const PidLayout& layout) {
  std::string positions, forces;
  const auto has_force = pid_force_axes(layout);
  for (std::size_t axis = 0; axis < pid::kAxes; ++axis) {
    if (layout.position[axis]) positions += "XYZ"[axis];
    if (layout.position[axis] && has_force[axis]) forces += "XYZ"[axis];
  }
  const auto or_none = [](const std::string& axes) { return axes.empty() ? "no axis" : axes; };
  std::string text = fmt::format("force feedback of the PID class: reads {}, renders constant forces", or_none(positions));
  if (layout.set_condition && layout.set_effect.spring) text += " and springs";
  text += fmt::format(" along {}; driver = \"pid\" with its travel and its full scale in newtons", or_none(forces));
  if (!layout.state) text += "; it does not say whether its motors are on";
  return text;
}

Ability ability_of(const HidListing& listing) {
  const HidDeviceInfo& info = listing.info;
  if (info.vendor_id == reference_device::kVendorId && info.product_id == reference_device::kProductId)
    return {"reference", "reads 3 positions, renders 3 forces (reference device)"};
  const auto parsed = parse_report_descriptor(listing.report_descriptor);
  if (!parsed)
    return {"none", fmt::format("byte {} of its report descriptor: {}", parsed.error().offset, parsed.error().message)};
  const auto layout = pid_layout(*parsed);
  if (layout) return {"pid", pid_ability(*layout)};
  const auto is_of_pid = [&](const HidField& field) {
    return parsed->enclosing(field, 1) >> 16 == 0x0F || field.usages[0] >> 16 == 0x0F;
  };
  if (std::none_of(parsed->fields.begin(), parsed->fields.end(), is_of_pid)) return {"none", "not a force-feedback device"};
  return {"none", fmt::format("force feedback of the PID class, but without {}", fmt::join(layout.error(), ", "))};
}

void print_listing(const HidListing& listing) {
  const HidDeviceInfo& info = listing.info;
  fmt::print("{}  {:04x}:{:04x}  {}{}\n", info.path, info.vendor_id, info.product_id,
             info.product.empty() ? "(no name)" : info.product, info.serial.empty() ? "" : "  serial " + info.serial);
  fmt::print("    {}\n", ability_of(listing).text);
  if (!listing.force_feedback_node.empty())
    fmt::print("    the kernel's force-feedback driver holds it, too: {}\n", listing.force_feedback_node);
  if (listing.refusal.empty()) return;
  fmt::print(
      "    cannot be opened: {}. Paste this line into /etc/udev/rules.d/70-evenstep.rules, then plug it in again:\n"
      "      {}\n",
      listing.refusal, udev_rule(info));
}

nlohmann::ordered_json json_of(const HidListing& listing) {
  const HidDeviceInfo& info = listing.info;
  const Ability ability = ability_of(listing);
  return {{"path", info.path},
          {"vendor_id", info.vendor_id},
          {"product_id", info.product_id},
          {"product", info.product},
          {"serial", info.serial},
          {"driver", ability.kind},
          {"ability", ability.text},
          {"refusal", listing.refusal},
          {"udev_rule", udev_rule(info)},
          {"force_feedback_node", listing.force_feedback_node}};
}

ExitCode devices(const DevicesArguments& arguments, const std::atomic<bool>&) {
  std::vector<HidListing> found;
  try {
    found = hid_devices();
  } catch (const DeviceError& error) {
    spdlog::error("error: {}", error.what());
    return ExitCode::run_failed;
  }
  if (arguments.json) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const HidListing& listing : found) list.push_back(json_of(listing));
    // The strings of a device may be anything; if they are not UTF-8, the list must be printed nevertheless.
    fmt::print("{}\n", list.dump(1, ' ', false, nlohmann::json::error_handler_t::replace));
    return ExitCode::pass;
  }
  for (const HidListing& listing : found) print_listing(listing);
  if (found.empty()) fmt::print("no HID device is connected (or /sys is not there)\n");
  return ExitCode::pass;
}

}  // namespace

void add_devices(Commands& commands) {
  auto [command, arguments] =
      commands.add<DevicesArguments>("devices", "the HID devices of this machine, and what each of them can do", devices);
  command.flag("--json", arguments.json, "the list as JSON instead of text");
}

}  // namespace evenstep::app
