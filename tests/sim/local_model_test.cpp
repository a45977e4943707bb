// Solver::contacts, compared with differences of forces.
#include "catch.h"
#include "feature_scenes.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

const std::array kKinds{CouplingKind::grab, CouplingKind::spring, CouplingKind::probe};

Scene modelled(TissueScene tissue, LocalModel model, double step_s) {
  Scene scene = scene_of(std::move(tissue), step_s);
  scene.local_model = model;
  return scene;
}

bool same_contact(const ToolContact& a, const ToolContact& b) {
  return a.touching == b.touching && a.unilateral == b.unilateral &&
         std::memcmp(&a.point_m, &b.point_m, sizeof a.point_m) == 0 &&
         std::memcmp(&a.normal, &b.normal, sizeof a.normal) == 0 && same_bits(a.gap_m, b.gap_m) &&
         std::memcmp(&a.stiffness_N_per_m, &b.stiffness_N_per_m, sizeof a.stiffness_N_per_m) == 0;
}

double largest(const glm::dmat3& m) {
  double most = 0;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) most = std::max(most, std::abs(m[c][r]));
  return most;
}

}  // namespace

TEST_CASE("The instantaneous model is the change of force with particles too heavy to follow", "[local]") {
  for (const CouplingKind kind : kKinds) {
    TissueScene block = featured_block({true, false, false, false, kind});
    for (MaterialRegion& region : block.regions) region.particle_mass_kg = 1e6;
    block.particle_mass_kg = 1e6;
    block.substeps = 1;
    block.tools[0].damping_N_s_per_m = block.tools[1].damping_N_s_per_m = 0;
    const auto solver = make_solver(SolverKind::cpu_double, modelled(block, LocalModel::instantaneous, 1e-3));
    Positions at{};
    step(*solver, 2, at);
    at = {glm::dvec3(1e-3, 2e-3, -1e-3), glm::dvec3(0, -1e-3, -2e-3)};
    step(*solver, 2, at);
    const std::vector<ToolContact> here(solver->contacts().begin(), solver->contacts().end());
    for (std::size_t tool = 0; tool < 2; ++tool) {
      const glm::dmat3& k = here[tool].stiffness_N_per_m;
      REQUIRE(here[tool].touching);
      REQUIRE(largest(k) > 10);
      for (int axis = 0; axis < 3; ++axis) {
        Positions above = at, below = at;
        above[tool][axis] += 1e-7;
        below[tool][axis] -= 1e-7;
        const glm::dvec3 change = step(*solver, 2, above).force_N[tool] - step(*solver, 2, below).force_N[tool];
        for (int row = 0; row < 3; ++row) {
          CHECK(-change[row] / 2e-7 == Approx(k[axis][row]).margin(1e-5 * largest(k)));
          CHECK(k[axis][row] == k[row][axis]);
        }
      }
    }
  }
}

TEST_CASE("The settled model is the change of force once the particles have come to rest again", "[local][sweep]") {
  for (const CouplingKind kind : {CouplingKind::grab, CouplingKind::spring}) {
    TissueScene block = featured_block({true, true, false, false, kind});
    block.damping_per_s = 150;
    block.tools.pop_back();
    const auto solver = make_solver(SolverKind::cpu_double, modelled(block, LocalModel::settled, 1e-3));
    step(*solver, 1, {});
    const glm::dmat3 k = solver->contacts()[0].stiffness_N_per_m;
    CHECK(largest(k) > 10);
    for (int axis = 0; axis < 3; ++axis) {
      std::array<glm::dvec3, 2> force_N{};
      for (int side = 0; side < 2; ++side) {
        Positions at{};
        at[0][axis] = side == 0 ? 1e-6 : -1e-6;
        for (int n = 0; n < 1500; ++n) force_N[static_cast<std::size_t>(side)] = step(*solver, 1, at).force_N[0];
      }
      for (int row = 0; row < 3; ++row)
        CHECK(-(force_N[0][row] - force_N[1][row]) / 2e-6 == Approx(k[axis][row]).margin(1e-4 * largest(k)));
    }
  }
}

TEST_CASE("A coupling in series with a spring has the settled stiffness k kc / (k + kc), a free particle none", "[local]") {
  TissueScene tissue;
  tissue.lattice = {1, 1, 2};
  tissue.particle_count = 2;
  tissue.stiffness_N_per_m = 40;
  tissue.tools = {{glm::dvec3(0, 0, 5e-3), 1e-3, CouplingKind::spring, 25}};
  const auto settled = [&] {
    const auto solver = make_solver(SolverKind::cpu_double, modelled(tissue, LocalModel::settled, 1e-3));
    step(*solver, 1, {});
    return solver->contacts()[0].stiffness_N_per_m;
  };
  const glm::dmat3 on_spring = settled();
  CHECK(on_spring[2][2] == Approx(40.0 * 25 / (40 + 25)));
  CHECK(std::abs(on_spring[0][0]) < 1e-12);  // a spring on a line has no stiffness to the side
  tissue.fixed = FixedFaces::none();
  CHECK(largest(settled()) < 1e-9);
}

TEST_CASE("Local models are equal on cpu float and OpenCL, bit for bit", "[local][equality][sweep]") {
  for (const LocalModel model : {LocalModel::instantaneous, LocalModel::settled}) {
    for (const CouplingKind kind : kKinds) {
      if (model == LocalModel::settled && kind == CouplingKind::spring) continue;  // the host computes that number
      const Scene scene = modelled(featured_block({true, true, true, true, kind}), model, 1e-3);
      const auto cpu = make_solver(SolverKind::cpu_float, scene), opencl = make_solver(SolverKind::opencl, scene);
      int apart = 0;
      for (int n = 0; n < 60; ++n) {
        step(*cpu, 2, wandering_tools(3 * n));
        step(*opencl, 2, wandering_tools(3 * n));
        for (std::size_t tool = 0; tool < 2; ++tool) {
          const ToolContact& contact = cpu->contacts()[tool];
          REQUIRE(same_contact(contact, opencl->contacts()[tool]));
          const bool is_probe = two_tools(kind, 1)[tool].kind == CouplingKind::probe;
          REQUIRE((contact.gap_m < 0) == (is_probe && contact.touching));
          REQUIRE(contact.unilateral == is_probe);
          REQUIRE(norm(contact.normal) == Approx(is_probe ? 1 : 0));
          apart += is_probe && !contact.touching;
        }
      }
      CHECK((kind != CouplingKind::probe || apart > 0));
    }
  }
}

TEST_CASE("Contacts are one per tool of the last step: none without a model and zero before the first step", "[local]") {
  const auto same = [](std::span<const ToolContact> a, const ToolContact& b) {
    return std::all_of(a.begin(), a.end(), [&](const ToolContact& contact) { return same_contact(contact, b); });
  };
  for (const CouplingKind kind : kKinds) {
    const auto without =
        make_solver(SolverKind::cpu_double, scene_of(featured_block({false, false, false, false, kind}), 1e-3));
    step(*without, 2, {});
    CHECK(without->contacts().empty());
    const auto solver = make_solver(SolverKind::cpu_double, modelled(featured_block({false, false, false, false, kind}),
                                                                     LocalModel::instantaneous, 1e-3));
    REQUIRE(solver->contacts().size() == 2);
    CHECK(same(solver->contacts(), ToolContact{}));
    step(*solver, 2, {});
    CHECK_FALSE(same(solver->contacts(), ToolContact{}));
    solver->reset();
    CHECK(same(solver->contacts(), ToolContact{}));
  }
}

TEST_CASE("A spring's contact is its stiffness at the tool", "[local]") {
  Scene scene{SpringScene{320}};
  scene.tool_count = 2;
  CHECK(make_solver(SolverKind::cpu_double, scene)->contacts().empty());
  scene.local_model = LocalModel::instantaneous;
  const auto solver = make_solver(SolverKind::cpu_double, scene);
  step(*solver, 2, {glm::dvec3(1, 2, 3), glm::dvec3(-1, 0, 0)});
  REQUIRE(solver->contacts().size() == 2);
  CHECK(same_contact(solver->contacts()[0], {true, false, glm::dvec3(1, 2, 3), glm::dvec3(0), 0, glm::dmat3(320)}));
  CHECK(same_contact(solver->contacts()[1], {true, false, glm::dvec3(-1, 0, 0), glm::dvec3(0), 0, glm::dmat3(320)}));
  solver->reset();
  CHECK(same_contact(solver->contacts()[1], {}));
}

TEST_CASE("A probe's normal points from the one particle it touches to its centre and along the force", "[local]") {
  for (const SolverKind kind : kEverySolver) {
    TissueScene ball;
    ball.lattice = {1, 1, 1};
    ball.particle_count = 1;
    ball.fixed = FixedFaces::none();
    ball.particle_mass_kg = 1e6;  // stays where it is
    ball.substeps = 1;
    ball.tools = {{glm::dvec3(0), 0.02, CouplingKind::probe, 50}};
    const auto solver = make_solver(kind, modelled(ball, LocalModel::instantaneous, 1e-3));
    step(*solver, 1, {});
    CHECK(solver->contacts()[0].normal == glm::dvec3(0));  // at the centre: no direction
    for (const glm::dvec3& d : {glm::dvec3(0.01, 0, 0), glm::dvec3(-0.003, 0.004, 0), glm::dvec3(0.006, -0.009, 0.012)}) {
      const glm::dvec3 force_N = step(*solver, 1, {d}).force_N[0];
      const ToolContact& contact = solver->contacts()[0];
      CHECK(contact.unilateral);
      for (int axis = 0; axis < 3; ++axis) {
        CHECK(contact.normal[axis] == Approx(d[axis] / norm(d)).margin(1e-6));
        CHECK(force_N[axis] == Approx(50 * (0.02 - norm(d)) * contact.normal[axis]).margin(1e-5));
      }
    }
    step(*solver, 1, {glm::dvec3(0.03, 0, 0)});
    CHECK(solver->contacts()[0].gap_m == Approx(0.01));
    CHECK_FALSE(solver->contacts()[0].touching);
    step(*solver, 1, {glm::dvec3(0.6, 0, 0)});  // 116 spacings away
    CHECK(solver->contacts()[0].gap_m == Approx(0.58));
    CHECK(solver->contacts()[0].normal == glm::dvec3(0));
    CHECK(solver->contacts()[0].stiffness_N_per_m == glm::dmat3(0));
  }
}

namespace {

/// One particle too heavy to move, and a probe that starts at `offset` from it.
TissueScene heavy_ball(const glm::dvec3& offset_m) {
  TissueScene ball;
  ball.lattice = {1, 1, 1};
  ball.particle_count = 1;
  ball.fixed = FixedFaces::none();
  ball.particle_mass_kg = 1e6;
  ball.substeps = 1;
  ball.tools = {{offset_m, 0.02, CouplingKind::probe, 50}};
  return ball;
}

}  // namespace

TEST_CASE("A probe foresees its touch: the law it reports from outside is the force inside, to first order",
          "[local][sweep]") {
  for (const SolverKind kind : kEverySolver) {
    for (const glm::dvec3& n : {glm::dvec3(1, 0, 0), glm::dvec3(-0.6, 0.8, 0), glm::dvec3(2.0 / 3, -1.0 / 3, 2.0 / 3)}) {
      if (kind == SolverKind::opencl && n.z == 0) continue;  // each gap is a program to build
      for (const double gap_m : {1e-4, 1e-3, 5e-3, 0.2}) {
        const auto solver = make_solver(kind, modelled(heavy_ball(n * (0.02 + gap_m)), LocalModel::instantaneous, 1e-3));
        CHECK(step(*solver, 1, {}).force_N[0] == glm::dvec3(0));
        const ToolContact far = solver->contacts()[0];
        CHECK_FALSE(far.touching);
        CHECK(far.unilateral);
        CHECK(far.gap_m == Approx(gap_m).margin(1e-7));
        CHECK(norm(far.normal - n) < 1e-6);
        const double depth_m = 1e-4;
        const glm::dvec3 foreseen_N = far.stiffness_N_per_m * (n * (gap_m + depth_m) - far.normal * far.gap_m);
        const glm::dvec3 force_N = step(*solver, 1, {n * -(gap_m + depth_m)}).force_N[0];
        CHECK(norm(force_N - n * (50 * depth_m)) < 1e-5);
        CHECK(norm(foreseen_N - force_N) < 2e-5);  // 50 N/m times a float's rounding at 0.2 m
      }
    }
  }
}

TEST_CASE("A probe that will touch four particles at once foresees all four, of one far behind the first it does not",
          "[local]") {
  TissueScene plate;
  plate.lattice = {2, 2, 2};
  plate.particle_count = 8;
  plate.particle_mass_kg = 1e6;
  plate.substeps = 1;
  const double a = plate.spacing_m, radius_m = 8e-3;
  // The probe is over the middle of the four particles, then over one of them, with the others 3.7 mm further away.
  for (const auto& [x, y, touched] : {std::tuple{a / 2, a / 2, 4}, std::tuple{0.0, 0.0, 1}}) {
    plate.tools = {{{x, y, a + 10e-3}, radius_m, CouplingKind::probe, 35}};
    const auto solver = make_solver(SolverKind::cpu_double, modelled(plate, LocalModel::instantaneous, 1e-3));
    step(*solver, 1, {});
    const ToolContact far = solver->contacts()[0];
    CHECK_FALSE(far.touching);
    CHECK(norm(far.normal - glm::dvec3(0, 0, 1)) < 1e-12);
    const double reach_m = radius_m + far.gap_m, height_m = 10e-3;
    CHECK(reach_m == Approx(touched == 4 ? std::sqrt(height_m * height_m + a * a / 2) : height_m));
    // A tenth of a spacing further on, as the solver promises. Each particle has the same share along z.
    const double further_m = reach_m + a / 10, along = height_m * height_m / (reach_m * reach_m);
    const double expected = 35 * touched * (along + (1 - further_m / reach_m) * (1 - along));
    CHECK(far.stiffness_N_per_m[2][2] == Approx(expected));
  }
}

TEST_CASE("A settled probe foresees the tissue's own stiffness in series with its own", "[local]") {
  TissueScene chain;
  chain.lattice = {1, 1, 5};
  chain.particle_count = 5;
  chain.stiffness_N_per_m = 40;
  chain.tools = {{glm::dvec3(0, 0, 20e-3 + 7e-3), 4e-3, CouplingKind::probe, 25}};
  const auto solver = make_solver(SolverKind::cpu_double, modelled(chain, LocalModel::settled, 1e-3));
  step(*solver, 1, {});
  const ToolContact far = solver->contacts()[0];
  CHECK_FALSE(far.touching);
  CHECK(far.gap_m == Approx(3e-3));
  CHECK(far.stiffness_N_per_m[2][2] == Approx(1 / (1.0 / 25 + 4.0 / 40)));
}

TEST_CASE("A settled probe promises nothing to the side of a chain that gives way there, before the touch as after it",
          "[local]") {
  TissueScene chain;
  chain.lattice = {1, 1, 5};
  chain.particle_count = 5;
  chain.stiffness_N_per_m = 40;
  chain.tools = {{glm::dvec3(0, 0, 20e-3 + 4.5e-3), 4e-3, CouplingKind::probe, 25}};
  const auto solver = make_solver(SolverKind::cpu_double, modelled(chain, LocalModel::settled, 1e-3));
  for (int n = 0; n <= 10; ++n) {
    step(*solver, 1, {glm::dvec3(0, 0, -n * 5e-5)});  // down until the sphere meets the particle, which stays at rest
    const ToolContact& contact = solver->contacts()[0];
    INFO("gap " << contact.gap_m);
    CHECK(std::abs(contact.stiffness_N_per_m[0][0]) < 1e-9);
    CHECK(std::abs(contact.stiffness_N_per_m[1][1]) < 1e-9);
    CHECK(contact.stiffness_N_per_m[2][2] == Approx(1 / (1.0 / 25 + 4.0 / 40)));
  }
}

namespace {

/// The force on a tool at `at` once everything has come to rest.
glm::dvec3 settled_force(Solver& solver, const glm::dvec3& at) {
  glm::dvec3 force_N{};
  for (int n = 0; n < 1500; ++n) force_N = step(solver, 1, {at}).force_N[0];
  return force_N;
}

/// A probe that just touches the particle at site (1, 1, 4) from above; the next are 5 mm away.
TissueScene probed_block(double radius_m, double stiffness_N_per_m) {
  TissueScene block = featured_block({true, true, false, false, CouplingKind::probe});
  block.damping_per_s = 150;
  block.tools = {{glm::dvec3(1, 1, 4) * block.spacing_m + glm::dvec3(0, 0, radius_m), radius_m, CouplingKind::probe,
                  stiffness_N_per_m}};
  return block;
}

}  // namespace

TEST_CASE("A probe that touches one particle lightly is in series with the tissue under it", "[local][sweep]") {
  for (const double stiffness_N_per_m : {3.0, 35.0, 300.0}) {
    const auto solver =
        make_solver(SolverKind::cpu_double, modelled(probed_block(4e-3, stiffness_N_per_m), LocalModel::settled, 1e-3));
    step(*solver, 1, {});
    // The force is K q + O(q^2) and the model is K + O(q): the particle gives way to the side on the slope of the sphere.
    // Two depths together remove that term, and (q / spacing)^2 = 4e-8 is left.
    const double q_m = 1e-6;
    const double once_N = settled_force(*solver, {0, 0, -q_m}).z;
    const ToolContact contact = solver->contacts()[0];
    const double twice_N = settled_force(*solver, {0, 0, -2 * q_m}).z;
    const double exact_N_per_m = (2 * once_N - twice_N / 2) / q_m;
    const double model_N_per_m = 2 * contact.stiffness_N_per_m[2][2] - solver->contacts()[0].stiffness_N_per_m[2][2];
    CHECK(contact.touching);
    CHECK(model_N_per_m == Approx(exact_N_per_m).epsilon(1e-6));
    CHECK(contact.stiffness_N_per_m[2][2] < 0.99 * stiffness_N_per_m);
    CHECK(contact.stiffness_N_per_m[0][0] == Approx(0).margin(1e-5 * stiffness_N_per_m));
  }
}

TEST_CASE("A probe on a chain has the stiffness of the springs in series, on a free one none", "[local][sweep]") {
  TissueScene chain;
  chain.lattice = {1, 1, 5};
  chain.particle_count = 5;
  chain.stiffness_N_per_m = 40;
  chain.tools = {{glm::dvec3(0, 0, 20e-3 + 3.9e-3), 4e-3, CouplingKind::probe, 25}};
  const auto stiffness = [&] {
    const auto solver = make_solver(SolverKind::cpu_double, modelled(chain, LocalModel::settled, 1e-3));
    step(*solver, 1, {});
    REQUIRE(solver->contacts()[0].touching);
    return solver->contacts()[0].stiffness_N_per_m;
  };
  CHECK(stiffness()[2][2] == Approx(1 / (1.0 / 25 + 4.0 / 40)));
  chain.fixed = FixedFaces::none();
  CHECK(largest(stiffness()) < 1e-9);
  chain.lattice = {3, 3, 5};
  chain.particle_count = 3 * 3 * 5;
  CHECK(largest(stiffness()) < 1e-9);
}

TEST_CASE("A probe that reaches particles that are fixed takes the stiffness of those that move alone", "[local]") {
  TissueScene pair;
  pair.lattice = {1, 1, 2};
  pair.particle_count = 2;
  pair.stiffness_N_per_m = 40;
  // The probe comes from the side, between the fixed particle and the one on its spring, which gives way to the side.
  pair.tools = {{glm::dvec3(3e-3, 0, 2.5e-3), 4e-3, CouplingKind::probe, 25}};
  const auto solver = make_solver(SolverKind::cpu_double, modelled(pair, LocalModel::settled, 1e-3));
  step(*solver, 1, {});
  REQUIRE(solver->contacts()[0].touching);
  CHECK(largest(solver->contacts()[0].stiffness_N_per_m) < 1e-6);
}

TEST_CASE("A particle at the very surface of a probe is never counted as stiffer than it is, whichever way it rounds",
          "[local][sweep]") {
  for (const SolverKind kind : kEverySolver) {
    for (const double radius_m : {2.9e-3, 3.3e-3, 3.7e-3, 4e-3, 4.1e-3, 4.3e-3, 4.6e-3}) {
      if (kind == SolverKind::opencl && radius_m != 4e-3 && radius_m != 4.6e-3) continue;  // each is a program to build
      TissueScene chain;
      chain.lattice = {1, 1, 5};
      chain.particle_count = 5;
      chain.stiffness_N_per_m = 40;
      chain.particle_mass_kg = 1e6;  // stays where it is
      chain.substeps = 1;
      chain.tools = {{glm::dvec3(0.011, -0.007, 20e-3 + radius_m), radius_m, CouplingKind::probe, 25}};
      const auto solver = make_solver(kind, modelled(chain, LocalModel::settled, 1e-3));
      step(*solver, 1, {});
      // The probe goes to the place over the end of the chain, then through its surface in steps of a tenth of a float's
      // rounding.
      int touched = 0;
      for (int n = -200; n <= 200; ++n) {
        step(*solver, 1, {glm::dvec3(-0.011, 0.007, n * 2e-10)});
        const ToolContact& contact = solver->contacts()[0];
        REQUIRE(contact.stiffness_N_per_m[2][2] == Approx(1 / (1.0 / 25 + 4.0 / 40)).epsilon(1e-4));
        touched += contact.touching;
      }
      CHECK((touched > 50 && touched < 350));
    }
  }
}

TEST_CASE(
    "Of a probe that touches several particles the settled model lies between the settled and the instantaneous stiffness",
    "[local][sweep]") {
  for (const double depth_m : {0.8e-3, 1.2e-3, 1.6e-3}) {
    const TissueScene block = probed_block(60e-3, 35);
    const auto settled = make_solver(SolverKind::cpu_double, modelled(block, LocalModel::settled, 1e-3)),
               instantaneous = make_solver(SolverKind::cpu_double, modelled(block, LocalModel::instantaneous, 1e-3));
    for (Solver* solver : {settled.get(), instantaneous.get()}) {
      step(*solver, 1, {});
      settled_force(*solver, {0, 0, -depth_m});
    }
    const double model_N_per_m = settled->contacts()[0].stiffness_N_per_m[2][2],
                 instantaneous_N_per_m = instantaneous->contacts()[0].stiffness_N_per_m[2][2];
    const double e_m = 1e-7, above_N = settled_force(*settled, {0, 0, -depth_m + e_m}).z,
                 below_N = settled_force(*settled, {0, 0, -depth_m - e_m}).z;
    const double exact_N_per_m = (below_N - above_N) / (2 * e_m);
    CHECK(instantaneous_N_per_m > 3 * 35);  // it touches at least four particles
    CHECK(exact_N_per_m > 10);
    CHECK(model_N_per_m > 1.02 * exact_N_per_m);
    CHECK(model_N_per_m < 0.98 * instantaneous_N_per_m);
  }
}

TEST_CASE("What a probe touches far from where it began counts with its instantaneous stiffness", "[local]") {
  TissueScene plate;
  plate.lattice = {12, 6, 3};
  plate.particle_count = 12 * 6 * 3;
  plate.stiffness_N_per_m = 50;
  const double a = plate.spacing_m;
  plate.tools = {{glm::dvec3(1, 2, 2) * a + glm::dvec3(0, 0, 7e-3), 8e-3, CouplingKind::probe, 35}};
  const auto settled = make_solver(SolverKind::cpu_double, modelled(plate, LocalModel::settled, 1e-3)),
             instantaneous = make_solver(SolverKind::cpu_double, modelled(plate, LocalModel::instantaneous, 1e-3));
  for (int n = 0; n <= 100; ++n) {
    const Positions at{glm::dvec3(8 * a * n / 100, 0, 0)};
    REQUIRE(same_bits(step(*settled, 1, at), step(*instantaneous, 1, at)));  // a model changes no force
    const ToolContact &s = settled->contacts()[0], &i = instantaneous->contacts()[0];
    REQUIRE(s.touching);
    if (n == 0) CHECK(s.stiffness_N_per_m[2][2] < 0.9 * i.stiffness_N_per_m[2][2]);
    if (n == 100) CHECK(same_contact(s, i));
  }
}
