// Wall and mode, compared with their closed forms.

#include <cmath>
#include <limits>
#include <numbers>

#include "catch.h"
#include "evenstep/sim/scene.h"
#include "tissue_scenes.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

constexpr std::array kEveryKind{SolverKind::cpu_float, SolverKind::cpu_double, SolverKind::opencl};

Scene mode_scene(double frequency_Hz, double ratio, Rate step_rate, bool one_sided = false) {
  ModeScene mode;
  mode.stiffness_N_per_m = 300;
  mode.frequency_Hz = frequency_Hz;
  mode.damping_ratio = ratio;
  mode.one_sided = one_sided;
  Scene scene{mode};
  scene.step_rate = step_rate;
  return scene;
}

/// The force if the tool appears at x at t = 0 and stays there. The mass swings towards x / 2.
double exact_force_N(double x, double k, double frequency_Hz, double ratio, double t) {
  const double w = 2 * std::numbers::pi * frequency_Hz, damped = w * std::sqrt(1 - ratio * ratio);
  const double q =
      x / 2 * (1 - std::exp(-ratio * w * t) * (std::cos(damped * t) + ratio * w / damped * std::sin(damped * t)));
  return 2 * k * (q - x);
}

}  // namespace

TEST_CASE("A wall pushes with its law at every depth, along its normal, and never pulls", "[wall]") {
  for (const SolverKind kind : kEveryKind) {
    for (const double hardening : {0.0, 5e-3, 1e-4}) {
      const glm::dvec3 n(2.0 / 3, -1.0 / 3, 2.0 / 3);
      Scene scene{WallScene{250, n * 7.0, 0.01, hardening}};
      scene.tool_count = 2;
      const auto solver = make_solver(kind, scene);
      for (int i = -300; i <= 300; ++i) {
        const double gap = i * 1e-4, p = std::max(0.0, -gap);
        const glm::dvec3 aside(0.02 * i / 300, 0.04 * i / 300, 0);  // n . aside = 0
        const Positions x{n * (0.01 + gap) + aside, glm::dvec3(5)};
        const ToolResponse response = step(*solver, 2, x);
        const double expected = 250 * (p + (hardening > 0 ? p * p / hardening : 0));
        // The depth is a difference of numbers around 0.05 m, which round by some 1e-17 m; the slope multiplies that.
        const double rounding = 250 * (1 + (hardening > 0 ? 2 * p / hardening : 0)) * 1e-16 + 1e-13 * expected;
        for (int axis = 0; axis < 3; ++axis) REQUIRE(std::abs(response.force_N[0][axis] - n[axis] * expected) <= rounding);
        REQUIRE(response.force_N[1] == glm::dvec3(0));
      }
    }
  }
}

TEST_CASE("What a wall or a spring stores is the work against its force on the way there, hardening or not", "[wall]") {
  const glm::dvec3 n(2.0 / 3, -1.0 / 3, 2.0 / 3);
  std::vector<Scene> scenes{Scene{SpringScene{320}}};
  for (const double hardening : {0.0, 5e-3, 1e-3}) scenes.push_back(Scene{WallScene{250, n * 7.0, 0.01, hardening}});
  for (Scene& scene : scenes) {
    scene.tool_count = 1;
    const auto solver = make_solver(SolverKind::cpu_double, scene);
    double work_J = 0;
    const auto at = [&](int i) { return n * (0.012 - i * 1e-6); };  // from outside the wall into it, by 10 mm
    const double before_J = *stored_energy_J(scene, at(0));
    for (int i = 0; i < 12'000; ++i) {
      const glm::dvec3 middle = (at(i) + at(i + 1)) * 0.5, way = at(i + 1) - at(i);
      const glm::dvec3 force_N = step(*solver, 1, {middle}).force_N[0];
      work_J -= force_N.x * way.x + force_N.y * way.y + force_N.z * way.z;
    }
    // The midpoint rule over pieces of 1 um is off by some 1e-8 for a square.
    CHECK(*stored_energy_J(scene, at(12'000)) - before_J == Approx(work_J).epsilon(1e-6));
    CHECK(std::abs(work_J) > 1e-3);
  }
}

TEST_CASE("A wall's contact is its force's slope, with the gap and the normal, also before the touch", "[wall]") {
  Scene scene{WallScene{400, {0, 0, 3}, -0.02, 5e-3}};
  CHECK(make_solver(SolverKind::cpu_double, scene)->contacts().empty());
  scene.local_model = LocalModel::instantaneous;
  const auto solver = make_solver(SolverKind::cpu_double, scene);
  CHECK_FALSE(solver->contacts()[0].unilateral);  // nothing known yet
  const auto force = [&](double z) { return step(*solver, 1, {glm::dvec3(0.1, 0.2, z)}).force_N[0].z; };
  for (const double gap : {-8e-3, -1e-3, -1e-6, 1e-6, 3e-3}) {
    const double h = 1e-7, slope = (force(-0.02 + gap - h) - force(-0.02 + gap + h)) / (2 * h);
    force(-0.02 + gap);
    const ToolContact contact = solver->contacts()[0];
    CHECK(contact.unilateral);
    CHECK(contact.touching == (gap < 0));
    CHECK(contact.normal == glm::dvec3(0, 0, 1));
    CHECK(contact.gap_m == Approx(gap).epsilon(1e-9));
    CHECK(contact.point_m == glm::dvec3(0.1, 0.2, -0.02 + gap));
    const double k = contact.stiffness_N_per_m[2][2];
    CHECK(k == Approx(gap < 0 ? slope : 400).epsilon(1e-6));
    glm::dmat3 others = contact.stiffness_N_per_m;
    others[2][2] = 0;
    CHECK(others == glm::dmat3(0));
  }
  solver->reset();
  CHECK_FALSE(solver->contacts()[0].unilateral);  // nothing known again
}

TEST_CASE("A mode answers twice its stiffness at once and its stiffness in the end, ringing as its closed form", "[mode]") {
  for (const double frequency : {3.0, 30.0, 60.0, 400.0, 1000.0}) {
    for (const double ratio : {0.0, 0.1, 0.7}) {
      CAPTURE(frequency, ratio);
      const Rate rate{4500, 1};
      const auto solver = make_solver(SolverKind::cpu_double, mode_scene(frequency, ratio, rate));
      const double x = 4e-3, w = 2 * std::numbers::pi * frequency;
      const double h = 1.0 / 4500 / solver->info().substeps;
      CHECK(h <= 1e-4);
      for (int n = 1; n <= 900; ++n) {
        const double t = n / 4500.0, force = step(*solver, 1, {glm::dvec3(x, 0, 0)}).force_N[0].x;
        // The method is of second order. The frequency is off by (w h)^2 / 24 until the ringing has decayed, and the rest is
        // off by as much.
        const double turns = ratio > 0 ? std::min(w * t, 1 / ratio) : w * t;
        REQUIRE(std::abs(force - exact_force_N(x, 300, frequency, ratio, t)) <=
                300 * x * (w * h) * (w * h) / 24 * (turns + 3) * 1.5 + 1e-12);
      }
      if (ratio > 0 && frequency >= 30) {
        for (int n = 0; n < 9000; ++n) step(*solver, 1, {glm::dvec3(x, 0, 0)});
        CHECK(step(*solver, 1, {glm::dvec3(x, 0, 0)}).force_N[0].x == Approx(-300 * x).epsilon(1e-6));
      }
    }
  }
}

TEST_CASE("A mode's tool moves in a straight line within a step, so that many short steps and few long ones agree",
          "[mode]") {
  const auto coarse = make_solver(SolverKind::cpu_double, mode_scene(30, 0.1, {100, 1}));
  const auto fine = make_solver(SolverKind::cpu_double, mode_scene(30, 0.1, {10'000, 1}));
  glm::dvec3 before(0);
  for (int n = 0; n <= 20; ++n) {
    const glm::dvec3 x(1e-3 * (n * 7 % 11), 2e-3 * (n * 5 % 7), -1e-3 * n);
    const ToolResponse a = step(*coarse, 1, {x});
    ToolResponse b;
    // Step 0 only puts the tool in its place. It lasts as long as any other step.
    for (int i = 1; i <= 100; ++i) b = step(*fine, 1, {n == 0 ? x : before + (x - before) * (i / 100.0)});
    before = x;
    for (int axis = 0; axis < 3; ++axis) REQUIRE(a.force_N[0][axis] == Approx(b.force_N[0][axis]).margin(1e-9));
  }
}

TEST_CASE("A one-sided mode is the same along its normal while touched, and rings on its ground spring when left",
          "[mode]") {
  Scene one = mode_scene(30, 0.1, {450, 1}, true);
  one.local_model = LocalModel::instantaneous;
  const auto bilateral = make_solver(SolverKind::cpu_double, mode_scene(30, 0.1, {450, 1}));
  const auto unilateral = make_solver(SolverKind::cpu_double, one);
  for (int n = 0; n < 200; ++n) {
    const double x = -5e-3 - 2e-3 * (n * 13 % 17) / 17;  // pressed, whatever the mass does
    const double along = step(*bilateral, 1, {glm::dvec3(x, 0, 0)}).force_N[0].x;
    const ToolResponse pushed = step(*unilateral, 1, {glm::dvec3(x, 0.3, -0.2)});
    REQUIRE(along > 0);
    REQUIRE(pushed.force_N[0].x == Approx(along).epsilon(1e-12));
    REQUIRE((pushed.force_N[0].y == 0 && pushed.force_N[0].z == 0));
    const ToolContact contact = unilateral->contacts()[0];
    REQUIRE(contact.gap_m == Approx(-along / 600).epsilon(1e-12));
    REQUIRE((contact.touching && contact.unilateral && contact.stiffness_N_per_m[0][0] == 600));
  }
  // The tool is away: nothing is felt, and the surface swings at f0 / sqrt(2), so it crosses its rest place every 1 / (2 f).
  std::vector<double> crossings;
  double last = 0;
  for (int n = 0; n < 100; ++n) {
    REQUIRE(step(*unilateral, 1, {glm::dvec3(0.1, 0, 0)}).force_N[0] == glm::dvec3(0));
    const double q = 0.1 - unilateral->contacts()[0].gap_m;
    if (n > 0 && q * last < 0) crossings.push_back((n - q / (q - last)) / 450.0);
    last = q;
  }
  REQUIRE(crossings.size() >= 4);
  const double period = 2 * (crossings[3] - crossings[0]) / 3;
  // The damping c is as before. At the frequency of the ground spring alone its ratio is 0.1 sqrt(2).
  CHECK(1 / period == Approx(30 / std::sqrt(2) * std::sqrt(1 - 0.02)).epsilon(3e-3));
}

TEST_CASE("A one-sided mode's surface is where the scene puts it, along a normal of any length", "[mode]") {
  Scene here = mode_scene(30, 0.1, {450, 1}, true), there = here;
  here.local_model = there.local_model = LocalModel::instantaneous;
  const glm::dvec3 n(2.0 / 3, -1.0 / 3, 2.0 / 3);
  auto& moved = std::get<ModeScene>(there.body);
  moved.normal = n * 5.0;
  moved.surface_m = -0.02;
  const auto at_origin = make_solver(SolverKind::cpu_double, here), elsewhere = make_solver(SolverKind::cpu_double, there);
  int touched = 0;
  for (int i = 0; i < 300; ++i) {
    const double gap_m = 4e-3 * ((i * 29 % 37) / 18.0 - 1);
    const glm::dvec3 aside(0.02 * i / 300, 0.04 * i / 300, 0);  // n . aside = 0
    const double push_N = step(*at_origin, 1, {glm::dvec3(gap_m, 0, 0)}).force_N[0].x;
    const glm::dvec3 force_N = step(*elsewhere, 1, {n * (gap_m - 0.02) + aside}).force_N[0];
    const ToolContact &a = at_origin->contacts()[0], &b = elsewhere->contacts()[0];
    // Room for some roundings of positions around 0.05 m (7e-18), which the mass remembers, times 600 N/m.
    for (int axis = 0; axis < 3; ++axis) REQUIRE(std::abs(force_N[axis] - n[axis] * push_N) <= 1e-11);
    REQUIRE(std::abs(a.gap_m - b.gap_m) <= 1e-14);
    REQUIRE(norm(b.normal - n) <= 1e-15);
    touched += a.touching;
  }
  CHECK((touched > 50 && touched < 250));
}

TEST_CASE("A mode's local model is its stiffness at once or its stiffness at rest", "[mode]") {
  for (const auto& [model, k] : {std::pair{LocalModel::instantaneous, 600.0}, std::pair{LocalModel::settled, 300.0}}) {
    Scene scene = mode_scene(30, 0.1, {450, 1});
    scene.local_model = model;
    const auto solver = make_solver(SolverKind::cpu_double, scene);
    step(*solver, 1, {glm::dvec3(1e-3, 0, 0)});
    CHECK(solver->contacts()[0].stiffness_N_per_m == glm::dmat3(k));
    CHECK(solver->contacts()[0].touching);
    CHECK_FALSE(solver->contacts()[0].unilateral);
  }
}

TEST_CASE("A mode is the same bits for every solver kind and after a reset, tool by tool, and its digest sees it move",
          "[mode]") {
  Scene scene = mode_scene(30, 0.1, {450, 1});
  scene.tool_count = 2;
  std::vector<ToolResponse> first;
  std::vector<std::uint64_t> digests;
  for (const SolverKind kind : kEveryKind) {
    const auto solver = make_solver(kind, scene);
    for (int round = 0; round < 2; ++round) {
      for (int n = 0; n < 200; ++n) {
        const ToolResponse response = step(*solver, 2, wandering_tools(n));
        const std::uint64_t digest = solver->state_digest();
        if (first.size() < 200) {
          first.push_back(response);
          if (n > 0) REQUIRE(digest != digests.back());
          digests.push_back(digest);
        }
        REQUIRE(same_bits(response, first[static_cast<std::size_t>(n)]));
        REQUIRE(digest == digests[static_cast<std::size_t>(n)]);
      }
      solver->reset();
    }
  }
  // Each tool has its own mass.
  Scene alone = scene;
  alone.tool_count = 1;
  const auto solver = make_solver(SolverKind::cpu_double, alone);
  for (int n = 0; n < 200; ++n)
    REQUIRE(step(*solver, 1, wandering_tools(n)).force_N[0] == first[static_cast<std::size_t>(n)].force_N[0]);
}

TEST_CASE("A mode takes steps of any length where the scene asks for it, and refuses them where not", "[mode]") {
  Scene scene = mode_scene(30, 0.1, {450, 1});
  const auto fixed = make_solver(SolverKind::cpu_double, scene);
  CHECK_THROWS_AS(fixed->step(std::array{glm::dvec3(0)}, 0.01), SolverError);
  CHECK_NOTHROW(fixed->step(std::array{glm::dvec3(0)}, 1.0 / 450));
  scene.variable_step = true;
  const auto variable = make_solver(SolverKind::cpu_double, scene);
  CHECK_THROWS_AS(variable->step(std::array{glm::dvec3(0)}, -1.0), SolverError);
  double t = 0;
  for (int n = 1; n <= 200; ++n) {
    const double length = 1e-3 * (1 + n % 40);
    t += length;
    const double force = variable->step(std::array{glm::dvec3(1e-3, 0, 0)}, length).force_N[0].x;
    REQUIRE(force == Approx(exact_force_N(1e-3, 300, 30, 0.1, t)).margin(0.3 * 5e-4));
  }
}

TEST_CASE(
    "Walls and modes without stiffness, normal, frequency or damping, and positions that are no numbers, are refused") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const auto refused = [](const Scene& scene, const std::string& word) {
    CHECK_THROWS_WITH(make_solver(SolverKind::cpu_double, scene), Catch::Contains(word));
  };
  for (const double bad : {0.0, -1.0, nan, inf}) {
    refused(Scene{WallScene{bad}}, "stiffness");
    refused(Scene{ModeScene{bad}}, "stiffness");
    refused(Scene{ModeScene{100, bad}}, "frequency");
  }
  for (const glm::dvec3& bad : {glm::dvec3(0), glm::dvec3(nan, 0, 1), glm::dvec3(inf, 0, 0)}) {
    refused(Scene{WallScene{100, bad}}, "normal");
    refused(Scene{ModeScene{100, 30, 0.1, true, bad}}, "normal");
  }
  refused(Scene{WallScene{100, {1, 0, 0}, nan}}, "surface");
  refused(Scene{ModeScene{100, 30, 0.1, true, {1, 0, 0}, inf}}, "surface");
  refused(Scene{WallScene{100, {1, 0, 0}, 0, -1}}, "hardening");
  for (const double bad : {-0.1, nan}) refused(Scene{ModeScene{100, 30, bad}}, "damping");
  refused(Scene{ModeScene{100, 1e9}}, "substeps");
  for (const Scene& scene : {Scene{WallScene{}}, Scene{ModeScene{}}}) {
    const auto solver = make_solver(SolverKind::cpu_double, scene);
    CHECK_THROWS_AS(step(*solver, 1, {glm::dvec3(0, nan, 0)}), SolverError);
  }
}
