#include "fake_hidapi.h"

#include <hidapi/hidapi.h>

#include <cassert>
#include <cerrno>
#include <mutex>
#include <string>
#include <vector>

#include "../../device/src/hid/hidraw_sysfs.h"

namespace evenstep::test {
namespace {

std::mutex mutex;  // guards everything below, and the device
HidTransport* device = nullptr;
FailingWrites failing;
std::int64_t failures = 0;

std::span<const std::byte> bytes_of(const unsigned char* data, std::size_t size) {
  return {reinterpret_cast<const std::byte*>(data), size};
}

int result_of(HidWrite sent, std::size_t size) {
  if (sent == HidWrite::ok) return static_cast<int>(size);
  errno = sent == HidWrite::gone ? ENODEV : EPIPE;
  return -1;
}

}  // namespace

FakeHidapi::FakeHidapi(HidTransport& below) {
  const std::lock_guard lock(mutex);
  assert(device == nullptr);
  device = &below;
  failing = {};
  failures = 0;
}

FakeHidapi::~FakeHidapi() {
  const std::lock_guard lock(mutex);
  device = nullptr;
}

void FakeHidapi::fail(FailingWrites how) {
  const std::lock_guard lock(mutex);
  failing = how;
}

std::int64_t FakeHidapi::failed() const {
  const std::lock_guard lock(mutex);
  return failures;
}

}  // namespace evenstep::test

using namespace evenstep::test;

struct hid_device_ {};

extern "C" {

int hid_init() { return 0; }
const wchar_t* hid_error(hid_device*) { return L"fake"; }
hid_device* hid_open_path(const char*) { return new hid_device_; }
void hid_close(hid_device* opened) { delete opened; }

hid_device_info* hid_enumerate(unsigned short, unsigned short) {
  static char path[] = "/dev/hidraw0";
  auto* const info = new hid_device_info{};
  info->path = path;
  info->vendor_id = 0x1209;
  info->product_id = 0x0E58;
  return info;
}
void hid_free_enumeration(hid_device_info* info) { delete info; }

int hid_write(hid_device*, const unsigned char* data, std::size_t size) {
  const std::lock_guard lock(mutex);
  if (failing.count > 0) {
    --failing.count;
    ++failures;
    if (failing.error == 0) return static_cast<int>(size) + failing.difference;
    errno = failing.error;
    return -1;
  }
  return result_of(device->write(bytes_of(data, size)), size);
}

int hid_read_timeout(hid_device*, unsigned char* data, std::size_t size, int) {
  const std::lock_guard lock(mutex);
  const evenstep::HidRead got = device->read({reinterpret_cast<std::byte*>(data), size});
  errno = ENODEV;
  if (got.status == evenstep::HidRead::Status::gone) return -1;
  return got.status == evenstep::HidRead::Status::report ? static_cast<int>(got.size) : 0;
}

int hid_get_feature_report(hid_device*, unsigned char* data, std::size_t size) {
  const std::lock_guard lock(mutex);
  const evenstep::HidFeature got = device->get_feature({reinterpret_cast<std::byte*>(data), size});
  errno = EPIPE;
  return got.status == evenstep::HidFeature::Status::ok ? static_cast<int>(got.size) : -1;
}

int hid_send_feature_report(hid_device*, const unsigned char* data, std::size_t size) {
  const std::lock_guard lock(mutex);
  return result_of(device->set_feature(bytes_of(data, size)), size);
}
}

namespace evenstep::internal {

std::string hidraw_name(const std::string& path) { return path == "/dev/hidraw0" ? "hidraw0" : ""; }
std::vector<std::byte> hidraw_report_descriptor(const std::string&) {
  const std::lock_guard lock(mutex);
  return {device->report_descriptor().begin(), device->report_descriptor().end()};
}
std::string hidraw_property(const std::string&, const std::string&) { return "fake"; }
std::string hidraw_force_feedback_node(const std::string&) { return ""; }

}  // namespace evenstep::internal
