#include "bullet_block.h"

#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <cstdint>
#include <vector>

namespace evenstep::bench {

struct BulletBlock::World {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btSoftRigidDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  btSoftBody* body = nullptr;  // owned by the world
  std::vector<int> held;
  std::vector<btVector3> rest_m;
  btScalar step_s = 0;
};

BulletBlock::BulletBlock(const TissueScene& scene, double step_s, int iterations) : world_(std::make_unique<World>()) {
  World& w = *world_;
  w.step_s = static_cast<btScalar>(step_s);
  w.world.setGravity(btVector3(0, 0, 0));
  w.world.getWorldInfo().m_gravity = btVector3(0, 0, 0);
  const auto [nx, ny, nz] = scene.lattice;
  const ToolCoupling& grab = scene.tools.front();
  std::vector<btVector3> positions_m;
  std::vector<btScalar> masses_kg;
  for (std::int64_t site = 0; site < scene.particle_count; ++site) {
    const glm::dvec3 at_m = glm::dvec3(site % nx, site / nx % ny, site / nx / ny) * scene.spacing_m;
    const glm::dvec3 away_m = at_m - grab.center_m;
    const bool fixed = scene.fixed.z_min && site < std::int64_t{nx} * ny;
    const bool held =
        !fixed && away_m.x * away_m.x + away_m.y * away_m.y + away_m.z * away_m.z <= grab.radius_m * grab.radius_m;
    positions_m.emplace_back(static_cast<btScalar>(at_m.x), static_cast<btScalar>(at_m.y), static_cast<btScalar>(at_m.z));
    masses_kg.push_back(fixed || held ? 0 : static_cast<btScalar>(scene.particle_mass_kg));
    if (!held) continue;
    w.held.push_back(static_cast<int>(site));
    w.rest_m.push_back(positions_m.back());
  }
  const auto count = static_cast<int>(positions_m.size());
  w.body = new btSoftBody(&w.world.getWorldInfo(), count, positions_m.data(), masses_kg.data());
  w.body->m_materials[0]->m_kLST = 1;
  w.body->m_cfg.piterations = iterations;
  w.body->m_cfg.collisions = 0;
  const auto link = [&](int from, int x, int y, int z) {
    if (x < 0 || x >= nx || y < 0 || y >= ny || z >= nz) return;
    const int to = x + nx * (y + ny * z);
    if (to < count) w.body->appendLink(from, to);
  };
  for (int from = 0; from < count; ++from) {
    const int x = from % nx, y = from / nx % ny, z = from / nx / ny;
    constexpr int kForward[9][3] = {{1, 0, 0}, {0, 1, 0},  {0, 0, 1}, {1, 1, 0}, {-1, 1, 0},
                                    {1, 0, 1}, {-1, 0, 1}, {0, 1, 1}, {0, -1, 1}};
    for (const auto& [dx, dy, dz] : kForward) link(from, x + dx, y + dy, z + dz);
  }
  w.world.addSoftBody(w.body);
}

BulletBlock::~BulletBlock() {
  world_->world.removeSoftBody(world_->body);
  delete world_->body;
}

void BulletBlock::step(double offset_m) {
  World& w = *world_;
  for (std::size_t n = 0; n < w.held.size(); ++n)
    w.body->m_nodes[w.held[n]].m_x = w.rest_m[n] + btVector3(static_cast<btScalar>(offset_m), 0, 0);
  w.world.stepSimulation(w.step_s, 0);
}

}  // namespace evenstep::bench
