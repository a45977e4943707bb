#include "evenstep/harness/visualization.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/draw/canvas.h"
#include "evenstep/draw/tissue_svg.h"
#include "evenstep/loop/solver_step.h"
#include "evenstep/reports/run_failure.h"
#include "evenstep/sim/busy_device.h"

namespace evenstep {
namespace {

/// While nobody knows the largest force, a drawing shows 1 N as this share of the block's size.
constexpr double kArrowPerNewton = 0.3;
/// A picture of a run shows its largest force as this share of it.
constexpr double kLongestArrow = 0.4;

RunFailure cannot_draw(const DrawError& error) { return {"visualization", error.what, error.remedy}; }

/// How much of a drawing one run of a visualization may do, and how much is done.
class Progress {
 public:
  static constexpr int kWhole = kWholeDrawing;

  void begins(const DrawingPart& part) {
    part_ = part;
    if (done_ == kWhole) done_ = 0;
    int n = done_ * part.parts / kWhole;
    do end_ = ++n * kWhole / part.parts;  // rounded down, so it may be where the part before ended
    while (end_ <= done_);
  }
  int done() const { return done_; }
  bool finished() const { return done_ == kWhole; }
  /// The point to draw up to next, after so long in this run; done() if no more fits. A drawing that can be cut off goes on
  /// in thirtieths. Each is expected to take as long as the longest so far; the first one is always done.
  int next(Duration spent) const {
    if (!part_.at_most) return end_;
    if (spent.ns > 0 && spent + longest_ > *part_.at_most) return done_;
    return std::min(done_ + kWhole / 30, end_);
  }
  void did(int until, Duration took) {
    longest_ = done_ == 0 ? took : std::max(longest_, took);
    done_ = until;
  }

 private:
  DrawingPart part_;
  int done_ = kWhole, end_ = kWhole;
  Duration longest_;  // of the steps of next() in this drawing
};

/// Draws the tissue as the solver has left it when the drawing begins.
class Render final : public RealVisualization {
 public:
  Render(const Scenario& scenario, const TissueScene& tissue, WatchedSolver& solver)
      : clock_(WallEpoch::in({})), solver_(solver), mesh_(tissue, kArrowPerNewton * block_size_m(tissue)) {
    const auto [width, height] = scenario.timing.picture_px;
    auto canvas = make_canvas(width, height, view_of(tissue, width, height), mesh_.mesh());
    if (!canvas) throw cannot_draw(canvas.error());
    canvas_ = *std::move(canvas);
    text_ = fmt::format("the tissue is drawn, {} x {} pixels, by {}", width, height, canvas_->device());
  }
  void begins(Duration, const DrawingPart& part) override { progress_.begins(part); }
  void run() override {
    const RealTime began = clock_.now();
    if (progress_.done() == 0) mesh_.move(solver_.particle_state(), solver_.tools());
    RealTime now = began;
    for (int to = progress_.next({}); to > progress_.done(); to = progress_.next(now - began)) {
      const auto drawn = canvas_->draw_share(mesh_.mesh().positions_m, progress_.done(), to);
      if (!drawn) throw cannot_draw(drawn.error());
      const RealTime before = now;
      now = clock_.now();
      progress_.did(to, now - before);
    }
  }
  bool finished() const override { return progress_.finished(); }
  const std::string& text() const override { return text_; }
  std::string png() override { return png_of(canvas_->image()).value_or(""); }

 private:
  WallClock clock_;
  WatchedSolver& solver_;
  TissueMesh mesh_;
  std::unique_ptr<Canvas> canvas_;
  Progress progress_;
  std::string text_;
};

/// Launches of about a millisecond; the last one is as long as what is left. Their size comes from the time of those before.
class Burn final : public RealVisualization {
 public:
  explicit Burn(std::unique_ptr<BusyDevice> device) : clock_(WallEpoch::in({})), device_(std::move(device)) {
    for (std::int64_t rounds = 64;; rounds *= 2) {
      const Duration took = launch(rounds);
      rounds_per_ns_ = static_cast<double>(rounds) / static_cast<double>(std::max<std::int64_t>(took.ns, 1));
      if (took >= kLaunch || rounds > kMostRounds / 2) break;
    }
  }
  void begins(Duration programmed, const DrawingPart& part) override {
    length_ = programmed;
    finished_ = part.finishes;
  }
  bool finished() const override { return finished_; }
  void run() override {
    const RealTime end = clock_.now() + length_;
    for (Duration left = length_; left > kTooShort; left = end - clock_.now()) {
      const double rounds = rounds_per_ns_ * static_cast<double>(std::min(left, kLaunch).ns);
      const auto whole = static_cast<std::int64_t>(std::clamp(rounds, 1.0, static_cast<double>(kMostRounds)));
      const Duration took = launch(whole);
      // A launch that something else has held up says little about the next one.
      if (left > kLaunch && took.ns > 0)
        rounds_per_ns_ += 0.2 * (static_cast<double>(whole) / static_cast<double>(took.ns) - rounds_per_ns_);
    }
  }
  const std::string& text() const override { return text_; }

 private:
  static constexpr Duration kLaunch{1'000'000}, kTooShort{20'000};
  static constexpr std::int64_t kMostRounds = 1'000'000'000;

  Duration launch(std::int64_t rounds) {
    const RealTime began = clock_.now();
    device_->run(rounds);
    return clock_.now() - began;
  }

  WallClock clock_;
  std::unique_ptr<BusyDevice> device_;
  double rounds_per_ns_ = 1;
  Duration length_;
  bool finished_ = true;
  std::string text_ = "a kernel kept the compute device busy, for the length that the scenario gives";
};

std::unique_ptr<RealVisualization> make_burn(const Scenario& scenario) {
  try {
    return std::make_unique<Burn>(make_busy_device(scenario.solver_options));
  } catch (const SolverError& error) {
    throw run_failure(error);
  }
}

std::string caption_of(const Scenario& scenario, const TissuePose& pose) {
  std::string forces;
  for (std::size_t tool = 0; tool < scenario.devices.size() && tool < pose.tools.size(); ++tool)
    forces += fmt::format("{}{} {:.3g} N ({})", tool == 0 ? "" : ", ", scenario.devices[tool].name,
                          glm::length(pose.tools[tool].force_N), tool == 0 ? "blue" : "green");
  return fmt::format(
      "The tissue after step {}, where the forces on the hands are largest: {}. An arrow is the force on the hand, dashed "
      "where it is in the block. The box in dashes is the block at rest; grey does not move.",
      pose.step + 1, forces);
}

}  // namespace

std::unique_ptr<RealVisualization> make_visualization(const Scenario& scenario, WatchedSolver& solver) {
  switch (scenario.timing.work) {
    case VisualizationWork::pause:
      return nullptr;
    case VisualizationWork::burn:
      return make_burn(scenario);
    case VisualizationWork::render:
      break;
  }
  const auto& tissue = std::get<TissueScene>(scenario.scene.body);  // the reader refuses other scenes
  if (tissue.particle_count > kMostDrawnParticles)
    throw cannot_draw({fmt::format("{} particles cannot be drawn", tissue.particle_count),
                       fmt::format("at most {}, or \"burn 11.1 ms\" in place of \"render\"", kMostDrawnParticles)});
  return std::make_unique<Render>(scenario, tissue, solver);
}

std::int64_t steps_between_poses(const Scene& scene) {
  const auto* tissue = std::get_if<TissueScene>(&scene.body);
  if (tissue == nullptr || tissue->particle_count > kMostDrawnParticles) return 0;
  return std::max<std::int64_t>(scene.step_rate.num / scene.step_rate.den / 30, 1);
}

TissuePicture picture_of(const Scenario& scenario, const WatchedSolver& solver) {
  const auto* tissue = std::get_if<TissueScene>(&scenario.scene.body);
  if (tissue == nullptr || !solver.most_forceful()) return {};
  const TissuePose& pose = *solver.most_forceful();
  double largest_N = 0;
  for (const DrawnTool& tool : pose.tools) largest_N = std::max(largest_N, glm::length(tool.force_N));
  TissueMesh mesh(*tissue, largest_N > 0 ? kLongestArrow * block_size_m(*tissue) / largest_N : 0);
  mesh.move(pose.state, pose.tools);
  SvgPicture picture;
  picture.title = scenario.name;
  const auto [nx, ny, nz] = tissue->lattice;
  picture.outline_m = tissue->spacing_m * glm::dvec3(nx - 1, ny - 1, nz - 1);
  return {tissue_svg(mesh.mesh(), view_of(*tissue, picture.width, picture.height), picture), caption_of(scenario, pose)};
}

}  // namespace evenstep
