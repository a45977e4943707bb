#include "evenstep/device/inverse3/inverse3_driver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

namespace evenstep {

Inverse3Driver::Inverse3Driver(Inverse3Link& link, const Inverse3Options& options) : link_(link), options_(options) {
  const Inverse3State device = choose();
  if (device.in_use.value_or(false) && !options_.shared)
    fail(
        fmt::format("the service says that another program uses device {}: end it, or two programs push the same hand; if "
                    "none does, write inverse3 = {{ shared = true }}",
                    device.device_id));
  device_id_ = device.device_id;
  begin();
}

/// Puts the link to rest, with zero force.
void Inverse3Driver::begin() { link_.rest(inverse3_force_message(device_id_, glm::dvec3(0))); }

Inverse3Driver::~Inverse3Driver() { stop(); }

Inverse3State Inverse3Driver::choose() const {
  const auto devices = read_inverse3_message(link_.first_message());
  if (!devices) fail("this is not what an Inverse Service says: " + devices.error());
  if (devices->empty()) fail("no Inverse3 is connected to the service; plug it in and run again");
  std::string ids;
  for (const Inverse3State& device : *devices) {
    if (device.device_id == options_.device_id) return device;
    ids += (ids.empty() ? "" : ", ") + device.device_id;
  }
  if (!options_.device_id.empty()) fail(fmt::format("it has no device {}, but {}", options_.device_id, ids));
  if (devices->size() > 1)
    fail(fmt::format("it has more than one device ({}): add # and the id of one to the address", ids));
  return devices->front();
}

void Inverse3Driver::start() {
  assert(!started_);
  started_ = true;
}

void Inverse3Driver::stop() noexcept {
  started_ = false;
  for (int tries = 0; tries < 2; ++tries) {
    try {
      begin();
      return;
    } catch (...) {  // a simulated hand may have diverged, but the device must be stopped nevertheless
    }
  }
}

DeviceSample Inverse3Driver::read(RealTime now) {
  last_.read_at = now;
  last_.fresh = last_.away = false;
  if (!heard_at_) heard_at_ = now;
  const Inverse3Link::Read got = link_.read(text_);
  if (got == Inverse3Link::Read::gone) fail(text_ + "; start the service and run again");
  if (got == Inverse3Link::Read::message && !is_away_) take(now);
  if (got == Inverse3Link::Read::returned) come_back(now);
  if (got == Inverse3Link::Read::away || is_away_) {
    is_away_ = last_.away = true;
    last_.drivable = false;
    heard_at_ = now;  // the link decides how long it may be away
  }
  if (!last_.fresh) ++counters_.stale;
  if (now - *heard_at_ > options_.silence)
    fail(
        fmt::format("the service has told no position of device {} for {:.3g} s; look at the device and the service, and "
                    "run again",
                    device_id_, seconds(options_.silence)));
  return last_;
}

/// The forces rise from zero again, because this tick and those up to the first position say that the device is not
/// drivable; until then it is sent only zero.
void Inverse3Driver::come_back(RealTime now) {
  const std::string why_not = objection();
  is_away_ = !why_not.empty();
  if (is_away_) return link_.reject(why_not);
  last_.drivable = false;
  last_.away = true;
  is_returning_ = true;
  heard_at_ = now;
  begin();
}

/// What is wrong with the service or device that came back; empty: nothing.
std::string Inverse3Driver::objection() const {
  const auto devices = read_inverse3_message(link_.first_message());
  if (!devices) return "what came back is no Inverse Service: " + devices.error();
  std::string others;
  for (const Inverse3State& device : *devices) {
    if (device.device_id != device_id_) {
      others += " " + device.device_id;
      continue;
    }
    if (!device.in_use.value_or(false) || options_.shared) return {};
    return fmt::format("the service came back, and another program uses device {}", device_id_);
  }
  return fmt::format("the service came back without device {}{}{}", device_id_, others.empty() ? "" : ", but with", others);
}

void Inverse3Driver::take(RealTime now) {
  const auto devices = read_inverse3_message(text_);
  if (!devices) {
    ++counters_.malformed;
    return;
  }
  const auto is_it = [&](const Inverse3State& device) { return device.device_id == device_id_; };
  const auto device = std::find_if(devices->begin(), devices->end(), is_it);
  if (device == devices->end() || !device->position_m) {
    ++inverse3_counters_.absent;
    return;
  }
  last_.drivable = device->calibrated.value_or(true);
  if (!last_.drivable) {
    ++inverse3_counters_.uncalibrated;
    return;
  }
  is_returning_ = false;
  last_.position_m = *device->position_m - options_.origin_m;
  last_.fresh = true;
  ++last_.sequence;
  ++counters_.reports;
  heard_at_ = now;
}

void Inverse3Driver::write(const glm::dvec3& force_N) {
  if (!started_) fail("a force cannot be written before start() or after stop()");
  assert(std::isfinite(force_N.x) && std::isfinite(force_N.y) && std::isfinite(force_N.z));
  if (!is_away_ && !is_returning_) link_.post(inverse3_force_message(device_id_, force_N));
}

std::map<std::string, std::int64_t> Inverse3Driver::own_counters() const {
  return {{"inverse3_absent", inverse3_counters_.absent}, {"inverse3_uncalibrated", inverse3_counters_.uncalibrated}};
}

void Inverse3Driver::fail(const std::string& what) const { throw DeviceError(link_.name() + ": " + what); }

}  // namespace evenstep
