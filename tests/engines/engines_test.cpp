// What a scenario cannot test: closed forms of the engines' springs, their state after a reset, what they say about
// instability.
#include "engines.h"

#include "catch.h"

using namespace engines;
using evenstep::ForeignSolver;
using evenstep::SolverRequest;

namespace {

constexpr double kStep_s = 1.0 / 450;

SolverRequest request(const std::string& options) { return {.options = options, .step_s = kStep_s}; }

/// The force after these steps with the hand at rest.
double held_N(ForeignSolver& solver, double x_m, int steps) {
  evenstep::ToolResponse response;
  const glm::dvec3 hand_m(x_m, 0, 0);
  for (int n = 0; n < steps; ++n) response = solver.step({&hand_m, 1}, kStep_s);
  return response.force_N[0].x;
}

/// The digest of the state after the hand has gone this way.
std::uint64_t digest_after(ForeignSolver& solver, const glm::dvec3& step_m, int steps) {
  for (int n = 1; n <= steps; ++n) {
    const glm::dvec3 hand_m = step_m * static_cast<double>(n);
    solver.step({&hand_m, 1}, kStep_s);
  }
  return solver.state_digest();
}

/// The velocity after a step of a particle of 50 g that starts 1 mm away from the rest place of two springs of 1 N/m, both
/// to the same fixed particle.
template <class Make>
double first_velocity_m_per_s(Make make) {
  const auto solver = make({.options = R"({"particles": {"mass": 0.05, "stiffness": 1, "rest": [[0, 0, 0], [0.1, 0, 0]],
      "displacement": [[0, 0, 0], [0.001, 0, 0]], "fixed": [0], "springs": [[0, 1], [0, 1]]}})",
                            .step_s = kStep_s,
                            .tool_count = 0});
  solver->step({}, kStep_s);
  return solver->particles().velocity_m_per_s[1].x;
}

}  // namespace

#ifdef ENGINES_MUJOCO
TEST_CASE("MuJoCo's weld is as soft as its solref and solimp say") {
  // With impedance d, time constant T and distance r from the hand, MuJoCo makes the acceleration (1 - d) a0 - r / T^2,
  // where a0 is the one without the weld. At rest it is 0 and a0 = -stiffness x / mass, so r = -(1 - d) T^2 stiffness / mass
  // x.
  const double stiffness = 200, mass = 0.05, d = 0.99, T = 0.0045;
  const double share = (1 - d) * T * T * stiffness / mass;
  const auto solver = make_mujoco(request("{}"));
  CHECK(held_N(*solver, 0.01, 5000) == Approx(-stiffness * 0.01 / (1 + share)).epsilon(1e-9));
}

TEST_CASE("MuJoCo's contacts are as before after a reset, and in another solver") {
  const std::string options = R"({"model": "box", "edge": 3})";
  const glm::dvec3 down_m(0, 0, -50e-6);
  const auto solver = make_mujoco(request(options)), other = make_mujoco(request(options));
  const std::uint64_t digest = digest_after(*solver, down_m, 150);
  CHECK(digest_after(*other, down_m, 150) == digest);
  solver->reset();
  CHECK(digest_after(*solver, down_m, 150) == digest);
}

TEST_CASE("MuJoCo resets an unstable scene by itself: the solver says so instead") {
  // The weld makes x'' = -((1 - d) k / m + 1 / T^2) x - 2 / T x'. Euler is stable while w^2 h^2 + 2 g h < 4, where g is the
  // damping of x'. Here that is up to k = 1.803 MN/m, 45 times as much as for the same body without a weld.
  const auto stable = make_mujoco(request(R"({"stiffness": 1.79e6, "damping": 0})"));
  CHECK(std::isfinite(held_N(*stable, 0.01, 20'000)));
  const auto unstable = make_mujoco(request(R"({"stiffness": 1.82e6, "damping": 0})"));
  CHECK_THROWS_WITH(held_N(*unstable, 0.01, 20'000), Catch::Contains("MuJoCo reset the scene"));
}

TEST_CASE("MuJoCo's springs in parallel add up") {
  CHECK(first_velocity_m_per_s(make_mujoco) == Approx(-2 * 1.0 * 0.001 / 0.05 * kStep_s));
}
#endif

#ifdef ENGINES_BULLET
TEST_CASE("Bullet's two springs in series are one of k1 k2 / (k1 + k2)") {
  const auto solver = make_bullet(request("{}"));
  CHECK(held_N(*solver, 0.01, 5000) == Approx(-0.01 * 200 * 2000 / 2200).epsilon(1e-9));
}

TEST_CASE("Bullet says nothing of an unstable spring: its force ends as no number") {
  const auto solver = make_bullet(request(R"({"stiffness": 1e7})"));
  CHECK_FALSE(std::isfinite(held_N(*solver, 0.01, 1000)));
}

TEST_CASE("Bullet's springs in parallel do not add up: two pull like one") {
  // Each spring is a row of the constraint solver. It asks for the speed that its own force would give, which the other
  // spring has given already.
  CHECK(first_velocity_m_per_s(make_bullet) == Approx(-1 * 1.0 * 0.001 / 0.05 * kStep_s));
}

TEST_CASE("Bullet's limit makes a spring softer than its stiffness, silently") {
  // The limit is m / (16 h^2), here 632.8 N/m.
  const double most = 0.05 / (16 * kStep_s * kStep_s);
  const auto solver = make_bullet(request(R"({"stiffness": 1e7, "coupling": 500, "limit": true})"));
  CHECK(held_N(*solver, 0.01, 5000) == Approx(-0.01 * most * 500 / (most + 500)).epsilon(1e-9));
}
#endif
