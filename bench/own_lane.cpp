// How much slower steps are beside a drawing: the factor of `evenstep size --own-lane`, for this machine, scene and solver.
//   build/bench/bench_own_lane SCENARIO [ROUNDS [STEPS]]
// A thread steps the solver of the scene as fast as it can, while the tools move as the scenario says. In every second block
// of STEPS steps another thread draws the tissue again and again ([timing] picture pixels, OpenGL ES off screen), so that
// every step of the block runs beside a drawing. A round is a block without drawings and one with. The two alternate in
// coming first, so that whatever the machine does hits both alike. The factor is the ratio of the mean steps, because a
// visualization in its own lane must leave time for as many steps as before. Half of the rounds lie in the range that is
// printed beside it. The ratio of the medians says how slow most steps are. What is drawn is a copy of the particles, which
// a simulator would have to make between two steps; that cost is not in the factor.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/draw/canvas.h"
#include "evenstep/draw/tissue_mesh.h"
#include "evenstep/format/reader.h"
#include "evenstep/loop/solver_step.h"

namespace {

using namespace evenstep;

double ms(Duration length) { return static_cast<double>(length.ns) * 1e-6; }

/// By nearest rank, 0 < share <= 1.
template <class T>
T quantile(std::vector<T> values, double share) {
  std::sort(values.begin(), values.end());
  const auto rank = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  return values[rank];
}

double mean_ms(const std::vector<Duration>& values) {
  Duration sum;
  for (const Duration value : values) sum = sum + value;
  return ms(sum) / static_cast<double>(values.size());
}

[[noreturn]] void refuse(const std::string& why) {
  fmt::print(stderr, "bench_own_lane: {}\n", why);
  std::exit(2);
}

/// Draws on a separate thread as long as it is asked to.
class DrawingLane {
 public:
  DrawingLane(Canvas& canvas, std::vector<glm::vec3> positions_m, const WallClock& clock)
      : canvas_(canvas), positions_m_(std::move(positions_m)), clock_(clock), thread_([this] { run(); }) {}
  ~DrawingLane() {
    want(Wanted::over);
    thread_.join();
  }
  /// Returns as soon as a drawing runs.
  void begin() {
    want(Wanted::drawings);
    while (!drawing_) std::this_thread::yield();
  }
  /// Returns as soon as no drawing runs.
  void end() {
    want(Wanted::nothing);
    while (drawing_) std::this_thread::yield();
  }
  const std::vector<Duration>& took() const { return took_; }  // between end() and begin()

 private:
  enum class Wanted { nothing, drawings, over };
  void want(Wanted wanted) {
    wanted_ = wanted;
    wanted_.notify_one();
  }
  void run() {
    for (;;) {
      wanted_.wait(Wanted::nothing);
      if (wanted_ == Wanted::over) return;
      drawing_ = true;
      while (wanted_ == Wanted::drawings) {
        const RealTime began = clock_.now();
        if (!canvas_.draw(positions_m_)) std::abort();
        took_.push_back(clock_.now() - began);
      }
      drawing_ = false;
    }
  }

  Canvas& canvas_;
  std::vector<glm::vec3> positions_m_;
  const WallClock& clock_;
  std::atomic<Wanted> wanted_{Wanted::nothing};
  std::atomic<bool> drawing_{false};
  std::vector<Duration> took_;
  std::thread thread_;  // the last member: it uses the others
};

/// The solver with the motions of the scenario.
class Steps {
 public:
  Steps(const Scenario& scenario, Solver& solver, const WallClock& clock)
      : scenario_(scenario), clock_(clock), step_(solver, quiet(scenario.scene)) {}
  Duration one() {
    const RealTime began = clock_.now();
    for (std::size_t tool = 0; tool < scenario_.devices.size(); ++tool)
      step_.give(static_cast<int>(tool), position_m(scenario_.devices[tool].motion, began), began);
    step_.begins(began);
    const RealTime called = clock_.now();
    step_.run();
    return clock_.now() - called;
  }
  std::vector<Duration> block(int count) {
    std::vector<Duration> took;
    for (int i = 0; i < count; ++i) took.push_back(one());
    return took;
  }

 private:
  static Scene quiet(Scene scene) {
    scene.needs_state_digest = scene.needs_energy = false;
    return scene;
  }
  const Scenario& scenario_;
  const WallClock& clock_;
  SolverStep step_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) refuse("bench_own_lane SCENARIO [ROUNDS [STEPS]]");
  const int rounds = argc > 2 ? std::atoi(argv[2]) : 15, steps = argc > 3 ? std::atoi(argv[3]) : 200;
  if (rounds < 1 || steps < 10) refuse("at least one round of 10 steps");
  const ReadResult scenario = read_scenario(argv[1], {});
  if (!scenario) refuse(scenario.error().front().message);
  const auto* tissue = std::get_if<TissueScene>(&scenario->scene.body);
  if (tissue == nullptr) refuse("only a tissue can be drawn");

  const WallClock clock(WallEpoch::in({}));
  const std::unique_ptr<Solver> solver = make_solver(scenario->solver, scenario->scene, scenario->solver_options);
  Steps stepping(*scenario, *solver, clock);
  stepping.block(steps);  // warm-up

  TissueMesh mesh(*tissue, 0);
  mesh.move(solver->particle_state(), std::vector<DrawnTool>(static_cast<std::size_t>(scenario->scene.tool_count)));
  const auto [width, height] = scenario->timing.picture_px;
  auto canvas = make_canvas(width, height, view_of(*tissue, width, height), mesh.mesh());
  if (!canvas) refuse(canvas.error().what + "; " + canvas.error().remedy);
  std::vector<Duration> drawn_alone;
  for (int i = 0; i < 20; ++i) {
    const RealTime began = clock.now();
    if (!(*canvas)->draw(mesh.mesh().positions_m)) refuse("the canvas does not draw");
    drawn_alone.push_back(clock.now() - began);
  }

  DrawingLane lane(**canvas, mesh.mesh().positions_m, clock);
  std::vector<Duration> alone, beside;
  std::vector<double> factors;
  for (int round = 0; round < rounds; ++round) {
    std::vector<Duration> without, with;
    for (const bool draws : {round % 2 == 1, round % 2 == 0}) {
      if (draws) lane.begin();
      (draws ? with : without) = stepping.block(steps);
      if (draws) lane.end();
    }
    factors.push_back(mean_ms(with) / mean_ms(without));
    alone.insert(alone.end(), without.begin(), without.end());
    beside.insert(beside.end(), with.begin(), with.end());
  }
  fmt::print("steps by {}, drawings of {} x {} pixels by {}\n",
             solver->info().device.empty() ? solver->info().name : solver->info().device, width, height,
             (*canvas)->device());
  const auto row = [](const char* what, const std::vector<Duration>& took) {
    fmt::print("{:<24} {:>6} of them: mean {:.3f} ms, p50 {:.3f} ms, p99 {:.3f} ms, max {:.3f} ms\n", what, took.size(),
               mean_ms(took), ms(quantile(took, 0.5)), ms(quantile(took, 0.99)), ms(quantile(took, 1)));
  };
  row("step alone", alone);
  row("step beside a drawing", beside);
  row("drawing alone", drawn_alone);
  row("drawing beside steps", lane.took());
  fmt::print("--own-lane {:.2f}: half of {} rounds lie between {:.2f} and {:.2f}; of the medians {:.2f}\n",
             mean_ms(beside) / mean_ms(alone), rounds, quantile(factors, 0.25), quantile(factors, 0.75),
             ms(quantile(beside, 0.5)) / ms(quantile(alone, 0.5)));
  return 0;
}
