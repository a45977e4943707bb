#include "hidraw_sysfs.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>

namespace evenstep::internal {
namespace fs = std::filesystem;
namespace {

const fs::path kClass = "/sys/class/hidraw";

std::string read_text(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code gone;  // a device may be unplugged meanwhile; the result is then whatever is still there
  for (fs::directory_iterator at(folder, gone), end; !gone && at != end; at.increment(gone)) found.push_back(at->path());
  std::sort(found.begin(), found.end());
  return found;
}

/// Whether the name is "hidraw" and a number.
bool is_hidraw(const std::string& name) {
  const std::string prefix = "hidraw";
  const auto is_digit = [](unsigned char c) { return std::isdigit(c) != 0; };
  return name.size() > prefix.size() && name.compare(0, prefix.size(), prefix) == 0 &&
         std::all_of(name.begin() + static_cast<std::ptrdiff_t>(prefix.size()), name.end(), is_digit);
}

}  // namespace

std::string hidraw_name(const std::string& path) {
  std::error_code missing;
  std::string name = fs::path(path).filename().string();
  if (!is_hidraw(name)) name = fs::canonical(path, missing).filename().string();  // a link made by udev, "/dev/haptic"
  return !missing && is_hidraw(name) && fs::exists(path, missing) && fs::exists(kClass / name, missing) ? name : "";
}

std::vector<std::byte> hidraw_report_descriptor(const std::string& name) {
  const std::string text = read_text(kClass / name / "device" / "report_descriptor");
  std::vector<std::byte> bytes(text.size());
  std::transform(text.begin(), text.end(), bytes.begin(), [](char c) { return static_cast<std::byte>(c); });
  return bytes;
}

std::string hidraw_property(const std::string& name, const std::string& key) {
  std::ifstream in(kClass / name / "device" / "uevent");
  for (std::string line; std::getline(in, line);) {
    if (line.compare(0, key.size() + 1, key + "=") == 0) return line.substr(key.size() + 1);
  }
  return {};
}

std::string hidraw_force_feedback_node(const std::string& name) {
  for (const fs::path& input : entries_of(kClass / name / "device" / "input")) {
    // "capabilities/ff" is a bit mask, in hexadecimal words, of the effects that the kernel's driver can play.
    const std::string effects = read_text(input / "capabilities" / "ff");
    if (effects.find_first_of("123456789abcdef") == std::string::npos) continue;
    for (const fs::path& node : entries_of(input)) {
      if (node.filename().string().compare(0, 5, "event") == 0) return "/dev/input/" + node.filename().string();
    }
  }
  return {};
}

}  // namespace evenstep::internal
