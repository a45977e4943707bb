// A scene in another numbering of its particles is the same scene, and the methods differ only by rounding.
#include "evenstep/catalogue/numbering.h"

#include <algorithm>
#include <array>
#include <set>

#include "catch.h"
#include "evenstep/catalogue/run_trial.h"
#include "evenstep/sim/stability.h"

using namespace evenstep;
using namespace evenstep::internal;

namespace {

TissueScene uneven() {
  TissueScene tissue;
  tissue.lattice = {2, 3, 4};
  tissue.particle_count = 24;
  tissue.spacing_m = 0.25;
  tissue.gravity_m_per_s2 = {1, 2, 3};
  tissue.fixed = {true, false, false, false, false, true};
  tissue.regions = {{{0, 0, 0}, {0.25, 0.25, 0.5}, 70, 1e-3}};
  tissue.tools = {{{0, 0.25, 0.75}, 0.125}};
  for (int site = 0; site < 24; ++site) tissue.initial_displacement_m.emplace_back(site, 2 * site, 3 * site);
  return tissue;
}

CaseCell cell_of(Method method, SolverKind solver, double steps) {
  const CaseKind kind{"numbering", "steps", "", make_numbering};
  const CaseSpec spec;
  return run_cell(kind, {spec, steps, method, solver}, 1, nullptr);
}

}  // namespace

TEST_CASE("There are forty-seven other numberings and each of them has its sites once") {
  const TissueScene old = uneven();
  std::set<std::vector<std::size_t>> seen;
  for (const Numbering& numbering : all_numberings()) {
    std::vector<std::size_t> sites;
    for (std::size_t site = 0; site < 24; ++site) sites.push_back(numbering.site(old, site));
    seen.insert(sites);
    CHECK(std::set<std::size_t>(sites.begin(), sites.end()).size() == 24);
    CHECK(*std::max_element(sites.begin(), sites.end()) == 23);
  }
  CHECK(seen.size() == 47);
  CHECK(seen.count([] {
    std::vector<std::size_t> own(24);
    for (std::size_t site = 0; site < 24; ++site) own[site] = site;
    return own;
  }()) == 0);
}

TEST_CASE("An exchange and a mirror move every part of a scene to the same place") {
  // The new x is the old z, backwards; the new y is the old x; the new z is the old y.
  const Numbering numbering{{2, 0, 1}, {true, false, false}};
  const TissueScene old = uneven(), now = numbering.scene(old);
  CHECK(now.lattice == std::array{4, 2, 3});
  CHECK(now.gravity_m_per_s2 == glm::dvec3(-3, 1, 2));
  CHECK(now.tools[0].center_m == glm::dvec3(0, 0, 0.25));
  CHECK(now.regions[0].min_m == glm::dvec3(0.25, 0, 0));
  CHECK(now.regions[0].max_m == glm::dvec3(0.75, 0.25, 0.25));
  CHECK(
      (now.fixed.x_min && !now.fixed.x_max && now.fixed.y_min && !now.fixed.y_max && !now.fixed.z_min && !now.fixed.z_max));
  // Old site (1, 2, 0) = 5 is new site (3, 1, 2) = 3 + 4 (1 + 2 * 2).
  CHECK(numbering.site(old, 5) == 23);
  CHECK(now.initial_displacement_m[23] == glm::dvec3(-15, 5, 10));
}

TEST_CASE("The step limit of a scene is that of all of its numberings") {
  TissueScene old = uneven();
  old.tools.clear();
  for (const Numbering& numbering : all_numberings())
    CHECK(step_limit(numbering.scene(old)).step_s == Approx(step_limit(old).step_s).epsilon(1e-9));
}

TEST_CASE(
    "Every method but the one with colours gives one answer in all numberings, to the rounding of its springs' lengths",
    "[sweep]") {
  for (const Method method : kAllMethods) {
    INFO(name_of(method));
    const CaseCell in_double = cell_of(method, SolverKind::cpu_double, 20);
    const CaseCell in_float = cell_of(method, SolverKind::cpu_float, 20);
    const bool has_colours = method == Method::vertex_block_descent;
    CHECK(in_double.metrics.at("numbering_difference") <= (has_colours ? 2e-5 : 1e-14));
    CHECK(in_float.metrics.at("numbering_difference") <= (has_colours ? 2e-5 : 1e-6));
    // Another order of summation rounds differently. No difference at all would mean that nothing was renumbered.
    CHECK(in_double.metrics.at("numbering_difference") > 1e-17);
    CHECK(in_double.status == (has_colours ? CellStatus::drifting : CellStatus::ok));
  }
}
