#include <catch2/catch.hpp>
#include <functional>

#include "tissue_scenes.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

struct BadScene {
  std::string message;  ///< what the user must read
  std::function<void(Scene&, TissueScene&)> spoil;
};

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
        {"a coupling that is not finite", [](Scene&, TissueScene& t) { t.tools[0].radius_m = -1; }}};
    for (const double bad : {0.0, -1.0, inf, -inf, nan, 1e-300, 1e300}) {
      all.push_back({"a particle mass of", [bad](Scene&, TissueScene& t) { t.particle_mass_kg = bad; }});
      all.push_back({"a spacing of", [bad](Scene&, TissueScene& t) { t.spacing_m = bad; }});
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
        CHECK_THAT(error.what(), Catch::Contains(bad.message));
        CHECK(error.fault() == SolverFault::bad_scene);
        CHECK_FALSE(error.remedy().empty());
      }
    }
  }
  CHECK(bad_scenes().size() == 40);
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

TEST_CASE("A spring without stiffness and a spring with three tools are refused", "[errors]") {
  for (const double bad : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    CHECK_THROWS_AS(make_solver(SolverKind::cpu_double, Scene{SpringScene{bad}}), SolverError);
  }
  Scene crowded{SpringScene{}};
  crowded.tool_count = 3;
  CHECK_THROWS_AS(make_solver(SolverKind::cpu_double, crowded), SolverError);
}
