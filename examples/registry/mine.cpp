// Parts of your own, and a program that is evenstep with them: `mine run mine.toml`, and so every other command.
#include <memory>

#include "evenstep/apps/command_line.h"
using namespace evenstep;

/// F = -k x. The same positions give the same forces, bit for bit; `mine run mine.toml --repeat` checks that.
class MySpring final : public ForeignSolver {
 public:
  ToolResponse step(std::span<const glm::dvec3> positions_m, double /*step_s*/) override {
    ToolResponse response;
    for (std::size_t tool = 0; tool < positions_m.size(); ++tool) response.force_N[tool] = positions_m[tool] * -200.0;
    return response;
  }
};

/// Measures the hand as it is, and drives its motors as it is told.
class MyArm final : public HapticDevice {
 public:
  explicit MyArm(SimulatedGrip& grip) : grip_(grip) {}
  DeviceSample read(RealTime) override { return {.position_m = grip_.hand_m(), .fresh = true}; }
  void write(const glm::dvec3& force_N) override { grip_.drive(force_N); }
  void stop() noexcept override { grip_.drive({}); }

 private:
  SimulatedGrip& grip_;
};

/// The steps of a segment are due at the pace of the scene, from the segment's begin on.
class MyMap final : public ForeignMap {
 public:
  explicit MyMap(const MapRequest& request) : step_rate_(request.step_rate) {}
  void boundary(std::int64_t n, RealTime begin) override {
    first_ = n;
    begin_ = begin;
  }
  std::optional<RealTime> slot(std::int64_t n) override { return tick_time(step_rate_, n - first_, begin_); }

 private:
  Rate step_rate_;
  std::int64_t first_ = 0;
  RealTime begin_;
};

/// 30 times a second: a visualization of 11.1 ms, then 15 steps one after the other.
class MyGpu final : public StepTiming {
 public:
  bool next(SegmentTiming& segment) override {
    const RealTime begin = tick_time({30, 1}, segments_, RealTime{0}), end = tick_time({30, 1}, segments_ + 1, RealTime{0});
    const RealTime drawn = begin + Duration{11'100'000};
    const std::int64_t step_ns = (end - drawn).ns / 15;
    segment = {.index = segments_++, .begin = begin, .visualization = Interval{begin, drawn}, .steps = {}, .end = end};
    for (std::int64_t n = 0; n < 15; ++n)
      segment.steps.push_back({drawn + Duration{n * step_ns}, n == 14 ? end : drawn + Duration{(n + 1) * step_ns}});
    return true;
  }

 private:
  std::int64_t segments_ = 0;
};

int main(int argc, char** argv) {
  Registry registry = builtin();
  registry.add_solver("my-spring", [](const SolverRequest&) { return std::make_unique<MySpring>(); });
  registry.add_device("my-arm", [](const DeviceRequest& request) { return std::make_unique<MyArm>(*request.grip); });
  registry.add_map("my-map", [](const MapRequest& request) { return std::make_unique<MyMap>(request); });
  registry.add_timing("my-gpu", [](const TimingRequest&) { return std::make_unique<MyGpu>(); });
  return command_line(argc, argv, registry);
}
