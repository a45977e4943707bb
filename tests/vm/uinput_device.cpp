#include "uinput_device.h"

#include <dirent.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <stdexcept>

namespace {

void must(int result, const char* what) {
  if (result < 0) throw std::runtime_error(std::string(what) + ": " + std::strerror(errno));
}

}  // namespace

std::string UinputDevice::refusal() {
  const int fd = open("/dev/uinput", O_RDWR);
  if (fd < 0) return std::string("/dev/uinput: ") + std::strerror(errno);
  close(fd);
  return {};
}

UinputDevice::UinputDevice(int most) : most_(most) { plug_in(); }

void UinputDevice::plug_in() {
  told_ = {};
  closing_ = false;
  must(fd_ = open("/dev/uinput", O_RDWR | O_NONBLOCK), "/dev/uinput");
  for (const int type : {EV_ABS, EV_FF}) must(ioctl(fd_, UI_SET_EVBIT, type), "type of events");
  for (const int bit : {FF_CONSTANT, FF_SPRING, FF_GAIN, FF_AUTOCENTER}) must(ioctl(fd_, UI_SET_FFBIT, bit), "FF bit");
  for (const int code : {ABS_X, ABS_Y}) {
    must(ioctl(fd_, UI_SET_ABSBIT, code), "UI_SET_ABSBIT");
    uinput_abs_setup axis{};
    axis.code = static_cast<__u16>(code);
    axis.absinfo.minimum = -most_;
    axis.absinfo.maximum = most_;
    axis.absinfo.fuzz = kFuzz;
    must(ioctl(fd_, UI_ABS_SETUP, &axis), "UI_ABS_SETUP");
  }
  uinput_setup setup{};
  setup.id = {BUS_USB, 0x1209, 0x0E59, 1};
  std::snprintf(setup.name, sizeof setup.name, "evenstep uinput device");
  setup.ff_effects_max = kEffects;
  must(ioctl(fd_, UI_DEV_SETUP, &setup), "UI_DEV_SETUP");
  must(ioctl(fd_, UI_DEV_CREATE), "UI_DEV_CREATE");
  thread_ = std::thread([this] { serve(); });
}

UinputDevice::~UinputDevice() { unplug(); }

void UinputDevice::unplug() {
  if (fd_ < 0) return;
  closing_ = true;
  thread_.join();
  ioctl(fd_, UI_DEV_DESTROY);
  close(fd_);
  fd_ = -1;
}

std::string UinputDevice::node() const {
  char name[64] = {};
  must(ioctl(fd_, UI_GET_SYSNAME(sizeof name), name), "UI_GET_SYSNAME");
  const std::string folder = std::string("/sys/devices/virtual/input/") + name;
  for (int tries = 0; tries < 5000; ++tries) {
    if (DIR* entries = opendir(folder.c_str())) {
      std::string found;
      while (const dirent* entry = readdir(entries)) {
        if (std::strncmp(entry->d_name, "event", 5) == 0) found = std::string("/dev/input/") + entry->d_name;
      }
      closedir(entries);
      if (!found.empty() && access(found.c_str(), R_OK) == 0) return found;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  throw std::runtime_error("no event node in " + folder);
}

void UinputDevice::report(int x, int y) {
  input_event events[3] = {};
  events[0].type = events[1].type = EV_ABS;
  events[0].code = ABS_X, events[0].value = x;
  events[1].code = ABS_Y, events[1].value = y;
  events[2].type = EV_SYN;
  must(static_cast<int>(write(fd_, events, sizeof events)), "report");
}

UinputDevice::Told UinputDevice::told() const {
  const std::lock_guard lock(mutex_);
  return told_;
}

void UinputDevice::serve() {
  while (!closing_) {
    pollfd wait{fd_, POLLIN, 0};
    if (poll(&wait, 1, 10) <= 0) continue;
    input_event event{};
    while (read(fd_, &event, sizeof event) == static_cast<ssize_t>(sizeof event)) answer(event);
  }
}

void UinputDevice::answer(const input_event& event) {
  const std::lock_guard lock(mutex_);
  if (event.type == EV_UINPUT && event.code == UI_FF_UPLOAD) {
    uinput_ff_upload upload{};
    upload.request_id = static_cast<__u32>(event.value);
    if (ioctl(fd_, UI_BEGIN_FF_UPLOAD, &upload) < 0) return;
    upload.retval = -refuse_with_;
    if (upload.retval == 0) told_.effects[upload.effect.id] = upload.effect;
    if (upload.retval == 0 && upload.effect.id == 0) {
      ++told_.uploads;
      told_.least_level = std::min(told_.least_level, int{upload.effect.u.constant.level});
      told_.most_level = std::max(told_.most_level, int{upload.effect.u.constant.level});
    }
    ioctl(fd_, UI_END_FF_UPLOAD, &upload);
  } else if (event.type == EV_UINPUT && event.code == UI_FF_ERASE) {
    uinput_ff_erase erase{};
    erase.request_id = static_cast<__u32>(event.value);
    if (ioctl(fd_, UI_BEGIN_FF_ERASE, &erase) < 0) return;
    told_.effects.erase(static_cast<int>(erase.effect_id));
    ioctl(fd_, UI_END_FF_ERASE, &erase);
  } else if (event.type == EV_FF && event.code == FF_GAIN) {
    told_.gain = event.value;
  } else if (event.type == EV_FF && event.code == FF_AUTOCENTER) {
    told_.autocenter = event.value;
  } else if (event.type == EV_FF) {
    told_.plays[event.code] = event.value;
  }
}
