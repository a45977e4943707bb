
#include "catch.h"
#include "tissue_scenes.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

SolverOptions logged() {
  SolverOptions options;
  options.log_commands = true;
  return options;
}

/// The methods that give commands to a device in different ways.
std::vector<Method> methods() { return {Method::symplectic_euler, Method::velocity_verlet, Method::implicit_euler}; }

}  // namespace

TEST_CASE("A solver keeps no log of its commands unless it is asked to, and then one on a device alone", "[log]") {
  const Scene scene = scene_of(small_block(), 1e-3);
  CHECK(make_solver(SolverKind::opencl, scene)->command_log() == nullptr);
  CHECK(make_solver(SolverKind::cpu_float, scene, logged())->command_log() == nullptr);
  CHECK(make_solver(SolverKind::opencl, scene, logged())->command_log() != nullptr);
}

TEST_CASE("Each command has four times in their order, and no command ends before the one before it", "[log]") {
  for (const Method method : methods()) {
    TissueScene tissue = small_block();
    tissue.method = method;
    const auto solver = make_solver(SolverKind::opencl, scene_of(tissue, 1e-3), logged());
    INFO(name_of(method));
    CHECK_FALSE(solver->command_log()->take().empty());  // the warm-up
    CHECK(solver->command_log()->take().empty());
    std::uint64_t ended_ns = 0;
    std::vector<std::size_t> counts;
    for (int n = 0; n < 3; ++n) {
      solver->step(wandering_tools(n));
      counts.push_back(solver->command_log()->size());
      for (const DeviceCommand& command : solver->command_log()->take()) {
        CHECK_FALSE(command.name.empty());
        CHECK(command.queued_ns <= command.submitted_ns);
        CHECK(command.submitted_ns <= command.started_ns);
        CHECK(command.started_ns <= command.ended_ns);
        CHECK(command.ended_ns >= ended_ns);
        ended_ns = command.ended_ns;
      }
      CHECK(solver->command_log()->size() == 0);
    }
    CHECK(counts.front() > 0);
    if (method != Method::implicit_euler) CHECK(counts[1] == counts[2]);  // that one iterates as often as needed
  }
}

TEST_CASE("A step gives no more commands than its substeps, a read of the forces and what hands their memory back",
          "[log]") {
  TissueScene tissue = small_block();
  tissue.substeps = 4;
  const auto solver = make_solver(SolverKind::opencl, scene_of(tissue, 1e-3), logged());
  solver->step(wandering_tools(0));
  solver->command_log()->take();
  solver->step(wandering_tools(1));
  std::vector<std::string> names;
  for (const DeviceCommand& command : solver->command_log()->take()) names.emplace_back(command.name);
  CHECK(names == std::vector<std::string>{"advance", "advance", "advance", "advance", "unmap", "grab_force", "map"});
}

TEST_CASE("A log changes no bit of what a solver computes", "[log]") {
  for (const Method method : methods()) {
    TissueScene tissue = small_block();
    tissue.method = method;
    Scene scene = scene_of(tissue, 1e-3);
    scene.needs_state_digest = true;
    const auto with = make_solver(SolverKind::opencl, scene, logged()), without = make_solver(SolverKind::opencl, scene);
    for (int n = 0; n < 20; ++n) {
      CHECK(with->step(wandering_tools(n)).force_N == without->step(wandering_tools(n)).force_N);
      CHECK(with->state_digest() == without->state_digest());
    }
  }
}

TEST_CASE("A device describes itself: the name that the solver has, its platform and its driver", "[log]") {
  const OpenClDescription description = describe_opencl();
  CHECK(description.device == make_solver(SolverKind::opencl, scene_of(small_block(), 1e-3))->info().device);
  CHECK_FALSE(description.platform.empty());
  CHECK_THAT(description.version, Catch::StartsWith("OpenCL "));
  CHECK_FALSE(description.driver.empty());
  CHECK(description.compute_units > 0);
}
