// Solvers that the program registers.
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>

#include "evenstep/sim/solver.h"
#include "support.h"

using namespace evenstep;
using namespace own_parts;
using Catch::Contains;

namespace {

/// A spring of 200 N/m with everything that a solver may have. Each feature can be switched off.
struct FullSpring : ForeignSolver {
  explicit FullSpring(SolverCapabilities capabilities) : has(capabilities) {}
  ToolResponse step(std::span<const glm::dvec3> positions_m, double step_s) override {
    ToolResponse response;
    energy = 0;
    for (std::size_t tool = 0; tool < positions_m.size(); ++tool) {
      const glm::dvec3& x = positions_m[tool];
      response.force_N[tool] = x * -200.0;
      energy += 100 * (x.x * x.x + x.y * x.y + x.z * x.z);
      touched[tool] = {.touching = true, .point_m = x, .stiffness_N_per_m = glm::dmat3(200)};
    }
    tools = positions_m.size();
    passed_s += step_s;
    return response;
  }
  SolverCapabilities capabilities() const override { return has; }
  std::span<const ToolContact> contacts() const override { return {touched.data(), tools}; }
  std::uint64_t state_digest() override { return 7; }
  double energy_J() override { return energy; }
  ParticleState particles() override { return {{glm::dvec3(passed_s, 0, 0)}, {glm::dvec3(0)}}; }
  void reset() override { passed_s = 0; }

  SolverCapabilities has;
  std::array<ToolContact, kMaxTools> touched{};
  std::size_t tools = 0;
  double energy = 0, passed_s = 0;
};

Registry with(const SolverCapabilities& has) {
  Registry mine = registry();
  mine.add_solver("full", [has](const SolverRequest&) { return std::make_unique<FullSpring>(has); });
  return mine;
}

/// A spring that does something different at each step. Each solver counts its steps from 0.
struct Odd : ForeignSolver {
  explicit Odd(std::function<double(std::int64_t)> at_step) : extra_N(std::move(at_step)) {}
  ToolResponse step(std::span<const glm::dvec3> positions_m, double) override {
    return {{positions_m[0] * -200.0 + glm::dvec3(extra_N(n++), 0, 0)}};
  }
  std::function<double(std::int64_t)> extra_N;
  std::int64_t n = 0;
};

Registry with_odd(const std::function<double(std::int64_t)>& at_step) {
  Registry mine = registry();
  mine.add_solver("odd", [at_step](const SolverRequest&) { return std::make_unique<Odd>(at_step); });
  return mine;
}

std::unique_ptr<Solver> solver_of(const SolverFactory& make, const Scene& as = {}) {
  Scene scene = as;
  scene.body = ForeignScene{"mine", "{}", make};
  return make_solver(SolverKind::cpu_double, scene);
}

}  // namespace

TEST_CASE("A solver with nothing but step() gives the trace of evenstep's own spring, in every strategy") {
  const std::string all = R"(run.strategies=["ideal", "direct", "paper", "phase_locked", "predict", "variable_step"])";
  const RunRecord mine = record({kMySpring, all}), own = record({all});
  CHECK(mine.trace_hash == own.trace_hash);
  for (const StrategyRecord& one : own.strategies) CHECK(strategy(mine, one.name).trace_hash == one.trace_hash);
  // In both, the scene has no state to digest, so the forces are compared. They are not all zero.
  CHECK(strategy(mine, "phase_locked").devices[0].ticks.back().force_N[0] < -1);
}

TEST_CASE("What a solver lacks is left out and named, whatever it has") {
  const SolverCapabilities none, all{true, true, true, true, true};
  const auto lacks = [](const SolverCapabilities& has) {
    return strategy(record({scene_of("full")}, with(has)), "direct").solver.lacks;
  };
  using Names = std::vector<std::string>;
  CHECK(lacks(none) == Names{"contacts", "state_digest", "energy", "particles", "reset"});
  CHECK(lacks(all) == Names{});
  CHECK(lacks({.energy = true}) == Names{"contacts", "state_digest", "particles", "reset"});
  const RunRecord run = record({scene_of("full")}, with(none));
  CHECK(run.left_out == Names{"particles", "variable step", "state digest", "energy", "local model"});
  CHECK(strategy(run, "direct").solver.name == "full");
}

TEST_CASE("An expectation on energy is an error with the reason if the solver has none, and is judged if it has") {
  const std::string energy = R"(expect=[{ signal = "solver.phase_locked", metric = "energy_growth", max = "1e-9" }])";
  const RunOutcome without = run({scene_of("full"), energy}, with({.contacts = true}));
  CHECK(without.exit == ExitCode::usage);
  REQUIRE(without.errors.size() == 1);
  CHECK_THAT(without.errors[0].message,
             Contains("the solver 'full' has no energy") && Contains("it lacks state_digest, energy, particles, reset"));
  // A spring gives back what is put into it, as the trapezoidal rule is exact for a linear force.
  const RunOutcome has = run({scene_of("full"), energy}, with({.energy = true}));
  CHECK(has.exit == ExitCode::pass);
  REQUIRE(has.results.size() == 1);
  CHECK(has.results[0].value);
}

TEST_CASE("Energy that nothing explains is found, and energy that is not a number is infinite growth") {
  struct Source : FullSpring {
    Source(double more_J, std::int64_t at) : FullSpring({.energy = true}), more(more_J), from(at) {}
    double energy_J() override { return energy + (n++ >= from ? more : 0); }
    double more;
    std::int64_t from, n = 0;
  };
  Scene scene;
  scene.needs_energy = true;
  const auto growth = [&](double more_J) {
    const auto solver = solver_of([more_J](const SolverRequest&) { return std::make_unique<Source>(more_J, 5); }, scene);
    for (int step = 0; step < 10; ++step) solver->step(std::array{glm::dvec3(0.1 * step, 0, 0)});
    return solver->verdict();
  };
  CHECK(growth(0).energy_growth < 1e-12);
  // At the end the spring holds 100 0.9^2 = 81 J, and step 5 added 8.1 J.
  CHECK(growth(8.1).energy_growth == Approx(8.1 / (81 + 8.1)));
  CHECK(growth(std::numeric_limits<double>::quiet_NaN()).energy_growth == std::numeric_limits<double>::infinity());
  CHECK(growth(std::numeric_limits<double>::quiet_NaN()).first_bad_step == 5);
}

TEST_CASE("A local renderer needs contacts: without them it is refused, with them it is the spring's") {
  const std::string local = R"(device.left.render={ kind = "local" })";
  const RunOutcome without = run({scene_of("full"), local}, with({}));
  CHECK(without.exit == ExitCode::usage);
  CHECK_THAT(text_of(without.errors), Contains("the solver 'full' has no contacts"));
  CHECK(record({scene_of("full"), local}, with({.contacts = true})).trace_hash == record({local}).trace_hash);
}

TEST_CASE("A digest of the state, or of the particles, is part of the trace") {
  const auto hash = [](const SolverCapabilities& has) { return record({scene_of("full")}, with(has)).trace_hash; };
  const std::uint64_t forces = hash({});
  CHECK(hash({.energy = true, .reset = true}) == forces);
  CHECK(hash({.state_digest = true}) != forces);
  CHECK(hash({.particles = true}) != forces);
  CHECK(hash({.particles = true}) != hash({.state_digest = true}));
  CHECK(hash({.particles = true}) == hash({.particles = true}));
}

TEST_CASE("A solver is told the length of every step, nominal or not") {
  std::vector<double> lengths;
  struct Noting : ForeignSolver {
    explicit Noting(std::vector<double>& kept) : to(kept) {}
    ToolResponse step(std::span<const glm::dvec3>, double step_s) override { return to.push_back(step_s), ToolResponse{}; }
    std::vector<double>& to;
  };
  Registry mine;
  mine.add_solver("noting", [&](const SolverRequest& request) {
    CHECK(request.step_s == Approx(1.0 / 450));
    return std::make_unique<Noting>(lengths);
  });
  record({scene_of("noting"), R"(run.strategies=["direct"])"}, mine);
  REQUIRE(lengths.size() == 225);
  for (const double length : lengths) REQUIRE(length == lengths.front());
  lengths.clear();
  record({scene_of("noting"), R"(run.strategies=["variable_step"])"}, mine);
  REQUIRE(lengths.size() == 225);
  CHECK(lengths[14] == Approx(1.4822e-3).epsilon(1e-3));
  CHECK(lengths[15] == Approx(1.4822e-3 + 11.1e-3).epsilon(1e-3));  // a visualization lies between
}

TEST_CASE("A run with --repeat names a solver that is not reproducible, in its forces or only in its state") {
  RunOptions twice;
  twice.repeat = true;
  std::atomic<int> made{0};
  Registry mine = registry();
  mine.add_solver("odd", [&](const SolverRequest&) {
    const int which = made++;
    return std::make_unique<Odd>([which](std::int64_t n) { return n == 100 ? 1e-9 * which : 0; });
  });
  const RunOutcome forces = run({scene_of("odd")}, mine, twice);
  CHECK(forces.exit == ExitCode::not_reproducible);
  CHECK_THAT(forces.repeat_difference,
             Contains("the solver 'odd' gave another force for the same positions at step 100: it is not reproducible"));

  struct Digest : FullSpring {
    explicit Digest(std::uint64_t d) : FullSpring({.state_digest = true}), digest(d) {}
    std::uint64_t state_digest() override { return digest; }
    std::uint64_t digest;
  };
  mine.add_solver("digest", [&](const SolverRequest&) { return std::make_unique<Digest>(made++); });
  CHECK_THAT(run({scene_of("digest")}, mine, twice).repeat_difference,
             Contains("the solver 'digest' gave another digest of its state"));
  CHECK(run({kMySpring}, mine, twice).exit == ExitCode::pass);
}

TEST_CASE("Threads and the order of simultaneous events change nothing for a solver of the program") {
  const std::string sine = R"({ kind = "sine", amplitude = ["2 cm", "1 cm", "0 m"], frequency = "1.3 Hz" })";
  const std::string two =
      fmt::format(R"(device=[{{ name = "a", motion = {} }}, {{ name = "b", phase = "0.5 ms", motion = {} }}])", sine, sine);
  RunOptions options;
  options.threads = 1;
  const RunRecord one = record({kMySpring, two}, registry(), options);
  options.threads = 2;
  CHECK(record({kMySpring, two}, registry(), options).trace_hash == one.trace_hash);
  options.control.worker_thread = true;
  CHECK(record({kMySpring, two}, registry(), options).trace_hash == one.trace_hash);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    RunOptions permuted;
    permuted.control.permute_ties = seed;
    const RunRecord shuffled = record({kMySpring, two}, registry(), permuted);
    for (const std::size_t tool : {0u, 1u})
      CHECK(strategy(shuffled, "phase_locked").devices[tool].ticks.back().force_N ==
            strategy(one, "phase_locked").devices[tool].ticks.back().force_N);
  }
}

TEST_CASE("A solver that fails stops the run with its name, its step and its own words") {
  const auto failing = [](const std::function<double(std::int64_t)>& at_step) {
    return run({scene_of("odd")}, with_odd(at_step));
  };
  const RunOutcome thrown =
      failing([](std::int64_t n) -> double { return n < 7 ? 0 : throw std::runtime_error("mesh inverted"); });
  CHECK(thrown.exit == ExitCode::run_failed);
  CHECK_THAT(thrown.failure, Contains("the solver 'odd', step 7: mesh inverted"));
  const RunOutcome other = failing([](std::int64_t n) -> double { return n < 7 ? 0 : throw 3; });
  CHECK_THAT(other.failure, Contains("the solver 'odd', step 7: it threw something that is no std::exception"));
  const RunOutcome unstable = failing([](std::int64_t n) -> double {
    return n < 7 ? 0 : throw SolverError(SolverFault::unstable_step, "too long", "a shorter step");
  });
  CHECK(unstable.remedy == "a shorter step");
  const RunOutcome diverged = failing([](std::int64_t n) { return n < 7 ? 0 : std::nan(""); });
  CHECK_THAT(diverged.failure, Contains("step 7: the solver's force is not finite"));
  for (const auto& [make, why] : std::vector<std::pair<SolverFactory, std::string>>{
           {[](const SolverRequest&) { return nullptr; }, "the solver 'bad': its factory returned nothing"},
           {[](const SolverRequest&) -> std::unique_ptr<ForeignSolver> { throw std::runtime_error("no licence"); },
            "the solver 'bad': no licence"}}) {
    Registry mine;
    mine.add_solver("bad", make);
    const RunOutcome outcome = run({scene_of("bad")}, mine);
    CHECK(outcome.exit == ExitCode::run_failed);
    CHECK_THAT(outcome.failure, Contains(why));
  }
}

TEST_CASE("A reset is the solver's own, or another solver") {
  for (const bool own : {true, false}) {
    int made = 0;
    const auto solver = solver_of([&](const SolverRequest&) {
      ++made;
      return std::make_unique<FullSpring>(SolverCapabilities{.particles = true, .reset = own});
    });
    solver->step(std::array{glm::dvec3(1, 0, 0)});
    CHECK(solver->particle_state().displacement_m[0].x > 0);
    solver->reset();
    CHECK(solver->particle_state().displacement_m[0].x == 0);
    CHECK(made == (own ? 1 : 2));
  }
}

TEST_CASE("A force of the schedule without delay is the solver's own at the ticks") {
  const RunRecord run =
      record({kMySpring, R"(expect=[{ signal = "left.force.phase_locked", metric = "error_max", max = "100 N" }])"});
  const TickRow& tick = strategy(run, "phase_locked").devices[0].ticks.back();
  REQUIRE(tick.undelayed_N);
  CHECK((*tick.undelayed_N)[0] == -200 * tick.position_m[0]);
}

TEST_CASE("A registry refuses a part without a name, without a function, and twice the same") {
  Registry mine;
  const SolverFactory make = [](const SolverRequest&) { return nullptr; };
  CHECK_THROWS_WITH(mine.add_solver("", make), "a solver is registered without a name");
  CHECK_THROWS_WITH(mine.add_map("x", {}), "the map 'x' is registered without a function that makes it");
  mine.add_solver("x", make);
  CHECK_THROWS_WITH(mine.add_solver("x", make), "the solver 'x' is registered twice");
  mine.add_device("x", [](const DeviceRequest&) { return nullptr; });  // a part of another kind may have the same name
  CHECK(builtin().solvers().empty());
}

TEST_CASE("A name that is not registered is an error at its place, with the nearest one") {
  CHECK_THAT(errors_of({scene_of("my-sprin")}, registry()),
             Contains("the solver 'my-sprin' is not registered; did you mean 'my-spring'?"));
  CHECK_THAT(errors_of({scene_of("my-spring")}, {}), Contains("needs a program that registers it"));
  CHECK_THAT(errors_of({R"(run.strategies=["foreign"])", R"(remap.foreign={ name = "other" })"}, registry()),
             Contains("the map 'other' is not registered; known: my-pacer"));
  CHECK_THAT(errors_of({R"(timing={ foreign = { name = "my-gp" } })"}, registry()),
             Contains("the timing source 'my-gp' is not registered; did you mean 'my-gpu'?"));
}
