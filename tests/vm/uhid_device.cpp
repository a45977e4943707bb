#include "uhid_device.h"

#include <fcntl.h>
#include <linux/input.h>
#include <linux/uhid.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace {
namespace fs = std::filesystem;

constexpr const char* kUhid = "/dev/uhid";

std::atomic<int> devices_made{0};

void put(int fd, const uhid_event& event) {
  if (write(fd, &event, sizeof event) != static_cast<ssize_t>(sizeof event))
    throw std::runtime_error(std::string("/dev/uhid: ") + std::strerror(errno));
}

template <std::size_t N>
void copy_text(unsigned char (&to)[N], const std::string& text) {
  std::memcpy(to, text.data(), std::min(N - 1, text.size()));
}

Bytes bytes_of(const unsigned char* data, std::size_t size) {
  const auto* const first = reinterpret_cast<const std::byte*>(data);
  return {first, first + size};
}

/// The folder of the device whose uevent has this HID_PHYS.
fs::path find_device(const std::string& unique) {
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator("/sys/bus/hid/devices", none)) {
    std::ifstream in(entry.path() / "uevent");
    for (std::string line; std::getline(in, line);) {
      if (line == "HID_PHYS=" + unique) return entry.path();
    }
  }
  return {};
}

/// Waits for up to ten seconds, of real time or of a guest's time.
template <class Find>
std::string wait_for(Find find) {
  for (int i = 0; i < 1000; ++i) {
    const std::string found = find();
    if (!found.empty()) return found;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return {};
}

}  // namespace

std::string UhidDevice::refusal() {
  const int fd = open(kUhid, O_RDWR | O_CLOEXEC);
  if (fd < 0) return std::string(kUhid) + ": " + std::strerror(errno);
  close(fd);
  return {};
}

UhidDevice::UhidDevice(Spec spec) : spec_(std::move(spec)) {
  unique_ = "evenstep-" + std::to_string(getpid()) + "-" + std::to_string(++devices_made);
  create();
}

UhidDevice::~UhidDevice() {
  if (fd_ >= 0) destroy();
}

void UhidDevice::create() {
  fd_ = open(kUhid, O_RDWR | O_CLOEXEC);
  if (fd_ < 0) throw std::runtime_error(refusal());
  uhid_event event{};
  event.type = UHID_CREATE2;
  uhid_create2_req& request = event.u.create2;
  copy_text(request.name, spec_.name);
  copy_text(request.phys, unique_);
  copy_text(request.uniq, spec_.serial);
  request.rd_size = static_cast<std::uint16_t>(spec_.report_descriptor.size());
  request.bus = BUS_USB;
  request.vendor = spec_.vendor;
  request.product = spec_.product;
  std::memcpy(request.rd_data, spec_.report_descriptor.data(),
              std::min(sizeof request.rd_data, spec_.report_descriptor.size()));
  put(fd_, event);
  closing_ = false;
  thread_ = std::thread([this] { serve(); });
}

void UhidDevice::destroy() {
  uhid_event event{};
  event.type = UHID_DESTROY;
  [[maybe_unused]] const ssize_t sent = write(fd_, &event, sizeof event);  // EINVAL: the kernel had refused it
  closing_ = true;
  thread_.join();
  close(fd_);
  fd_ = -1;
}

void UhidDevice::unplug() { destroy(); }
void UhidDevice::plug_in() { create(); }

void UhidDevice::send(std::span<const std::byte> report) {
  uhid_event event{};
  event.type = UHID_INPUT2;
  event.u.input2.size = static_cast<std::uint16_t>(report.size());
  std::memcpy(event.u.input2.data, report.data(), report.size());
  put(fd_, event);
}

/// Answers requests of the kernel until the device is destroyed.
void UhidDevice::serve() {
  while (!closing_) {
    pollfd waiting{fd_, POLLIN, 0};
    if (poll(&waiting, 1, 5) <= 0) continue;
    uhid_event event{};
    if (read(fd_, &event, sizeof event) <= 0) continue;
    const std::lock_guard lock(mutex_);
    uhid_event reply{};
    if (event.type == UHID_OUTPUT) {
      take(bytes_of(event.u.output.data, event.u.output.size));
    } else if (event.type == UHID_SET_REPORT) {
      reply.type = UHID_SET_REPORT_REPLY;
      reply.u.set_report_reply.id = event.u.set_report.id;
      reply.u.set_report_reply.err = take_feature(bytes_of(event.u.set_report.data, event.u.set_report.size)) ? 0 : EIO;
      put(fd_, reply);
    } else if (event.type == UHID_GET_REPORT) {
      const Bytes answer = feature(event.u.get_report.rnum);
      reply.type = UHID_GET_REPORT_REPLY;
      reply.u.get_report_reply.id = event.u.get_report.id;
      reply.u.get_report_reply.err = answer.empty() ? EIO : 0;
      reply.u.get_report_reply.size = static_cast<std::uint16_t>(answer.size());
      std::copy(answer.begin(), answer.end(), reinterpret_cast<std::byte*>(reply.u.get_report_reply.data));
      put(fd_, reply);
    }
  }
}

void UhidDevice::take(const Bytes& output) {
  outputs_.push_back(output);
  if (spec_.firmware) spec_.firmware->write(output);
}

bool UhidDevice::take_feature(const Bytes& report) {
  features_set_.push_back(report);
  return !spec_.firmware || spec_.firmware->set_feature(report) == evenstep::HidWrite::ok;
}

/// The feature report; empty if it is refused.
Bytes UhidDevice::feature(std::uint8_t id) {
  if (spec_.firmware) {
    Bytes report(UHID_DATA_MAX, std::byte{id});
    const evenstep::HidFeature got = spec_.firmware->get_feature(report);
    report.resize(got.status == evenstep::HidFeature::Status::ok ? got.size : 0);
    return report;
  }
  for (const Bytes& answer : feature_answers_) {
    if (answer[0] == std::byte{id}) return answer;
  }
  return {};
}

void UhidDevice::answer_feature(Bytes report) {
  const std::lock_guard lock(mutex_);
  feature_answers_.push_back(std::move(report));
}
std::vector<Bytes> UhidDevice::outputs() const {
  const std::lock_guard lock(mutex_);
  return outputs_;
}
std::vector<Bytes> UhidDevice::features_set() const {
  const std::lock_guard lock(mutex_);
  return features_set_;
}

std::string UhidDevice::node() const {
  return wait_for([&]() -> std::string {
    const fs::path folder = find_device(unique_);
    std::error_code none;
    if (folder.empty()) return {};
    for (const fs::directory_entry& entry : fs::directory_iterator(folder / "hidraw", none)) {
      const std::string node = "/dev/" + entry.path().filename().string();
      if (access(node.c_str(), R_OK | W_OK) == 0) return node;
    }
    return {};
  });
}

std::string UhidDevice::hid_name() const {
  return wait_for([&] { return find_device(unique_).filename().string(); });
}
