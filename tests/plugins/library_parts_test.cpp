// What each function of a library's parts gives, refuses or throws (modules/told.cpp), without a run around it.
#include "catch.h"
#include "evenstep/clock/virtual_clock.h"
#include "evenstep/plugins/library.h"

using namespace evenstep;
using Catch::Contains;

namespace {

const Library& told() {
  static const Library library = [] {
    const auto opened = open_library(std::string(EVENSTEP_MODULES) + "/told.so");
    INFO(opened.error_or(""));
    REQUIRE(opened);
    return *opened;
  }();
  return library;
}

/// Options that tell one function what to do.
std::string telling(const std::string& function, const std::string& what) {
  return "{\"" + function + "\":\"" + what + "\"}";
}

std::unique_ptr<ForeignSolver> told_solver(const std::string& options) { return told().solver({.options = options}); }

/// Calls one function of a solver by its name.
void call(ForeignSolver& solver, const std::string& function) {
  const std::vector<glm::dvec3> at(1);
  if (function == "step") solver.step(at, 0.001);
  if (function == "contacts") solver.contacts();
  if (function == "state_digest") solver.state_digest();
  if (function == "energy") solver.energy_J();
  if (function == "particles") solver.particles();
  if (function == "reset") solver.reset();
}
void call(HapticDevice& device, const std::string& function) {
  if (function == "start") device.start();
  if (function == "read") device.read(RealTime{5});
  if (function == "write") device.write(glm::dvec3(1));
}
void call(ForeignMap& map, const std::string& function) {
  if (function == "boundary") map.boundary(0, RealTime{1});
  if (function == "began") map.began(0, RealTime{1});
  if (function == "ended") map.ended(0, RealTime{1});
  if (function == "slot") map.slot(0);
}

template <class Call>
std::string error_of(Call make_and_call) {
  try {
    make_and_call();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "nothing";
}

/// Each of these functions of the parts that `make` gives refuses, throws and says nothing in turn.
template <class Make>
void check_faults(Make make, const std::vector<std::string>& functions) {
  for (const std::string& function : functions) {
    const auto fault = [&](const char* what) { return error_of([&] { call(*make(telling(function, what)), function); }); };
    INFO(function);
    CHECK(fault("refuses") == function + " returned 2: no");
    CHECK(fault("says nothing") == function + " returned 42");
    CHECK(fault("throws") == function + " threw an exception: out of cheese");
    CHECK(fault("throws 3") == function + " threw something that is no std::exception");
    CHECK(fault("works") == "nothing");
  }
}

}  // namespace

TEST_CASE("Each function of a library's solver that refuses or throws is an error with its name and its words") {
  CHECK(told().name == "told?[2J");  // no name reaches a terminal as a command
  check_faults(told_solver, {"create", "step", "contacts", "state_digest", "energy", "particles", "reset"});
  try {
    told_solver(telling("reset", "refuses"))->reset();
    FAIL("it should refuse");
  } catch (const SolverError& error) {
    CHECK(error.fault() == SolverFault::bad_input);
    CHECK(error.remedy() == "ask again");
  }
}

TEST_CASE("What a library's solver gives besides forces arrives unchanged, and particles without a place are refused") {
  const auto solver = told_solver("{}");
  const ToolContact contact = solver->contacts().front();
  CHECK(contact.touching);
  CHECK(contact.unilateral);
  CHECK(contact.point_m == glm::dvec3(10, 11, 12));
  CHECK(contact.normal == glm::dvec3(20, 21, 22));
  CHECK(contact.gap_m == 0.5);
  CHECK(contact.stiffness_N_per_m[1][0] == 3);
  CHECK(solver->state_digest() == 7);
  CHECK(solver->energy_J() == 0.25);
  const ParticleState state = solver->particles();
  CHECK(state.displacement_m == std::vector{glm::dvec3(1, 2, 3)});
  CHECK(state.velocity_m_per_s == std::vector{glm::dvec3(4, 5, 6)});
  CHECK(told_solver(telling("particles", "none"))->particles().displacement_m.empty());
  for (const auto& [what, count] :
       {std::pair("fewer", "-1"), std::pair("more", "9223372036854775807"), std::pair("nowhere", "1")})
    CHECK(error_of([&, what = what] { told_solver(telling("particles", what))->particles(); }) ==
          std::string("particles gave ") + count + " of them, or no place where they are");
}

TEST_CASE("Each function of a library's device and map that refuses or throws is an error with its name and its words") {
  const auto device = [](const std::string& options) { return told().device({.options = options}); };
  check_faults(device, {"create", "start", "read", "write"});
  check_faults([](const std::string& options) { return told().map({.options = options}); },
               {"create", "boundary", "began", "ended", "slot"});
  for (const char* what : {"throws", "throws 3"}) CHECK_NOTHROW(device(telling("stop", what))->stop());
}

TEST_CASE("What a library's device says of a position arrives, and what its grip throws passes through it") {
  const auto device = told().device({.path = "/dev/arm"});
  const DeviceSample sample = device->read(RealTime{5});
  CHECK(sample.position_m == glm::dvec3(8, 2, 3));  // the first is the length of the path
  CHECK(sample.sequence == 9);
  CHECK_FALSE(sample.fresh);
  CHECK_FALSE(sample.drivable);
  CHECK(sample.at_range);

  VirtualClock clock;
  HandSpec thrown;
  thrown.push_N = {100, 0, 0};
  SimulatedGrip grip(clock, Hand(thrown, {}), Duration{0});
  const auto simulated = told().device({.options = telling("read", "asks"), .grip = &grip});
  CHECK(simulated->read(clock.now()).fresh);
  clock.wait_until(RealTime{1'000'000'000});
  CHECK_THROWS_AS(simulated->read(clock.now()), HandDiverged);
  CHECK_NOTHROW(simulated->read(clock.now()));  // it is said once
}

TEST_CASE("A library's map is told when steps begin and end, and a slot that it does not know yet is none") {
  const auto map = told().map({.options = "{}"});
  map->boundary(0, RealTime{1000});
  map->began(0, RealTime{200});
  CHECK_FALSE(map->slot(0));
  map->ended(0, RealTime{30});
  CHECK(map->slot(0) == RealTime{1230});
}

TEST_CASE("A library's timing source may end, and a segment without a place for its steps is refused") {
  const auto source = [](const char* what) { return told().timing({.options = telling("next", what)}); };
  SegmentTiming segment;
  REQUIRE(source("works")->next(segment));
  REQUIRE(segment.steps.size() == 1);
  CHECK(segment.steps[0].begin == RealTime{10});
  CHECK(segment.steps[0].end == RealTime{20});
  CHECK_FALSE(segment.visualization);
  CHECK_FALSE(segment.concurrent);
  REQUIRE(source("beside")->next(segment));
  CHECK(segment.concurrent);
  REQUIRE(segment.visualization);
  CHECK(segment.visualization->end == RealTime{30});
  CHECK_FALSE(source("ends")->next(segment));
  for (const char* what : {"fewer", "more", "nowhere"})
    CHECK_THAT(error_of([&] { source(what)->next(segment); }), Contains("next gave a segment of "));
  CHECK(error_of([&] { source("throws")->next(segment); }) == "next threw an exception: out of cheese");
}

TEST_CASE("A library that throws when a part is given back does not end the program") {
  CHECK_NOTHROW(told_solver(telling("destroy", "throws")).reset());
}
