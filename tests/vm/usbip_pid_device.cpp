#include "usbip_pid_device.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <stdexcept>

using namespace evenstep;

namespace {
namespace fs = std::filesystem;

const fs::path kHost = "/sys/devices/platform/vhci_hcd.0";
// Commands of the protocol (Documentation/usb/usbip_protocol.rst), each in a header of 48 bytes.
constexpr std::uint32_t kSubmit = 1, kUnlink = 2, kSubmitted = 3, kUnlinked = 4;
constexpr std::size_t kHeader = 48;
constexpr std::int32_t kStall = -EPIPE;
constexpr std::size_t kKept = 100;  // how many reports to the device are kept

using Octets = std::vector<std::uint8_t>;

bool take_all(int socket, void* into, std::size_t size) {
  return size == 0 || recv(socket, into, size, MSG_WAITALL) == static_cast<ssize_t>(size);
}

std::uint32_t word_at(const std::array<std::uint8_t, kHeader>& header, std::size_t word) {
  std::uint32_t value = 0;
  std::memcpy(&value, header.data() + 4 * word, 4);
  return ntohl(value);
}

void put_word(Octets& to, std::size_t word, std::uint32_t value) {
  value = htonl(value);
  std::memcpy(to.data() + 4 * word, &value, 4);
}

Octets text_descriptor(const std::string& text) {
  Octets bytes{static_cast<std::uint8_t>(2 + 2 * text.size()), 3};
  for (const char c : text) bytes.insert(bytes.end(), {static_cast<std::uint8_t>(c), 0});
  return bytes;
}

/// The first "NAME*" below a folder of the USB device's HID device, after the kernel's PID driver has looked at it, too. The
/// nodes exist before that, and "country" is made afterwards.
std::string find_node(const std::string& below, const std::string& name) {
  for (int tries = 0; tries < 3000; ++tries) {
    std::error_code none;
    for (const auto& entry : fs::directory_iterator("/sys/bus/hid/devices", none)) {
      if (entry.path().filename().string().find(":1209:0E58.") == std::string::npos) continue;
      if (!fs::exists(entry.path() / "country", none)) continue;
      for (const auto& one : fs::recursive_directory_iterator(entry.path() / below, none)) {
        const std::string found = one.path().filename().string();
        if (found.compare(0, name.size(), name) == 0) return found;
      }
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return {};
}

std::span<const std::byte> bytes_of(const Octets& octets) { return std::as_bytes(std::span(octets)); }

}  // namespace

std::string UsbipPidDevice::refusal() {
  return access((kHost / "attach").c_str(), W_OK) == 0 ? "" : (kHost / "attach").string() + ": " + std::strerror(errno);
}

UsbipPidDevice::UsbipPidDevice(const WallClock& clock, const SimulatedBoardOptions& options, const Motion& motion)
    : clock_(clock), firmware_(clock, ProgrammedMotion{motion, clock.now()}, options) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM, 0, ends) != 0) throw std::runtime_error(std::strerror(errno));
  socket_ = ends[0];
  thread_ = std::thread([this] { serve(); });
  // Port 0, the socket, bus 1 and device 2, full speed.
  std::ofstream attach(kHost / "attach");
  attach << "0 " << ends[1] << " " << (1 << 16 | 2) << " 2" << std::flush;
  if (!attach) throw std::runtime_error("vhci_hcd does not take the device");
  close(ends[1]);
}

UsbipPidDevice::~UsbipPidDevice() {
  std::ofstream(kHost / "detach") << "0" << std::flush;
  // vhci_hcd closes its end, so the thread ends by itself.
  thread_.join();
  close(socket_);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
}

std::string UsbipPidDevice::hidraw_node() const {
  const std::string name = find_node("hidraw", "hidraw");
  return name.empty() ? "" : "/dev/" + name;
}
std::string UsbipPidDevice::event_node() const {
  const std::string name = find_node("input", "event");
  return name.empty() ? "" : "/dev/input/" + name;
}

glm::dvec3 UsbipPidDevice::force_N() const {
  const std::lock_guard lock(mutex_);
  return firmware_.motors().force_N;
}

std::vector<Octets> UsbipPidDevice::outputs(std::uint8_t id) const {
  const std::lock_guard lock(mutex_);
  std::vector<Octets> of_id;
  std::copy_if(outputs_.begin(), outputs_.end(), std::back_inserter(of_id), [&](const Octets& one) { return one[0] == id; });
  return of_id;
}

RealTime UsbipPidDevice::force_changed_at() const {
  const std::lock_guard lock(mutex_);
  return force_changed_at_;
}
RealTime UsbipPidDevice::reported_at() const {
  const std::lock_guard lock(mutex_);
  return reported_at_;
}

// ---- USB/IP

void UsbipPidDevice::serve() {
  RealTime next = clock_.now();
  const Duration period{1'000'000};
  for (;;) {
    const std::int64_t wait_ns = std::max<std::int64_t>(0, (next - clock_.now()).ns);
    const timespec wait{0, static_cast<long>(std::min<std::int64_t>(wait_ns, 999'999'999))};
    pollfd socket{socket_, POLLIN, 0};
    if (ppoll(&socket, 1, &wait, nullptr) > 0 && !receive()) return;
    if (clock_.now() < next) continue;
    transfer();
    next = std::max(next + period, clock_.now());
  }
}

bool UsbipPidDevice::receive() {
  std::array<std::uint8_t, kHeader> header;
  if (!take_all(socket_, header.data(), header.size())) return false;
  const std::uint32_t command = word_at(header, 0), sequence = word_at(header, 1);
  if (command == kUnlink) return unlink(sequence, word_at(header, 5)), true;
  if (command != kSubmit) return false;
  Submit submit;
  submit.sequence = sequence;
  submit.in = word_at(header, 3) == 1;
  submit.endpoint = word_at(header, 4);
  submit.length = word_at(header, 6);
  std::copy_n(header.begin() + 40, 8, submit.setup.begin());
  if (!submit.in) {
    submit.data.resize(std::min<std::size_t>(submit.length, 65536));
    if (!take_all(socket_, submit.data.data(), submit.data.size())) return false;
  }
  if (submit.endpoint == 0)
    control(submit);
  else
    (submit.in ? in_ : out_).push_back(std::move(submit));
  return true;
}

void UsbipPidDevice::unlink(std::uint32_t sequence, std::uint32_t victim) {
  bool found = false;
  for (auto* queue : {&in_, &out_}) {
    const auto is_it = [&](const Submit& submit) { return submit.sequence == victim; };
    const auto at = std::find_if(queue->begin(), queue->end(), is_it);
    if (at == queue->end()) continue;
    queue->erase(at);
    found = true;
  }
  Octets answer(kHeader);
  put_word(answer, 0, kUnlinked);
  put_word(answer, 1, sequence);
  put_word(answer, 5, static_cast<std::uint32_t>(found ? -ECONNRESET : 0));
  send(socket_, answer.data(), answer.size(), MSG_NOSIGNAL);
}

void UsbipPidDevice::reply(std::uint32_t sequence, std::int32_t status, const Octets& data, std::uint32_t length) {
  Octets answer(kHeader);
  put_word(answer, 0, kSubmitted);
  put_word(answer, 1, sequence);
  put_word(answer, 5, static_cast<std::uint32_t>(status));
  put_word(answer, 6, length);
  answer.insert(answer.end(), data.begin(), data.end());
  send(socket_, answer.data(), answer.size(), MSG_NOSIGNAL);
}

// ---- the device

/// One report each way.
void UsbipPidDevice::transfer() {
  if (!out_.empty()) {
    const Submit submit = std::move(out_.front());
    out_.pop_front();
    {
      const std::lock_guard lock(mutex_);
      firmware_.write(bytes_of(submit.data));
      if (outputs_.size() < kKept && !submit.data.empty()) outputs_.push_back(submit.data);
    }
    note_force();
    reply(submit.sequence, 0, {}, submit.length);
  }
  note_force();
  if (in_.empty()) return;
  Octets report(64);
  HidRead got;
  {
    const std::lock_guard lock(mutex_);
    got = firmware_.read(std::as_writable_bytes(std::span(report)));
    if (got.status == HidRead::Status::report) reported_at_ = clock_.now();
  }
  if (got.status != HidRead::Status::report) return;
  const Submit submit = std::move(in_.front());
  in_.pop_front();
  report.resize(std::min<std::size_t>(got.size, submit.length));
  reply(submit.sequence, 0, report, static_cast<std::uint32_t>(report.size()));
}

void UsbipPidDevice::note_force() {
  const std::lock_guard lock(mutex_);
  const glm::dvec3 force_N = firmware_.motors().force_N;
  if (force_N == force_N_) return;
  force_N_ = force_N;
  force_changed_at_ = clock_.now();
}

Octets UsbipPidDevice::descriptor(const std::array<std::uint8_t, 8>& setup) const {
  const auto of_reports = firmware_.report_descriptor();
  const auto size = static_cast<std::uint16_t>(of_reports.size());
  const auto low = static_cast<std::uint8_t>(size), high = static_cast<std::uint8_t>(size >> 8);
  const Octets hid{9, 0x21, 0x11, 0x01, 0, 1, 0x22, low, high};
  switch (setup[3]) {
    case 1:
      return {18, 1, 0x00, 0x02, 0, 0, 0, 64, 0x09, 0x12, 0x58, 0x0E, 0x00, 0x01, 1, 2, 0, 1};  // 1209:0E58
    case 2: {
      Octets all{9, 2, 41, 0, 1, 1, 0, 0x80, 50, 9, 4, 0, 0, 2, 3, 0, 0, 0};
      all.insert(all.end(), hid.begin(), hid.end());
      const Octets endpoints{7, 5, 0x81, 3, 64, 0, 1, 7, 5, 0x02, 3, 64, 0, 1};
      all.insert(all.end(), endpoints.begin(), endpoints.end());
      return all;
    }
    case 3:
      if (setup[2] == 0) return {4, 3, 0x09, 0x04};
      return text_descriptor(setup[2] == 1 ? "evenstep" : "evenstep PID device");
    case 0x21:
      return hid;
    case 0x22: {
      Octets bytes(of_reports.size());
      std::memcpy(bytes.data(), of_reports.data(), bytes.size());
      return bytes;
    }
    default:
      return {};
  }
}

void UsbipPidDevice::control(const Submit& submit) {
  const std::uint8_t type = submit.setup[0], request = submit.setup[1], id = submit.setup[2], kind = submit.setup[3];
  const auto answer = [&](Octets data) {
    data.resize(std::min<std::size_t>(data.size(), submit.length));
    reply(submit.sequence, 0, data, static_cast<std::uint32_t>(data.size()));
  };
  const auto stall = [&] { reply(submit.sequence, kStall, {}, 0); };
  if ((type == 0x80 || type == 0x81) && request == 6) {
    const Octets data = descriptor(submit.setup);
    return data.empty() ? stall() : answer(data);
  }
  if ((type & 0x80) != 0 && request == 0 && (type & 0x60) == 0) return answer({0, 0});  // Get Status
  if (type == 0xA1 && request == 1) {                                                   // Get Report
    Octets report(64);
    report[0] = id;
    HidFeature got;
    {
      const std::lock_guard lock(mutex_);
      if (kind == 3) got = firmware_.get_feature(std::as_writable_bytes(std::span(report)));
    }
    if (got.status != HidFeature::Status::ok) return stall();
    report.resize(got.size);
    return answer(report);
  }
  if (type == 0x21 && request == 9) {  // Set Report
    {
      const std::lock_guard lock(mutex_);
      const HidWrite taken =
          kind == 3 ? firmware_.set_feature(bytes_of(submit.data)) : firmware_.write(bytes_of(submit.data));
      (void)taken;  // firmware ignores what it does not know
    }
    note_force();
    return reply(submit.sequence, 0, {}, submit.length);
  }
  if ((type & 0x80) == 0) return reply(submit.sequence, 0, {}, submit.length);  // Set Address, Idle, Protocol, ...
  stall();
}
