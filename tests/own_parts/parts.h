#pragma once
// Parts that a program adds, as small as possible.

#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "evenstep/format/registry.h"

namespace own_parts {

/// F = -k x, and nothing but a step. options = { stiffness = 200 } in N/m.
class MySpring final : public evenstep::ForeignSolver {
 public:
  explicit MySpring(const evenstep::SolverRequest& request)
      : stiffness_N_per_m_(nlohmann::json::parse(request.options).at("stiffness")) {}
  evenstep::ToolResponse step(std::span<const glm::dvec3> positions_m, double) override {
    evenstep::ToolResponse response;
    for (std::size_t tool = 0; tool < positions_m.size(); ++tool)
      response.force_N[tool] = positions_m[tool] * -stiffness_N_per_m_;
    return response;
  }

 private:
  double stiffness_N_per_m_;
};

/// Reads the true position of the hand, and drives its motors as it is told.
class MyArm : public evenstep::HapticDevice {
 public:
  explicit MyArm(evenstep::SimulatedGrip& grip) : grip_(grip) {}
  evenstep::DeviceSample read(evenstep::RealTime) override { return {.position_m = grip_.hand_m(), .fresh = true}; }
  void write(const glm::dvec3& force_N) override { grip_.drive(force_N); }
  void stop() noexcept override { grip_.drive({}); }

 private:
  evenstep::SimulatedGrip& grip_;
};

/// The steps of a segment are due at the pace of the scene, from the begin of the segment on.
class MyPacer final : public evenstep::ForeignMap {
 public:
  explicit MyPacer(const evenstep::MapRequest& request) : step_rate_(request.step_rate) {}
  void boundary(std::int64_t n, evenstep::RealTime begin) override {
    first_ = n;
    begin_ = begin;
  }
  std::optional<evenstep::RealTime> slot(std::int64_t n) override {
    return evenstep::tick_time(step_rate_, n - first_, begin_);
  }

 private:
  evenstep::Rate step_rate_;
  std::int64_t first_ = 0;
  evenstep::RealTime begin_;
};

/// The timing of the paper's figure 1; options = { jitter = 0.1 } lets it vary.
inline std::unique_ptr<evenstep::StepTiming> my_gpu(const evenstep::TimingRequest& request) {
  evenstep::ProgrammedTiming timing;
  timing.visualization_variation = nlohmann::json::parse(request.options).value("jitter", 0.0);
  timing.seed = request.seed;
  return evenstep::make_programmed_timing(timing);
}

inline evenstep::Registry registry() {
  evenstep::Registry mine = evenstep::builtin();
  mine.add_solver("my-spring", [](const evenstep::SolverRequest& request) { return std::make_unique<MySpring>(request); });
  mine.add_device("my-arm", [](const evenstep::DeviceRequest& request) { return std::make_unique<MyArm>(*request.grip); });
  mine.add_map("my-pacer", [](const evenstep::MapRequest& request) { return std::make_unique<MyPacer>(request); });
  mine.add_timing("my-gpu", my_gpu);
  return mine;
}

}  // namespace own_parts
