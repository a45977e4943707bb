// The reference of a study, compared with SUNDIALS CVODE (Adams, variable order and step). That is another solver, and the
// equations of the tissue are written again from their definition, with positions instead of displacements and a list of
// springs.
#include <cvode/cvode.h>
#include <fmt/format.h>
#include <nvector/nvector_serial.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <glm/geometric.hpp>

#include "src/study/trace.h"
#include "study_scenes.h"

using namespace evenstep;
using namespace evenstep::internal;
using namespace evenstep::test;

namespace {

/// A block with its bottom fixed and the particles around one tool moving at its constant velocity from t = 0 on.
class Block {
 public:
  explicit Block(const Scenario& scenario) : scene_(std::get<TissueScene>(scenario.scene.body)) {
    tool_m_per_s_ = std::get<ConstantVelocity>(scenario.devices[0].motion.shape).velocity_m_per_s;
    const auto [nx, ny, nz] = scene_.lattice;
    for (int z = 0; z < nz; ++z) {
      for (int y = 0; y < ny; ++y) {
        for (int x = 0; x < nx; ++x) {
          const glm::dvec3 at = glm::dvec3(x, y, z) * scene_.spacing_m;
          rest_m_.push_back(at);
          held_.push_back(glm::distance(at, scene_.tools[0].center_m) <= scene_.tools[0].radius_m);
          mobile_.push_back(held_.back() || z == 0 ? -1 : mobile_count_++);
        }
      }
    }
    for (std::size_t i = 0; i < rest_m_.size(); ++i) {
      for (std::size_t j = i + 1; j < rest_m_.size(); ++j) {
        if (glm::distance(rest_m_[i], rest_m_[j]) < 1.5 * scene_.spacing_m)
          springs_.push_back({i, j});  // sqrt(2), not sqrt(3)
      }
    }
  }

  std::size_t unknowns() const { return static_cast<std::size_t>(mobile_count_) * 6; }
  std::size_t particles() const { return rest_m_.size(); }
  std::size_t springs() const { return springs_.size(); }

  glm::dvec3 displacement_m(std::size_t i, double t, const double* y) const {
    if (mobile_[i] >= 0) return read(y, mobile_[i]);
    return held_[i] ? tool_m_per_s_ * t : glm::dvec3(0);
  }
  glm::dvec3 velocity_m_per_s(std::size_t i, const double* y) const {
    if (mobile_[i] >= 0) return read(y, mobile_count_ + mobile_[i]);
    return held_[i] ? tool_m_per_s_ : glm::dvec3(0);
  }

  /// The forces of springs and dampers on every particle.
  std::vector<glm::dvec3> forces_N(double t, const double* y) const {
    std::vector<glm::dvec3> forces(rest_m_.size(), glm::dvec3(0));
    for (const auto& [i, j] : springs_) {
      const glm::dvec3 d = rest_m_[j] + displacement_m(j, t, y) - rest_m_[i] - displacement_m(i, t, y);
      const double length = glm::length(d), rest = glm::distance(rest_m_[i], rest_m_[j]);
      const glm::dvec3 n = d / length, parting = velocity_m_per_s(j, y) - velocity_m_per_s(i, y);
      const glm::dvec3 f =
          n * (scene_.stiffness_N_per_m * (length - rest) + scene_.axial_damping_N_s_per_m * glm::dot(parting, n));
      forces[i] += f;
      forces[j] -= f;
    }
    return forces;
  }

  void derivative(double t, const double* y, double* dy) const {
    const std::vector<glm::dvec3> forces = forces_N(t, y);
    for (std::size_t i = 0; i < rest_m_.size(); ++i) {
      if (mobile_[i] < 0) continue;
      write(dy, mobile_[i], velocity_m_per_s(i, y));
      write(dy, mobile_count_ + mobile_[i], forces[i] / scene_.particle_mass_kg);
    }
  }

  glm::dvec3 hand_N(double t, const double* y) const {
    const std::vector<glm::dvec3> forces = forces_N(t, y);
    glm::dvec3 sum(0);
    for (std::size_t i = 0; i < rest_m_.size(); ++i) {
      if (held_[i]) sum += forces[i];
    }
    return sum;
  }

  double energy_J(double t, const double* y) const {
    double energy = 0;
    for (const auto& [i, j] : springs_) {
      const double stretch = glm::length(rest_m_[j] + displacement_m(j, t, y) - rest_m_[i] - displacement_m(i, t, y)) -
                             glm::distance(rest_m_[i], rest_m_[j]);
      energy += scene_.stiffness_N_per_m * stretch * stretch / 2;
    }
    for (std::size_t i = 0; i < rest_m_.size(); ++i) {
      const glm::dvec3 v = velocity_m_per_s(i, y);
      if (mobile_[i] >= 0) energy += scene_.particle_mass_kg * glm::dot(v, v) / 2;
    }
    return energy;
  }

 private:
  static glm::dvec3 read(const double* y, int n) { return {y[3 * n], y[3 * n + 1], y[3 * n + 2]}; }
  static void write(double* y, int n, const glm::dvec3& v) {
    for (int axis = 0; axis < 3; ++axis) y[3 * n + axis] = v[axis];
  }

  TissueScene scene_;
  glm::dvec3 tool_m_per_s_{0};
  std::vector<glm::dvec3> rest_m_;
  std::vector<bool> held_;
  std::vector<int> mobile_;
  int mobile_count_ = 0;
  std::vector<std::pair<std::size_t, std::size_t>> springs_;
};

int right_hand_side(double t, N_Vector y, N_Vector dy, void* block) {
  static_cast<const Block*>(block)->derivative(t, N_VGetArrayPointer(y), N_VGetArrayPointer(dy));
  return 0;
}

StudyTrace solve(Block& block, const Scenario& scenario, const StudyPlan& plan, double tolerance) {
  SUNContext context = nullptr;
#ifdef SUN_COMM_NULL  // since SUNDIALS 7
  REQUIRE(SUNContext_Create(SUN_COMM_NULL, &context) == 0);
#else
  REQUIRE(SUNContext_Create(nullptr, &context) == 0);
#endif
  N_Vector y = N_VNew_Serial(static_cast<sunindextype>(block.unknowns()), context);
  N_VConst(0, y);
  void* memory = CVodeCreate(CV_ADAMS, context);
  REQUIRE(CVodeInit(memory, right_hand_side, 0, y) == CV_SUCCESS);
  REQUIRE(CVodeSetUserData(memory, &block) == CV_SUCCESS);
  REQUIRE(CVodeSStolerances(memory, tolerance, tolerance * 1e-4) == CV_SUCCESS);  // for motions of 1e-3 m and 1e-1 m/s
  REQUIRE(CVodeSetMaxNumSteps(memory, 1'000'000) == CV_SUCCESS);
  SUNNonlinearSolver iteration = SUNNonlinSol_FixedPoint(y, 0, context);
  REQUIRE(CVodeSetNonlinearSolver(memory, iteration) == CV_SUCCESS);
  StudyTrace trace;
  for (std::int64_t s = 1; s <= plan.samples; ++s) {
    const double wanted = static_cast<double>(s * plan.stride) * period_s(scenario.scene.step_rate);
    double t = 0;
    REQUIRE(CVodeSetStopTime(memory, wanted) == CV_SUCCESS);
    REQUIRE(CVode(memory, wanted, y, &t, CV_NORMAL) >= 0);
    const double* state = N_VGetArrayPointer(y);
    std::vector<glm::dvec3> u(block.particles());
    for (std::size_t i = 0; i < u.size(); ++i) u[i] = block.displacement_m(i, wanted, state);
    trace.displacement_m.push_back(std::move(u));
    trace.force_N.push_back({block.hand_N(wanted, state), glm::dvec3(0)});
    trace.energy_J.push_back(block.energy_J(wanted, state));
  }
  SUNNonlinSolFree(iteration);
  CVodeFree(&memory);
  N_VDestroy(y);
  SUNContext_Free(&context);
  return trace;
}

}  // namespace

TEST_CASE("CVODE and the reference agree to within what both state, with and without damping, soft and stiff", "[sweep]") {
  for (const char* stiffness : {"20 N/m", "2 kN/m"}) {
    for (const char* damping : {"0 N s/m", "4 mN s/m"}) {
      INFO(stiffness << " " << damping);
      const Scenario scenario = small_study(
          {fmt::format("scene.stiffness=\"{}\"", stiffness), fmt::format("scene.axial_damping=\"{}\"", damping)});
      const StudyPlan plan(scenario, {{1, 1}});
      const StudyReferenceRun reference = solve_reference(scenario, plan, 1);
      Block block(scenario);
      CHECK(block.springs() == 300 + 480);  // 3 * 4 * 5^2 along the axes, 6 * 4^2 * 5 along the diagonals of faces
      const StudyTrace coarse = solve(block, scenario, plan, 1e-9), fine = solve(block, scenario, plan, 1e-11);
      const StudyValues own = error_of(coarse, fine, reference.info.scale);
      const StudyValues difference = error_of(reference.trace, fine, reference.info.scale);
      for (const StudyQuantity q : kStudyQuantities) {
        INFO(name_of(q) << " estimate " << reference.info.estimate[q] << " CVODE " << own[q]);
        CHECK(difference[q] <= reference.info.estimate[q] + own[q]);
        CHECK(reference.info.estimate[q] + own[q] < 1e-3);  // otherwise agreement would mean little
      }
    }
  }
}
