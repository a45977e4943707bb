// evenstep devices
#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11
#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "evenstep/device/evdev/evdev_file.h"
#include "evenstep/device/haptic_device.h"
#include "evenstep/device/hid/hidapi_transport.h"
#include "evenstep/device/hid/pid_axes.h"
#include "evenstep/device/hid/pid_layout.h"
#include "evenstep/device/hid/reference_device.h"
#include "evenstep/device/hid/report_descriptor.h"
#include "evenstep/device/inverse3/inverse3_socket.h"
#include "evenstep/time/build_option.h"
#include "src/commands.h"
#include "src/opencl_lines.h"

namespace evenstep::app {
namespace {

struct DevicesArguments {
  bool json = false, opencl = false, check = false;
  std::string service;  ///< empty: kUsualService, which is not mentioned if it is not there
};

constexpr const char* kUsualService = "ws://127.0.0.1:10001";

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
  if (forces == "X") text += " (of a wheel, with wheel = { turn, radius, torque })";
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

/// The evdev device that the kernel's driver made of a HID device; nullptr if there is none.
const EvdevListing* evdev_of(const HidListing& listing, const std::vector<EvdevListing>& evdev) {
  const auto is_it = [&](const EvdevListing& one) { return one.info.path == listing.force_feedback_node; };
  const auto found = std::find_if(evdev.begin(), evdev.end(), is_it);
  return found == evdev.end() ? nullptr : &*found;
}

std::string evdev_ability(const EvdevListing& listing) {
  std::string positions, forces;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!listing.has_axis[axis]) continue;
    positions += "XYZ"[axis];
    if (axis < 2 && listing.constant) forces += "XYZ"[axis];
  }
  const auto or_none = [](const std::string& axes) { return axes.empty() ? "no axis" : axes; };
  return fmt::format(
      "force feedback by the kernel's driver: reads {}, renders constant forces{} along {}; driver = \"evdev\" with its "
      "travel and its full scale in newtons; it does not say whether its motors are on",
      or_none(positions), listing.spring ? " and springs" : "", or_none(forces));
}

/// Which of a device's two drivers to use, and why. `pid` is the more direct one: it knows what was refused and which switch
/// is open, and its newest force overtakes those that wait.
std::string advice(const HidListing& listing, const EvdevListing& evdev) {
  const std::string kind = ability_of(listing).kind;
  if (!evdev.constant) return "neither its evdev node, which plays no constant forces, nor what evenstep has for it";
  if (kind != "pid")
    return fmt::format("{} with driver = \"evdev\": evenstep itself cannot drive its reports", evdev.info.path);
  if (!listing.refusal.empty() && evdev.refusal.empty())
    return fmt::format("{} with driver = \"evdev\", since only that may be opened", evdev.info.path);
  return fmt::format(
      "{} with driver = \"pid\": a refused force is sent again and an open switch is seen; \"evdev\" if that fails, or to "
      "have the kernel erase the effects when evenstep is killed",
      listing.info.path);
}

void print_refusal(const std::string& refusal, const std::string& rule) {
  if (refusal.empty()) return;
  fmt::print(
      "    cannot be opened: {}. Paste this line into /etc/udev/rules.d/70-evenstep.rules, then plug it in again:\n"
      "      {}\n",
      refusal, rule);
}

std::string udev_rule_of(const EvdevListing& listing) {
  return fmt::format(
      "SUBSYSTEM==\"input\", KERNEL==\"event*\", ATTRS{{id/vendor}}==\"{:04x}\", ATTRS{{id/product}}==\"{:04x}\", "
      "TAG+=\"uaccess\"",
      listing.info.vendor_id, listing.info.product_id);
}

void print_listing(const HidListing& listing, const EvdevListing* evdev) {
  const HidDeviceInfo& info = listing.info;
  fmt::print("{}  {:04x}:{:04x}  {}{}\n", info.path, info.vendor_id, info.product_id,
             info.product.empty() ? "(no name)" : info.product, info.serial.empty() ? "" : "  serial " + info.serial);
  fmt::print("    {}\n", ability_of(listing).text);
  if (!listing.force_feedback_node.empty())
    fmt::print("    the kernel's force-feedback driver holds it, too: {}\n", listing.force_feedback_node);
  print_refusal(listing.refusal, udev_rule(info));
  if (!evdev) return;
  fmt::print("    {}: {}\n", evdev->info.path, evdev_ability(*evdev));
  print_refusal(evdev->refusal, udev_rule_of(*evdev));
  fmt::print("    use {}\n", advice(listing, *evdev));
}

void print_listing(const EvdevListing& listing) {
  fmt::print("{}  {:04x}:{:04x}  {}\n    {}\n", listing.info.path, listing.info.vendor_id, listing.info.product_id,
             listing.info.name.empty() ? "(no name)" : listing.info.name, evdev_ability(listing));
  print_refusal(listing.refusal, udev_rule_of(listing));
}

nlohmann::ordered_json json_of(const EvdevListing& listing) {
  return {{"path", listing.info.path},
          {"vendor_id", listing.info.vendor_id},
          {"product_id", listing.info.product_id},
          {"product", listing.info.name},
          {"serial", ""},
          {"driver", "evdev"},
          {"ability", evdev_ability(listing)},
          {"refusal", listing.refusal},
          {"udev_rule", udev_rule_of(listing)},
          {"force_feedback_node", listing.info.path}};
}

nlohmann::ordered_json json_of(const HidListing& listing, const EvdevListing* evdev) {
  const HidDeviceInfo& info = listing.info;
  const Ability ability = ability_of(listing);
  nlohmann::ordered_json json = {{"path", info.path},
                                 {"vendor_id", info.vendor_id},
                                 {"product_id", info.product_id},
                                 {"product", info.product},
                                 {"serial", info.serial},
                                 {"driver", ability.kind},
                                 {"ability", ability.text},
                                 {"refusal", listing.refusal},
                                 {"udev_rule", udev_rule(info)},
                                 {"force_feedback_node", listing.force_feedback_node}};
  if (!evdev) return json;
  json["evdev"] = json_of(*evdev);
  json["advice"] = "use " + advice(listing, *evdev);
  return json;
}

std::string inverse3_path(const Inverse3Address& service, const Inverse3State& device) {
  return service.text.substr(0, service.text.find('#')) + "#" + device.device_id;
}

std::string inverse3_ability(const Inverse3State& device) {
  std::string text =
      "reads 3 positions in metres, renders 3 forces in newtons (Inverse3); driver = \"inverse3\" with its origin";
  if (!device.calibrated.value_or(true)) text += "; it is not calibrated";
  if (device.in_use.value_or(false)) text += "; another program uses it";
  return text;
}

nlohmann::ordered_json json_of(const Inverse3Address& service, const Inverse3State& device) {
  return {{"path", inverse3_path(service, device)},
          {"vendor_id", 0},
          {"product_id", 0},
          {"product", "Haply Inverse3"},
          {"serial", device.device_id},
          {"driver", "inverse3"},
          {"ability", inverse3_ability(device)},
          {"refusal", ""},
          {"udev_rule", ""},
          {"force_feedback_node", ""}};
}

/// The evdev devices that no HID device in the list has made.
std::vector<EvdevListing> evdev_alone(const std::vector<HidListing>& hid, const std::vector<EvdevListing>& evdev) {
  std::vector<EvdevListing> alone;
  for (const EvdevListing& one : evdev) {
    const auto made_it = [&](const HidListing& listing) { return listing.force_feedback_node == one.info.path; };
    if (std::none_of(hid.begin(), hid.end(), made_it)) alone.push_back(one);
  }
  return alone;
}

/// Prints why and returns false if this build cannot look for what was asked for.
bool can_look(const DevicesArguments& arguments) {
  const auto refuse = [](const std::string& why) {
    spdlog::error("error: {}", why);
    return false;
  };
  if (!built_with_inverse3() && !arguments.service.empty())
    return refuse(fmt::format("--service {}: {}", arguments.service, refusal_without(build_option::kInverse3)));
  if (!built_with_hidapi()) return refuse(refusal_without(build_option::kHidapi));
  if (built_with_inverse3()) return true;
  spdlog::warn("a Haply Inverse3 is not looked for: {}", refusal_without(build_option::kInverse3));
  return true;
}

ExitCode devices(const DevicesArguments& arguments, const std::atomic<bool>& interrupted, const Registry& registry) {
  if (arguments.opencl) return opencl_devices_command(arguments.check, arguments.json, interrupted, registry);
  if (arguments.check) {
    spdlog::error("error: --check is for --opencl: nothing is done to a haptic device");
    return ExitCode::usage;
  }
  if (!can_look(arguments)) return ExitCode::usage;
  std::vector<HidListing> found;
  try {
    found = hid_devices();
  } catch (const DeviceError& error) {
    spdlog::error("error: {}", error.what());
    return ExitCode::run_failed;
  }
  const std::string where = arguments.service.empty() ? kUsualService : arguments.service;
  const auto service = read_inverse3_address(where);
  if (!service) {
    spdlog::error("error: --service {}: {}", where, service.error());
    return ExitCode::usage;
  }
  const std::vector<EvdevListing> evdev = evdev_devices(), alone = evdev_alone(found, evdev);
  const std::vector<Inverse3State> arms = inverse3_devices(*service);
  if (arguments.json) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const HidListing& listing : found) list.push_back(json_of(listing, evdev_of(listing, evdev)));
    for (const EvdevListing& listing : alone) list.push_back(json_of(listing));
    for (const Inverse3State& arm : arms) list.push_back(json_of(*service, arm));
    // The strings of a device may be anything; if they are not UTF-8, the list must be printed nevertheless.
    fmt::print("{}\n", list.dump(1, ' ', false, nlohmann::json::error_handler_t::replace));
    return ExitCode::pass;
  }
  for (const HidListing& listing : found) print_listing(listing, evdev_of(listing, evdev));
  for (const EvdevListing& listing : alone) print_listing(listing);
  for (const Inverse3State& arm : arms)
    fmt::print("{}  Haply Inverse3\n    {}\n", inverse3_path(*service, arm), inverse3_ability(arm));
  if (arms.empty() && !arguments.service.empty())
    fmt::print("{}: no Haply Inverse3 there: is the Inverse Service running?\n", service->text);
  if (found.empty() && alone.empty() && arms.empty()) {
    fmt::print(
        "no HID device is connected (or /sys is not there). Without one: run --clock wall SCENARIO, which simulates it\n");
  }
  print_opencl_devices();
  return ExitCode::pass;
}

}  // namespace

void add_devices(Commands& commands) {
  auto [command, arguments] = commands.add<DevicesArguments>(
      "devices", "the devices of this machine, what each of them can do, and by which driver", devices);
  command.flag("--json", arguments.json, "the list as JSON instead of text");
  command.flag("--opencl", arguments.opencl, "only the OpenCL devices, which compute tissue");
  command.flag(
      "--check", arguments.check,
      "with --opencl: run on each of them: the bits against the CPU, steps per second, recordings, ten seconds live; "
      "a table to send to us");
  command.option("--service", arguments.service, "where a Haply Inverse Service may listen: ws://127.0.0.1:10001");
}

}  // namespace evenstep::app
