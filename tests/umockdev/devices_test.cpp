// `evenstep devices` as its user sees it, with a mocked device.
#include <sys/wait.h>

#include <cstdio>
#include <string>

#include "catch.h"
#include "evenstep/device/hid/pid_descriptors.h"
#include "evenstep/device/hid/reference_device.h"
#include "mocked_hidraw.h"

using namespace evenstep;
using Catch::Contains;

namespace {

Bytes bytes_of(std::span<const std::byte> data) { return {data.begin(), data.end()}; }

/// What the program prints; it finds the mocked device because it inherits umockdev's environment. No OpenCL is asked for
/// its devices: looking for GPUs, Mesa's opens more files than umockdev's library can follow.
std::string devices(const std::string& option = "") {
  const std::string command = std::string("OCL_ICD_VENDORS=/nowhere '") + EVENSTEP_PROGRAM + "' devices " + option + " 2>&1";
  std::FILE* const out = ::popen(command.c_str(), "r");
  REQUIRE(out);
  std::string text;
  for (int c = 0; (c = std::fgetc(out)) != EOF;) text += static_cast<char>(c);
  CHECK(::pclose(out) == 0);
  return text;
}

MockedHidraw::Spec of(Bytes descriptor, const std::string& name = "a stick") {
  MockedHidraw::Spec spec;
  spec.vendor_product = "00001234:0000ABCD";
  spec.name = name;
  spec.serial = "";
  spec.report_descriptor = std::move(descriptor);
  return spec;
}
Bytes pid() { return bytes_of(pid_descriptor({})); }

}  // namespace

TEST_CASE("devices: the reference device is listed with its path, ids, name, serial and what it can do") {
  MockedHidraw::Spec spec;
  spec.report_descriptor = bytes_of(reference_device::report_descriptor());
  const MockedHidraw device(spec);
  CHECK_THAT(devices(), Catch::StartsWith("/dev/hidraw0  1209:0e57  evenstep reference device  serial SN0001\n"
                                          "    reads 3 positions, renders 3 forces (reference device)\n"));
  CHECK_THAT(devices("--json"), Contains("\"driver\": \"reference\"") && Contains("\"serial\": \"SN0001\""));
}

TEST_CASE("devices: a device of the PID class is listed with its axes and its driver") {
  const MockedHidraw device(of(pid()));
  CHECK_THAT(devices(), Contains("/dev/hidraw0  1234:abcd  a stick\n    force feedback of the PID class: reads XY, renders "
                                 "constant forces and springs along XY; driver = \"pid\""));
  CHECK_THAT(devices("--json"), Contains("\"driver\": \"pid\"") && Contains("KERNELS==\\\"*:1234:ABCD.*\\\""));
}

TEST_CASE("devices: what has force along X alone may be a wheel, and it is said how that is told") {
  const auto listed = [](int axes) {
    PidDescriptorOptions options;
    options.axes = axes;
    const MockedHidraw device(of(bytes_of(pid_descriptor(options))));
    return devices();
  };
  CHECK_THAT(listed(1), Contains("along X; driver = \"pid\" with its travel and its full scale in newtons (of a wheel, with "
                                 "wheel = { turn, radius, torque })"));
  CHECK_THAT(listed(2), !Contains("wheel"));
}

TEST_CASE("devices: what the kernel drives too is listed with its node") {
  MockedHidraw::Spec spec = of(pid());
  spec.force_feedback = "1000c0000 0";  // FF_CONSTANT, FF_SPRING and FF_GAIN
  const MockedHidraw device(spec);
  CHECK_THAT(devices(), Contains("the kernel's force-feedback driver holds it, too: /dev/input/event7"));
}

TEST_CASE("devices: a device without forces and without a name is listed as such") {
  const Bytes mouse = [] {
    Bytes bytes;
    for (const int byte :
         {0x05, 0x01, 0x09, 0x02, 0xA1, 0x01, 0x09, 0x30, 0x15, 0x81, 0x25, 0x7F, 0x75, 0x08, 0x95, 0x01, 0x81, 0x06, 0xC0})
      bytes.push_back(static_cast<std::byte>(byte));
    return bytes;
  }();
  const MockedHidraw device(of(mouse, ""));
  CHECK_THAT(devices(), Contains("1234:abcd  (no name)\n    not a force-feedback device\n"));
  CHECK_THAT(devices("--json"), Contains("\"driver\": \"none\""));
}

TEST_CASE("devices: a descriptor that is cut off is named with the byte where it ends") {
  Bytes cut = pid();
  cut.resize(cut.size() - 1);
  const MockedHidraw device(of(cut));
  CHECK_THAT(devices(),
             Contains(fmt::format("    byte {} of its report descriptor: a collection is still open", cut.size())));
}

TEST_CASE("devices: a device of the PID class that lacks what a force needs is listed with what that is") {
  // The usages of Set Constant Force (0x73) become reserved ones.
  Bytes lacking = pid();
  for (std::size_t i = 0; i + 1 < lacking.size(); ++i)
    if (lacking[i] == std::byte{0x09} && lacking[i + 1] == std::byte{0x73}) lacking[i + 1] = std::byte{0xFE};
  const MockedHidraw device(of(lacking));
  CHECK_THAT(devices(), Contains("force feedback of the PID class, but without a Set Constant Force output report"));
}
