#include <functional>

#include "catch.h"
#include "tissue_scenes.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

struct BadScene {
  std::string message;  ///< what the user must read
  std::function<void(Scene&, TissueScene&)> spoil;
};

ToolCoupling spring(ToolCoupling tool, double stiffness_N_per_m, double damping_N_s_per_m) {
  return {tool.center_m, tool.radius_m, CouplingKind::spring, stiffness_N_per_m, damping_N_s_per_m};
}

const std::vector<BadScene>& bad_scenes() {
  static const double inf = std::numeric_limits<double>::infinity(), nan = std::nan("");
  static const std::vector<BadScene> cases = [] {
    std::vector<BadScene> all{
        {"0 particles", [](Scene&, TissueScene& t) { t.particle_count = 0; }},
        {"-1 particles", [](Scene&, TissueScene& t) { t.particle_count = -1; }},
        {"505 particles on a lattice of 504 sites", [](Scene&, TissueScene& t) { t.particle_count = 505; }},
        {"axis of 0 sites", [](Scene&, TissueScene& t) { t.lattice[1] = 0; }},
        {"axis of -3 sites", [](Scene&, TissueScene& t) { t.lattice[0] = -3; }},
        {"axis of 1025 sites", [](Scene&, TissueScene& t) { t.lattice[2] = 1025; }},
        {"-1 substeps", [](Scene&, TissueScene& t) { t.substeps = -1; }},
        {"100001 substeps", [](Scene&, TissueScene& t) { t.substeps = 100'001; }},
        {"a damping of -1", [](Scene&, TissueScene& t) { t.damping_per_s = -1; }},
        {"a damping of nan", [](Scene&, TissueScene& t) { t.damping_per_s = nan; }},
        {"3 tools",
         [](Scene& s, TissueScene& t) {
           t.tools.resize(3);
           s.tool_count = 3;
         }},
        {"-1 tools", [](Scene& s, TissueScene&) { s.tool_count = -1; }},
        {"1 tools but 2 couplings", [](Scene& s, TissueScene&) { s.tool_count = 1; }},
        {"tool 1 holds no particle",
         [](Scene&, TissueScene& t) { t.tools[1].radius_m = 1e-9, t.tools[1].center_m.x += 1e-3; }},
        {"tool 0 holds no particle that can move",
         [](Scene&, TissueScene& t) { t.tools[0].center_m.z = 0, t.tools[0].radius_m = 4e-3; }},
        {"tools 0 and 1 both hold", [](Scene&, TissueScene& t) { t.tools[1] = t.tools[0]; }},
        {"a coupling that is not finite", [](Scene&, TissueScene& t) { t.tools[0].center_m.y = inf; }},
        {"a coupling that is not finite", [](Scene&, TissueScene& t) { t.tools[0].radius_m = nan; }},
        {"a coupling that is not finite", [](Scene&, TissueScene& t) { t.tools[0].radius_m = -1; }},
        {"a grab with a stiffness", [](Scene&, TissueScene& t) { t.tools[0].stiffness_N_per_m = 1; }},
        {"a coupling damping of -1", [](Scene&, TissueScene& t) { t.tools[0] = spring(t.tools[0], 1, -1); }},
        {"a coupling damping of nan", [](Scene&, TissueScene& t) { t.tools[0] = spring(t.tools[0], 1, nan); }},
        {"zero: a probe has none",
         [](Scene&, TissueScene& t) { t.tools[0] = spring(t.tools[0], 1, 1), t.tools[0].kind = CouplingKind::probe; }},
        {"an axial damping of -1", [](Scene&, TissueScene& t) { t.axial_damping_N_s_per_m = -1; }},
        {"an axial damping of inf", [](Scene&, TissueScene& t) { t.axial_damping_N_s_per_m = inf; }},
        {"a gravity that is not finite", [](Scene&, TissueScene& t) { t.gravity_m_per_s2.y = nan; }},
        {"a region that is not finite",
         [](Scene&, TissueScene& t) {
           t.regions = {{{inf, 0, 0}, {1, 1, 1}, 1, 1}};
         }},
        {"61 regions",
         [](Scene&, TissueScene& t) {
           t.regions.assign(61, {{0, 0, 0}, {1, 1, 1}, 1, 1});
         }},
        {"an initial state of 3 particles", [](Scene&, TissueScene& t) { t.initial_displacement_m.resize(3); }},
        {"an initial state that is not finite", [](Scene&, TissueScene& t) {
           t.initial_velocity_m_per_s.resize(static_cast<std::size_t>(t.particle_count));
           t.initial_velocity_m_per_s[7].z = nan;
         }}};
    for (const double bad : {0.0, -1.0, inf, -inf, nan, 1e-300, 1e300}) {
      all.push_back({"a particle mass of", [bad](Scene&, TissueScene& t) { t.particle_mass_kg = bad; }});
      all.push_back({"a spacing of", [bad](Scene&, TissueScene& t) { t.spacing_m = bad; }});
      all.push_back({"a coupling stiffness of", [bad](Scene&, TissueScene& t) { t.tools[0] = spring(t.tools[0], bad, 0); }});
      all.push_back({"a particle mass of a region of", [bad](Scene&, TissueScene& t) {
                       t.regions = {{{0, 0, 0}, {1, 1, 1}, 1, bad}};
                     }});
      all.push_back({"a stiffness of a region of", [bad](Scene&, TissueScene& t) {
                       t.regions = {{{0, 0, 0}, {1, 1, 1}, bad, 1}};
                     }});
      all.push_back({"a stiffness of", [bad](Scene&, TissueScene& t) { t.stiffness_N_per_m = bad; }});
    }
    return all;
  }();
  return cases;
}

}  // namespace

TEST_CASE("Every impossible scene is refused by every solver with its name and a remedy", "[errors]") {
  for (const BadScene& bad : bad_scenes()) {
    for (const SolverKind kind : kEverySolver) {
      Scene scene = scene_of(small_block(), 1e-3);
      bad.spoil(scene, std::get<TissueScene>(scene.body));
      INFO(bad.message);
      try {
        make_solver(kind, scene);
        FAIL("not refused");
      } catch (const SolverError& error) {
        CHECK_THAT(error.what() + (": " + error.remedy()), Catch::Contains(bad.message));
        CHECK(error.fault() == SolverFault::bad_scene);
        CHECK_FALSE(error.remedy().empty());
      }
    }
  }
  CHECK(bad_scenes().size() == 72);
}

TEST_CASE("The smallest and the roundest scenes run: one particle, two particles, a lattice to the brim", "[errors]") {
  for (const SolverKind kind : kEverySolver) {
    TissueScene one = spring_pair();
    one.particle_count = 1;
    const auto alone = make_solver(kind, scene_of(one, 1e-3));
    CHECK(alone->info().springs == 0);
    step(*alone, 1, {});
    CHECK(step(*alone, 1, {glm::dvec3(1)}).force_N[0] == glm::dvec3(0));
    if (kind == SolverKind::opencl) continue;  // each costs half a second of compilation
    CHECK(make_solver(kind, scene_of(spring_pair(), 1e-3))->info().springs == 1);
    TissueScene full = small_block();
    full.particle_count = 8 * 7 * 9;
    CHECK(make_solver(kind, scene_of(full, 1e-3))->info().particles == 504);
  }
}

TEST_CASE("One particle alone runs with no tool and with one of each kind, and every number stays finite",
          "[errors][sweep]") {
  for (const SolverKind kind : kEverySolver) {
    for (const int tools : {0, 1, 2, 3}) {
      if (kind == SolverKind::opencl && tools == 1) continue;
      TissueScene one;
      one.lattice = {1, 1, 1};
      one.particle_count = 1;
      one.fixed = FixedFaces::none();
      one.gravity_m_per_s2.z = -9.81;
      if (tools == 1) one.tools = {{glm::dvec3(0), 1e-3}};
      if (tools == 2) one.tools = {{glm::dvec3(0), 1e-3, CouplingKind::spring, 10, 0.01}};
      if (tools == 3) one.tools = {{glm::dvec3(0), 1e-3, CouplingKind::probe, 10}};
      Scene scene = scene_of(one, 1e-3, true);
      scene.local_model = LocalModel::settled;
      const auto solver = make_solver(kind, scene);
      CHECK(solver->info().springs == 0);
      for (int n = 0; n < 50; ++n) {
        const ToolResponse response = step(*solver, static_cast<int>(one.tools.size()), wandering_tools(n));
        REQUIRE(std::isfinite(norm(response.force_N[0])));
        for (const ToolContact& contact : solver->contacts()) REQUIRE(std::isfinite(norm(contact.point_m)));
      }
      CHECK_FALSE(solver->verdict().non_finite);
      CHECK(norm(solver->particle_state().displacement_m[0]) > 0);
    }
  }
}

TEST_CASE("Particles that start on one point, and a hand that jumps at 10 m/s, give finite numbers", "[errors][sweep]") {
  for (const SolverKind kind : kEverySolver) {
    for (const CouplingKind tool : {CouplingKind::grab, CouplingKind::spring}) {
      TissueScene block = small_block();
      block.spacing_m = 0x1p-8;  // its sums are exact, so the two are at the same point, not near it
      block.damping_per_s = 20;
      block.axial_damping_N_s_per_m = 1e-3;
      block.tools = {{glm::dvec3(1, 3, 7) * block.spacing_m, 1.2 * block.spacing_m, tool}};
      if (tool == CouplingKind::spring) block.tools[0].stiffness_N_per_m = 100, block.tools[0].damping_N_s_per_m = 0.05;
      block.initial_displacement_m.resize(static_cast<std::size_t>(block.particle_count));
      block.initial_displacement_m[8 * 7 * 4].x = block.spacing_m;
      Scene scene = scene_of(block, 1.0 / 450, true);
      scene.local_model = LocalModel::instantaneous;
      const auto solver = make_solver(kind, scene);
      for (int n = 0; n < 300; ++n) {
        const ToolResponse response = step(*solver, 1, {glm::dvec3(0, 0, n == 20 || n == 21 ? 10.0 / 450 * (n - 19) : 0)});
        REQUIRE(std::isfinite(norm(response.force_N[0])));
        for (int column = 0; column < 3; ++column)
          REQUIRE(std::isfinite(norm(solver->contacts()[0].stiffness_N_per_m[column])));
      }
      CHECK_FALSE(solver->verdict().non_finite);
    }
  }
}

TEST_CASE("A method that a solver does not have is refused with both names", "[errors]") {
  for (const Method method : {Method::rk4, Method::implicit_midpoint, Method::vertex_block_descent}) {
    TissueScene block = small_block();
    block.method = method;
    try {
      make_solver(SolverKind::opencl, scene_of(block, 1e-3));
      FAIL("not refused");
    } catch (const SolverError& error) {
      CHECK(error.fault() == SolverFault::unavailable);
      CHECK_THAT(error.what(), Catch::Contains("'opencl' does not have"));
      CHECK_FALSE(error.remedy().empty());
    }
  }
}

TEST_CASE("A spring without stiffness and a spring with three tools are refused", "[errors]") {
  for (const double bad : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    CHECK_THROWS_AS(make_solver(SolverKind::cpu_double, Scene{SpringScene{bad}}), SolverError);
  }
  Scene crowded{SpringScene{}};
  crowded.tool_count = 3;
  CHECK_THROWS_AS(make_solver(SolverKind::cpu_double, crowded), SolverError);
}
