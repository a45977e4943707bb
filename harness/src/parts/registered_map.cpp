#include "registered_map.h"

#include <fmt/format.h>

#include "evenstep/reports/run_failure.h"

namespace evenstep::internal {
namespace {

class ForeignAsSlotMap final : public SlotMap {
 public:
  ForeignAsSlotMap(const ForeignMapSpec& spec, Rate step_rate, Duration lead, const AdaptiveLatency& latency)
      : SlotMap(lead, latency), name_(spec.name) {
    if (!spec.make) throw failed("it is not registered", "register it in the program that runs the scenario");
    map_ = guarded([&] { return spec.make({spec.name, spec.options, step_rate, spec.seed}); });
    if (!map_) throw failed("its factory returned nothing", "return a map, or throw why there is none");
  }
  void boundary(std::int64_t n, RealTime begin) override {
    guarded([&] { map_->boundary(n, begin); });
  }

 protected:
  void began(std::int64_t n, RealTime at) override {
    begin_ = at;
    guarded([&] { map_->began(n, at); });
  }
  void ended(std::int64_t n, RealTime at) override {
    guarded([&] { map_->ended(n, at); });
  }
  std::optional<RealTime> slot(std::int64_t n) override {
    const std::optional<RealTime> slot = guarded([&] { return map_->slot(n); });
    if (slot && (*slot < begin_ - kFarthestSlot || *slot > begin_ + kFarthestSlot))
      throw failed(fmt::format("step {}, which begins at {} ns, has its slot at {} ns, more than {:g} s away", n, begin_.ns,
                               slot->ns, seconds(kFarthestSlot)),
                   "return the real time in ns at which the step would be due if steps were even");
    return slot;
  }

 private:
  template <class Call>
  auto guarded(Call call) const -> decltype(call()) {
    try {
      return call();
    } catch (const std::exception& error) {
      throw failed(error.what(), "see what the map does there");
    } catch (...) {
      throw failed("it threw something that is no std::exception", "throw std::runtime_error");
    }
  }
  RunFailure failed(const std::string& what, const std::string& remedy) const {
    return RunFailure("map", fmt::format("the map '{}': {}", name_, what), remedy);
  }

  std::string name_;
  std::unique_ptr<ForeignMap> map_;
  RealTime begin_;  // of the step about to run
};

}  // namespace

std::unique_ptr<SlotMap> foreign_map(const MapSetup& setup, Duration lead, const AdaptiveLatency& latency) {
  return std::make_unique<ForeignAsSlotMap>(*setup.remap.foreign, setup.step_rate, lead, latency);
}

}  // namespace evenstep::internal
