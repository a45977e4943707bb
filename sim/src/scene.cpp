#include "evenstep/sim/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace evenstep {
namespace {

double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

}  // namespace

std::optional<double> SpringScene::stored_energy_J(const glm::dvec3& x) const { return stiffness_N_per_m * dot(x, x) / 2; }
std::string SpringScene::text() const { return fmt::format("spring {:.6g} N/m", stiffness_N_per_m); }

std::optional<double> WallScene::stored_energy_J(const glm::dvec3& x) const {
  const double depth_m = std::max(0.0, surface_m - dot(normal, x) / std::sqrt(dot(normal, normal)));
  const double harder = hardening_m > 0 ? 2 * depth_m / (3 * hardening_m) : 0;
  return stiffness_N_per_m * depth_m * depth_m / 2 * (1 + harder);
}
std::string WallScene::text() const {
  return fmt::format("wall {:.6g} N/m{}", stiffness_N_per_m,
                     hardening_m > 0 ? fmt::format(", hardening over {:.6g} mm", 1e3 * hardening_m) : "");
}

std::optional<double> ModeScene::stored_energy_J(const glm::dvec3&) const { return std::nullopt; }
std::string ModeScene::text() const {
  return fmt::format("mode {:.6g} N/m at rest, {:.6g} Hz, damping ratio {:.6g}{}", stiffness_N_per_m, frequency_Hz,
                     damping_ratio, one_sided ? ", one-sided" : "");
}

std::optional<double> TissueScene::stored_energy_J(const glm::dvec3&) const { return std::nullopt; }
std::string TissueScene::text() const {
  return fmt::format("tissue, {} particles on {} x {} x {}, {:.6g} N/m{}", particle_count, lattice[0], lattice[1],
                     lattice[2], stiffness_N_per_m,
                     regions.empty() ? "" : fmt::format(", and {} more materials", regions.size()));
}

std::optional<double> ForeignScene::stored_energy_J(const glm::dvec3&) const { return std::nullopt; }
std::string ForeignScene::text() const { return fmt::format("'{}', {}", name, origin); }

bool accounts_energy(const Scene& scene) {
  return std::visit([](const auto& body) { return body.kAccountsEnergy; }, scene.body);
}
bool costs_little(const Scene& scene) {
  return std::visit([](const auto& body) { return body.kCostsLittle; }, scene.body);
}
bool is_memoryless(const Scene& scene) {
  return std::visit([](const auto& body) { return body.kMemoryless; }, scene.body);
}
bool has_stiffness(const Scene& scene) {
  return std::visit(
      [](const auto& body) {
        return requires { body.stiffness_N_per_m; };
      },
      scene.body);
}
std::optional<double> felt_stiffness_N_per_m(const Scene& scene) {
  return std::visit([](const auto& body) { return body.felt_stiffness_N_per_m(); }, scene.body);
}
std::optional<double> stored_energy_J(const Scene& scene, const glm::dvec3& tool_m) {
  return std::visit([&](const auto& body) { return body.stored_energy_J(tool_m); }, scene.body);
}
std::string describe(const Scene& scene) {
  return std::visit([](const auto& body) { return body.text(); }, scene.body);
}

}  // namespace evenstep
