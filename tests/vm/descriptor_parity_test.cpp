/// Compares our parser of report descriptors with that of the kernel, whose result debugfs prints, on generated descriptors,
/// valid and invalid.

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <sstream>
#include <thread>

#include "catch.h"
#include "evenstep/device/hid/reference_device.h"
#include "evenstep/device/hid/report_descriptor.h"
#include "uhid_device.h"

using namespace evenstep;
namespace fs = std::filesystem;

namespace {

void append(Bytes& bytes, unsigned prefix, std::int64_t value, int size) {
  bytes.push_back(static_cast<std::byte>(prefix | (size == 4 ? 3U : static_cast<unsigned>(size))));
  for (int i = 0; i < size; ++i) bytes.push_back(static_cast<std::byte>(value >> (8 * i)));
}

/// Items in an order that mostly makes sense. Usages are from vendor pages: the kernel does not know their names and prints
/// numbers.
Bytes random_descriptor(std::mt19937_64& random) {
  const auto up_to = [&](std::uint64_t most) { return static_cast<std::int64_t>(random() % (most + 1)); };
  Bytes bytes;
  int open = 0, pushed = 0;
  append(bytes, 0x04, 0xFF01 + up_to(3), 2);  // usage page
  append(bytes, 0x08, 1, 1);
  append(bytes, 0xA0, 1, 1);  // an application, or the kernel has no device
  ++open;
  const bool numbered = up_to(1);
  if (numbered) append(bytes, 0x84, 1 + up_to(5), 1);
  for (std::int64_t items = 5 + up_to(50); items > 0; --items) {
    switch (up_to(17)) {
      case 0:
        append(bytes, 0x04, 0xFF01 + up_to(3), 2);
        break;
      case 1: {
        const bool is_signed = up_to(1);
        append(bytes, 0x14, is_signed ? -up_to(30'000) : up_to(100), 2);
        append(bytes, 0x24, 100 + up_to(30'000), 2);
        break;
      }
      case 2:
        append(bytes, 0x24, 0xFFFFFFFF, 4);
        break;
      case 3:
        append(bytes, 0x34, -up_to(100), 1);
        append(bytes, 0x44, up_to(1000), 2);
        break;
      case 4:
        append(bytes, 0x54, up_to(15), 1);
        break;
      case 5:
        append(bytes, 0x64, up_to(1) ? 0x11 : 0xE111, 2);
        break;
      case 6:
        append(bytes, 0x74, 1 + up_to(up_to(9) == 0 ? 300 : 31), up_to(1) ? 1 : 2);
        break;
      case 7:
        append(bytes, 0x94, up_to(up_to(9) == 0 ? 300 : 12), 2);
        break;
      case 8:
        if (numbered) append(bytes, 0x84, up_to(40) == 0 ? 0 : 1 + up_to(5), 1);
        break;
      case 9:
        if (up_to(1)) append(bytes, 0xA4, 0, 0), ++pushed;
        break;
      case 10:
        if (pushed > 0 || up_to(20) == 0) append(bytes, 0xB4, 0, 0), --pushed;
        break;
      case 11:
        append(bytes, 0xA0, up_to(6), 1);
        ++open;
        break;
      case 12:
        if (open > 1 || up_to(20) == 0) append(bytes, 0xC0, 0, 0), --open;
        break;
      case 13:
        for (std::int64_t i = up_to(4); i >= 0; --i) append(bytes, 0x08, up_to(300), 2);
        break;
      case 14:
        append(bytes, 0x18, 10, 1), append(bytes, 0x28, 10 + up_to(30), 1);
        break;
      case 15:
        append(bytes, 0x08, 0xFF020000 + up_to(9), 4);
        break;
      default: {
        const unsigned kind[] = {0x80, 0x90, 0xB0};
        append(bytes, 0x08, 1 + up_to(20), 1);
        append(bytes, kind[up_to(2)], up_to(255), 1);
      }
    }
    if (up_to(400) == 0) bytes.push_back(static_cast<std::byte>(up_to(255)));
  }
  for (; open > 0 && up_to(60) != 0; --open) append(bytes, 0xC0, 0, 0);
  return bytes;
}

std::string usage_text(std::uint32_t usage) {
  char text[16];
  std::snprintf(text, sizeof text, "%04x.%04x", usage >> 16, usage & 0xFFFF);
  return text;
}

/// The descriptor in the format of the kernel, without the unit (which the kernel prints in another form).
std::string dump(const ReportDescriptor& descriptor) {
  std::ostringstream out;
  const char* const names[] = {"INPUT", "OUTPUT", "FEATURE"};
  for (const ReportType type : {ReportType::input, ReportType::output, ReportType::feature}) {
    for (const HidReport& report : descriptor.reports) {
      if (report.type != type) continue;
      const char* const name = names[static_cast<int>(type)];
      out << name;
      if (report.id != 0) out << '(' << int{report.id} << ')';
      out << '[' << name << "]\n";
      int number = 0;
      for (const HidField& field : descriptor.fields) {
        if (field.type != type || field.id != report.id) continue;
        out << "Field(" << number++ << ")\n";
        const std::pair<const char*, std::uint8_t> around[] = {{"Physical", 0}, {"Logical", 2}, {"Application", 1}};
        for (const auto& [word, kind] : around) {
          if (const std::uint32_t usage = descriptor.enclosing(field, kind))
            out << word << '(' << usage_text(usage) << ")\n";
        }
        const std::uint32_t usages = std::max(field.usages.size(), field.count);
        out << "Usage(" << usages << ")\n";
        for (std::uint32_t i = 0; i < usages; ++i) out << usage_text(field.usages[i]) << '\n';
        if (field.logical_minimum != field.logical_maximum) {
          out << "Logical Minimum(" << static_cast<std::int32_t>(field.logical_minimum) << ")\n";
          out << "Logical Maximum(" << static_cast<std::int32_t>(field.logical_maximum) << ")\n";
        }
        if (field.physical_minimum != field.physical_maximum) {
          out << "Physical Minimum(" << static_cast<std::int32_t>(field.physical_minimum) << ")\n";
          out << "Physical Maximum(" << static_cast<std::int32_t>(field.physical_maximum) << ")\n";
        }
        if (field.unit_exponent != 0) out << "Unit Exponent(" << field.unit_exponent << ")\n";
        out << "Report Size(" << field.bits << ")\nReport Count(" << field.count << ")\nReport Offset(" << field.bit_offset
            << ")\n";
        out << "Flags( " << (field.flags & 1 ? "Constant " : "") << (field.flags & 2 ? "Variable " : "Array ")
            << (field.flags & 4 ? "Relative " : "Absolute ") << (field.flags & 8 ? "Wrap " : "")
            << (field.flags & 0x10 ? "NonLinear " : "") << (field.flags & 0x20 ? "NoPreferredState " : "")
            << (field.flags & 0x40 ? "NullState " : "") << (field.flags & 0x80 ? "Volatile " : "")
            << (field.flags & 0x100 ? "BufferedByte " : "") << ")\n";
      }
    }
  }
  return out.str();
}

}  // namespace

namespace {

/// The kernel's dump, from the first report on, without indentation and units.
std::string kernel_dump(const std::string& hid_name) {
  std::ifstream in("/sys/kernel/debug/hid/" + hid_name + "/rdesc");
  std::string text;
  for (std::string line; std::getline(in, line);) {
    line.erase(0, line.find_first_not_of(" \t"));
    const auto starts = [&](const char* word) { return line.compare(0, std::string(word).size(), word) == 0; };
    if (text.empty() && !starts("INPUT") && !starts("OUTPUT") && !starts("FEATURE")) continue;
    if (line.empty()) break;  // after it comes the mapping to input events
    if (starts("Unit(")) continue;
    text += line + '\n';
  }
  return text;
}

struct KernelsParse {
  bool accepted = false;
  std::string text;
};

KernelsParse kernels_parse(const Bytes& descriptor) {
  UhidDevice::Spec spec;
  spec.report_descriptor = descriptor;
  UhidDevice device(spec);
  const std::string name = device.hid_name();
  REQUIRE(!name.empty());
  // Shortly after the device appears, the driver is bound or has refused the descriptor.
  const fs::path driver = fs::path("/sys/bus/hid/devices") / name / "driver";
  for (int i = 0; i < 10 && !fs::exists(driver); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return {fs::exists(driver), kernel_dump(name)};
}

bool is_mounted(const char* path) { return fs::exists(path); }

}  // namespace

TEST_CASE("300 generated descriptors are accepted or refused as the kernel does and every field agrees") {
  if (!is_mounted("/sys/kernel/debug/hid")) {
    WARN("skipped: /sys/kernel/debug is not mounted, or not for us");
    return;
  }
  std::mt19937_64 random(6);
  int accepted = 0;
  std::vector<Bytes> all{Bytes(reference_device::report_descriptor().begin(), reference_device::report_descriptor().end())};
  while (all.size() < 300) all.push_back(random_descriptor(random));
  for (std::size_t i = 0; i < all.size(); ++i) {
    std::string hex;
    for (const std::byte b : all[i])
      hex += "0123456789ABCDEF"[std::to_integer<unsigned>(b) >> 4],
          hex += "0123456789ABCDEF"[std::to_integer<unsigned>(b) & 15];
    INFO("descriptor " << i << ": " << hex);
    const auto ours = parse_report_descriptor(all[i]);
    const KernelsParse theirs = kernels_parse(all[i]);
    CHECK(theirs.accepted == ours.ok());
    if (!theirs.accepted || !ours) continue;
    ++accepted;
    CHECK(dump(*ours) == theirs.text);
  }
  CHECK(accepted >= 100);  // the generator makes enough valid and enough invalid ones
  CHECK(accepted <= 290);
}
