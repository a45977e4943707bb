#include "registered_device.h"

#include <fmt/format.h>

#include <cmath>

#include "evenstep/device/device_clock.h"

namespace evenstep::internal {
namespace {

class NamedDevice final : public HapticDevice {
 public:
  NamedDevice(const ForeignDriverSpec& spec, const DeviceRequest& request)
      : name_(request.name), device_name_(request.device) {
    if (!spec.make) throw failed("is not registered with this program");
    device_ = guarded([&] { return spec.make(request); });
    if (!device_) throw failed("cannot be made: its factory returned nothing");
  }
  void start() override {
    guarded([&] { device_->start(); });
  }
  void stop() noexcept override { device_->stop(); }
  DeviceSample read(RealTime now) override {
    DeviceSample sample = guarded([&] { return device_->read(now); });
    sample.read_at = now;
    if (sample.taken_at) check_taken(*sample.taken_at, now, sample.fresh);
    const glm::dvec3& x = sample.position_m;
    if (!std::isfinite(x.x) || !std::isfinite(x.y) || !std::isfinite(x.z))
      throw failed(fmt::format("gave a position that is not finite at {} ns", now.ns));
    return sample;
  }
  void write(const glm::dvec3& force_N) override {
    guarded([&] { device_->write(force_N); });
  }
  DeviceSpring write_spring(const DeviceSpring& wanted) override {
    return guarded([&] { return device_->write_spring(wanted); });
  }
  double largest_force_N() const override { return device_->largest_force_N(); }
  const DeviceCounters& counters() const override { return device_->counters(); }
  const SampleAges* ages() const override {
    const SampleAges* const own = device_->ages();
    return own || ages_.ages.count() == 0 ? own : &ages_;
  }
  std::map<std::string, std::int64_t> own_counters() const override { return device_->own_counters(); }

 private:
  template <class Call>
  auto guarded(Call call) const -> decltype(call()) {
    try {
      return call();
    } catch (const HandDiverged&) {
      throw;
    } catch (const std::exception& error) {
      throw failed(error.what());
    } catch (...) {
      throw failed("threw something that is no std::exception");
    }
  }
  void check_taken(RealTime taken, RealTime now, bool fresh) {
    if (taken > now) throw failed(fmt::format("says at {} ns that a position was taken at {} ns", now.ns, taken.ns));
    if (last_taken_ && taken < *last_taken_)
      throw failed(
          fmt::format("says that a position was taken at {} ns, before the last one, at {} ns", taken.ns, last_taken_->ns));
    last_taken_ = taken;
    if (fresh) ages_.ages.add(now - taken);
  }
  DeviceError failed(const std::string& what) const {
    return DeviceError(fmt::format("{}: the driver '{}': {}", device_name_, name_, what));
  }

  std::string name_, device_name_;
  std::unique_ptr<HapticDevice> device_;
  std::optional<RealTime> last_taken_;
  SampleAges ages_;
};

}  // namespace

std::unique_ptr<SimulatedGrip> make_grip(const DeviceSpec& device, const Clock& clock) {
  if (device.hand) return std::make_unique<SimulatedGrip>(clock, Hand(*device.hand, device.motion), device.force_delay);
  return std::make_unique<SimulatedGrip>(clock, device.motion);
}

std::unique_ptr<HapticDevice> make_foreign_device(const ForeignDriverSpec& spec, const DeviceSpec& device,
                                                  SimulatedGrip* grip, const std::string& path) {
  return std::make_unique<NamedDevice>(spec, DeviceRequest{.name = spec.part.name,
                                                           .device = device.name,
                                                           .options = spec.part.options,
                                                           .rate = device.rate,
                                                           .first_tick = RealTime{device.phase.ns},
                                                           .grip = grip,
                                                           .path = path,
                                                           .seed = spec.part.seed});
}

}  // namespace evenstep::internal
