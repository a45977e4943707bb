// For each tool, one mass between two springs: the tool's contact spring 2 k and a ground spring 2 k (ModeScene in scene.h).
// With w = 2 pi f0 and M = 4 k / w^2:
//   q'' = -w^2/2 q - w^2/2 (q - x) - 2 zeta w q',    F = 2 k (q - x) on the tool
// integrated by velocity Verlet with implicit damping, in substeps of at most 0.1 ms and a fiftieth of a period. If a mode
// is one-sided, everything happens along the normal, and the contact spring only pushes: without contact the mass swings on
// its ground spring.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "evenstep/time/digest.h"
#include "src/environments.h"

namespace evenstep::internal {
namespace {

constexpr double kLongestSubstep_s = 1e-4;
constexpr double kSubstepsPerPeriod = 50;

double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

void check(const ModeScene& mode) {
  check_stiffness(mode.stiffness_N_per_m, "the mode");
  if (!std::isfinite(mode.frequency_Hz) || mode.frequency_Hz <= 0)
    throw SolverError(SolverFault::bad_scene, "the mode's frequency is not positive", "a frequency in Hz");
  if (!std::isfinite(mode.damping_ratio) || mode.damping_ratio < 0)
    throw SolverError(SolverFault::bad_scene, "the mode's damping ratio is negative", "a ratio such as 0.1");
  if (!std::isfinite(mode.surface_m))
    throw SolverError(SolverFault::bad_scene, "the mode's surface is nowhere", "a length along its normal");
}

class ModeSolver final : public EnvironmentSolver {
 public:
  explicit ModeSolver(const Scene& scene)
      : EnvironmentSolver(scene),
        mode_((check(std::get<ModeScene>(scene.body)), std::get<ModeScene>(scene.body))),
        normal_(unit_normal(mode_.normal)),
        omega_(2 * std::numbers::pi * mode_.frequency_Hz),
        step_s_(period_s(scene.step_rate)),
        variable_(scene.variable_step),
        digest_(scene.needs_state_digest),
        settled_(scene.local_model == LocalModel::settled),
        nodes_(static_cast<std::size_t>(scene.tool_count)) {
    info_.substeps = substeps(step_s_);
  }

  ToolResponse step(std::span<const glm::dvec3> positions_m, std::optional<double> step_s) override {
    check_positions(positions_m);
    const double length_s = checked_length(step_s);
    ToolResponse response;
    for (std::size_t tool = 0; tool < nodes_.size(); ++tool) {
      advance(nodes_[tool], positions_m[tool], length_s);
      response.force_N[tool] = force_N(nodes_[tool].displacement_m, positions_m[tool]);
      if (tool < contacts_.size()) contacts_[tool] = contact(nodes_[tool], positions_m[tool]);
    }
    return response;
  }
  std::uint64_t state_digest() override {
    std::uint64_t digest = 0;
    if (!digest_) return digest;
    for (const Node& node : nodes_) {
      for (const glm::dvec3& v : {node.displacement_m, node.velocity_m_per_s}) digest = mix(mix(mix(digest, v.x), v.y), v.z);
    }
    return digest;
  }
  void reset() override {
    std::fill(nodes_.begin(), nodes_.end(), Node{});
    EnvironmentSolver::reset();
  }

 private:
  struct Node {
    glm::dvec3 displacement_m{0}, velocity_m_per_s{0};
    glm::dvec3 tool_m{0};
    bool touched = false;  ///< there was a first sample, so the tool's position before is known
  };

  double checked_length(std::optional<double> step_s) const {
    if (!step_s || *step_s == step_s_) return step_s_;
    if (!variable_)
      throw SolverError(SolverFault::bad_input, "a step has a length of its own", "a scene that asks for a variable step");
    if (!(*step_s >= 1e-15 && *step_s <= 1e15))
      throw SolverError(SolverFault::bad_input, "the length of a step is out of range", "1e-15 s to 1e15 s");
    return *step_s;
  }

  int substeps(double length_s) const {
    const double period_s = 1 / (mode_.frequency_Hz * std::max(1.0, mode_.damping_ratio));
    const double count = std::ceil(length_s / std::min(kLongestSubstep_s, period_s / kSubstepsPerPeriod));
    if (!(count <= kMaxSubsteps))
      throw SolverError(SolverFault::bad_scene,
                        "the mode needs more than " + std::to_string(kMaxSubsteps) + " substeps per step",
                        "a lower frequency or a smaller step size");
    return std::max(1, static_cast<int>(count));
  }

  /// The force of the contact spring on the tool at x.
  glm::dvec3 force_N(const glm::dvec3& q, const glm::dvec3& x) const {
    const double contact_N_per_m = 2 * mode_.stiffness_N_per_m;
    if (!mode_.one_sided) return (q - x) * contact_N_per_m;
    return normal_ * (contact_N_per_m * std::max(0.0, mode_.surface_m + dot(normal_, q - x)));
  }

  /// The acceleration of the mass by its two springs.
  glm::dvec3 acceleration(const glm::dvec3& q, const glm::dvec3& x) const {
    const double mass_kg = 4 * mode_.stiffness_N_per_m / (omega_ * omega_);
    return q * (-omega_ * omega_ / 2) - force_N(q, x) / mass_kg;
  }

  void advance(Node& node, const glm::dvec3& tool_m, double length_s) const {
    if (!node.touched) node.tool_m = tool_m;
    node.touched = true;
    const int count = substeps(length_s);
    const double h = length_s / count, damping_per_s = 2 * mode_.damping_ratio * omega_;
    auto& [q, v, from_m, touched] = node;
    glm::dvec3 x = from_m;
    for (int i = 1; i <= count; ++i) {
      const glm::dvec3 half = v + (acceleration(q, x) - v * damping_per_s) * (h / 2);
      q += half * h;
      x = i == count ? tool_m : from_m + (tool_m - from_m) * (static_cast<double>(i) / count);
      v = (half + acceleration(q, x) * (h / 2)) / (1 + h / 2 * damping_per_s);
    }
    from_m = tool_m;
  }

  ToolContact contact(const Node& node, const glm::dvec3& x) const {
    const double stiffness = (settled_ ? 1 : 2) * mode_.stiffness_N_per_m;
    if (!mode_.one_sided) return {.touching = true, .point_m = x, .stiffness_N_per_m = glm::dmat3(stiffness)};
    const double gap_m = dot(normal_, x - node.displacement_m) - mode_.surface_m;
    return {gap_m <= 0, true, x, normal_, gap_m, along(normal_, stiffness)};
  }

  ModeScene mode_;
  glm::dvec3 normal_;
  double omega_;
  double step_s_;
  bool variable_, digest_, settled_;
  std::vector<Node> nodes_;
};

}  // namespace

std::unique_ptr<Solver> make_mode_solver(const Scene& scene) { return std::make_unique<ModeSolver>(scene); }

}  // namespace evenstep::internal
