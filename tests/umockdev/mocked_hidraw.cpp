#include "mocked_hidraw.h"

#include <fcntl.h>
#include <linux/hidraw.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <umockdev.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <thread>

namespace {

constexpr const char* kUsb = "/devices/pci0000:00/usb1/1-1";
constexpr const char* kInterface = "/devices/pci0000:00/usb1/1-1/1-1:1.0";

std::string hid_folder(const MockedHidraw::Spec& spec) {
  return std::string(kInterface) + "/0003:" + spec.vendor_product.substr(4, 4) + ":" + spec.vendor_product.substr(13, 4) +
         ".0001";
}

std::string hex(const Bytes& bytes) {
  std::string text;
  char digits[3];
  for (const std::byte b : bytes) {
    std::snprintf(digits, sizeof digits, "%02X", std::to_integer<unsigned>(b));
    text += digits;
  }
  return text;
}

/// A hidraw node with its HID device, USB interface and USB device, as the kernel shows them.
std::string devices_text(const MockedHidraw::Spec& spec, int number) {
  const std::string hid = hid_folder(spec), node = "hidraw" + std::to_string(number), minor = std::to_string(number);
  std::string text;
  text += std::string("P: ") + kUsb + "\nE: DEVTYPE=usb_device\nE: SUBSYSTEM=usb\n" +
          "A: manufacturer=evenstep\\n\nA: product=" + spec.name + "\\n\nA: serial=" + spec.serial + "\\n\n" +
          "A: idVendor=" + spec.vendor_product.substr(4, 4) + "\\n\nA: idProduct=" + spec.vendor_product.substr(13, 4) +
          "\\n\nA: bcdDevice=0100\\n\n\n";
  text += std::string("P: ") + kInterface + "\nE: DEVTYPE=usb_interface\nE: SUBSYSTEM=usb\nA: bInterfaceNumber=00\\n\n\n";
  text += "P: " + hid + "\nE: DRIVER=hid-generic\nE: HID_ID=0003:" + spec.vendor_product + "\nE: HID_NAME=" + spec.name +
          "\nE: HID_PHYS=usb-1/input0\nE: HID_UNIQ=" + spec.serial +
          "\nE: SUBSYSTEM=hid\nH: report_descriptor=" + hex(spec.report_descriptor) + "\n\n";
  if (spec.force_feedback != "0") {
    text += "P: " + hid + "/input/input5\nE: SUBSYSTEM=input\nA: capabilities/ff=" + spec.force_feedback + "\\n\n\n";
    text += "P: " + hid + "/input/input5/event7\nN: input/event7\nE: DEVNAME=/dev/input/event7\nE: SUBSYSTEM=input\n\n";
  }
  text += "P: " + hid + "/hidraw/" + node + "\nN: " + node + "\nE: DEVNAME=/dev/" + node +
          "\nE: MAJOR=240\nE: MINOR=" + minor + "\nE: SUBSYSTEM=hidraw\n" + "A: dev=240:" + minor +
          "\\n\nL: device=../../../" + hid.substr(hid.rfind('/') + 1) + "\n\n";
  return text;
}

}  // namespace

struct MockedHidraw::State {
  Spec spec;
  UMockdevTestbed* testbed = nullptr;
  UMockdevIoctlBase* handler = nullptr;
  int device_end = -1;  // where input reports are written
  int number = -1;      // the number of the node, which grows each time that it is plugged in

  std::mutex mutex;  // guards everything below, because umockdev's own thread calls the handlers
  std::vector<Bytes> outputs, features_set;
  std::vector<Bytes> feature_answers;
  std::chrono::nanoseconds time_to_write{0};
  bool present = false;

  std::vector<int> ptys_kept;

  void add();
  void keep_pty();
  std::string node() const { return "hidraw" + std::to_string(number); }
  std::string path() const { return "/dev/" + node(); }
};

namespace {

Bytes bytes_of(const UMockdevIoctlData* data, std::size_t size) {
  const auto* first = reinterpret_cast<const std::byte*>(data->data);
  return {first, first + size};
}

/// Gives the bytes of the call to `use` and completes the call with the result: a number of bytes, or a negative errno.
template <class Use>
gboolean answer(UMockdevIoctlClient* client, std::size_t size, Use use) {
  UMockdevIoctlData* const arg = umockdev_ioctl_client_get_arg(client);
  UMockdevIoctlData* const data = umockdev_ioctl_data_resolve(arg, 0, size, nullptr);
  const long result = use(data);
  if (result < 0)
    umockdev_ioctl_client_complete(client, -1, static_cast<int>(-result));
  else
    umockdev_ioctl_client_complete(client, result, 0);
  g_object_unref(data);
  return TRUE;
}

gboolean on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer user) {
  auto& state = *static_cast<MockedHidraw::State*>(user);
  const gulong request = umockdev_ioctl_client_get_request(client);
  const std::lock_guard lock(state.mutex);
  if (_IOC_TYPE(request) != 'H') return FALSE;
  const std::size_t size = _IOC_SIZE(request);
  constexpr unsigned kSetFeature = 6, kGetFeature = 7;
  if (request == HIDIOCGRDESCSIZE) {
    return answer(client, sizeof(int), [&](UMockdevIoctlData* data) {
      const int bytes = static_cast<int>(state.spec.report_descriptor.size());
      std::memcpy(data->data, &bytes, sizeof bytes);
      return 0L;
    });
  }
  if (request == HIDIOCGRDESC) {
    return answer(client, sizeof(hidraw_report_descriptor), [&](UMockdevIoctlData* data) {
      auto* const out = reinterpret_cast<hidraw_report_descriptor*>(data->data);
      std::memcpy(out->value, state.spec.report_descriptor.data(), state.spec.report_descriptor.size());
      return 0L;
    });
  }
  if (_IOC_NR(request) == kSetFeature) {
    return answer(client, size, [&](UMockdevIoctlData* data) {
      if (!state.present) return -static_cast<long>(ENODEV);
      state.features_set.push_back(bytes_of(data, size));
      return static_cast<long>(size);
    });
  }
  if (_IOC_NR(request) == kGetFeature) {
    return answer(client, size, [&](UMockdevIoctlData* data) {
      if (!state.present) return -static_cast<long>(ENODEV);
      for (const Bytes& feature : state.feature_answers) {
        if (feature[0] != static_cast<std::byte>(data->data[0])) continue;
        const std::size_t bytes = std::min(size, feature.size());
        std::memcpy(data->data, feature.data(), bytes);
        return static_cast<long>(bytes);
      }
      return -static_cast<long>(EIO);
    });
  }
  return FALSE;
}

/// For a write, umockdev hands over the bytes themselves.
gboolean on_write(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer user) {
  auto& state = *static_cast<MockedHidraw::State*>(user);
  UMockdevIoctlData* const data = umockdev_ioctl_client_get_arg(client);
  const auto size = static_cast<std::size_t>(data->data_len);
  std::unique_lock lock(state.mutex);
  const std::chrono::nanoseconds pause = state.time_to_write;
  lock.unlock();
  if (pause.count() > 0) std::this_thread::sleep_for(pause);
  lock.lock();
  if (state.present) state.outputs.push_back(bytes_of(data, size));
  umockdev_ioctl_client_complete(client, state.present ? data->data_len : -1, state.present ? 0 : ENODEV);
  return TRUE;
}

}  // namespace

bool MockedHidraw::possible() {
  const char* const preloaded = std::getenv("LD_PRELOAD");
  return preloaded && std::strstr(preloaded, "libumockdev-preload");
}

void MockedHidraw::State::add() {
  ++number;
  handler = umockdev_ioctl_base_new();
  g_signal_connect(handler, "handle-ioctl", G_CALLBACK(on_ioctl), this);
  g_signal_connect(handler, "handle-write", G_CALLBACK(on_write), this);
  umockdev_testbed_attach_ioctl(testbed, path().c_str(), handler, nullptr);  // before the device is there
  if (!umockdev_testbed_add_from_string(testbed, devices_text(spec, number).c_str(), nullptr))
    throw std::runtime_error("umockdev does not take the device");
  if (spec.node == Node::fifo) {
    gchar* const root = umockdev_testbed_get_root_dir(testbed);
    const std::string fifo = std::string(root) + path();
    g_free(root);
    umockdev_testbed_disable(testbed);  // the path is a real one
    unlink(fifo.c_str());
    if (mkfifo(fifo.c_str(), 0600) != 0) throw std::runtime_error("no FIFO at " + fifo);
    device_end = open(fifo.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    umockdev_testbed_enable(testbed);
    fcntl(device_end, F_SETFL, O_NONBLOCK | O_DIRECT);  // packet by packet
    fcntl(device_end, F_SETPIPE_SZ, 64 * 4096);         // room for 64 packets of at most a page
  } else {
    device_end = umockdev_testbed_get_dev_fd(testbed, path().c_str());
    keep_pty();
  }
  const std::lock_guard lock(mutex);
  present = true;
}

MockedHidraw::MockedHidraw(Spec spec) : state_(std::make_unique<State>()) {
  state_->spec = std::move(spec);
  state_->testbed = umockdev_testbed_new();
  state_->add();
}

MockedHidraw::~MockedHidraw() {
  if (state_->spec.node == Node::fifo && state_->device_end >= 0) close(state_->device_end);
  umockdev_testbed_detach_ioctl(state_->testbed, state_->path().c_str(), nullptr);
  for (const int pty : state_->ptys_kept) close(pty);
  g_object_unref(state_->testbed);
  g_object_unref(state_->handler);
}

bool MockedHidraw::send(std::span<const std::byte> report) {
  return write(state_->device_end, report.data(), report.size()) == static_cast<ssize_t>(report.size());
}

void MockedHidraw::unplug() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->present = false;
  }
  const std::string hid = hid_folder(state_->spec);
  // The other end sees a hang-up. (umockdev will close this number again, so it must stay an open file of this process.)
  const int nothing = open("/dev/null", O_RDWR | O_CLOEXEC);
  dup2(nothing, state_->device_end);
  close(nothing);
  for (const std::string& path : {hid + "/hidraw/" + state_->node(), hid, std::string(kInterface), std::string(kUsb)})
    umockdev_testbed_remove_device(state_->testbed, ("/sys" + path).c_str());
}

/// umockdev stops the program when it meets the name of a pty for the second time, and the kernel reuses the number of a pty
/// as soon as neither end is open. So one end stays open, which does not hide a hang-up of the other.
void MockedHidraw::State::keep_pty() {
  umockdev_testbed_disable(testbed);  // the path is a real one
  ptys_kept.push_back(open(ptsname(device_end), O_RDWR | O_NOCTTY | O_CLOEXEC));
  umockdev_testbed_enable(testbed);
  if (ptys_kept.back() < 0) throw std::runtime_error("no other end of the pty");
}

void MockedHidraw::plug_in() {
  umockdev_testbed_detach_ioctl(state_->testbed, state_->path().c_str(), nullptr);
  g_object_unref(state_->handler);
  state_->add();
}

std::vector<Bytes> MockedHidraw::outputs() const {
  const std::lock_guard lock(state_->mutex);
  return state_->outputs;
}
std::vector<Bytes> MockedHidraw::features_set() const {
  const std::lock_guard lock(state_->mutex);
  return state_->features_set;
}
void MockedHidraw::answer_feature(Bytes report) {
  const std::lock_guard lock(state_->mutex);
  state_->feature_answers.push_back(std::move(report));
}
void MockedHidraw::take_time_to_write(evenstep::Duration each) {
  const std::lock_guard lock(state_->mutex);
  state_->time_to_write = std::chrono::nanoseconds(each.ns);
}
