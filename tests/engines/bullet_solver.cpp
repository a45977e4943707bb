#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <memory>
#include <optional>

#include "engines.h"
#include "evenstep/time/digest.h"
#include "options.h"

namespace engines {
namespace {

using evenstep::SolverError;
using evenstep::SolverFault;

btVector3 bullet(const glm::dvec3& v) { return {btScalar(v.x), btScalar(v.y), btScalar(v.z)}; }
glm::dvec3 ours(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

using Spring = btGeneric6DofSpring2Constraint;

/// A world with everything that Bullet needs for one. Members are destroyed in reverse order, the world first.
class World {
 public:
  explicit World(int iterations) {
    world.setGravity({0, 0, 0});
    world.getSolverInfo().m_numIterations = iterations;
    world.getWorldInfo().m_gravity = {0, 0, 0};
  }
  ~World() {
    for (const auto& spring : springs) world.removeConstraint(spring.get());
    if (soft) world.removeSoftBody(soft.get());
    for (const auto& body : bodies) world.removeRigidBody(body.get());
  }

  /// A body that does not turn and touches nothing. If it has no mass, it stays where it is put.
  btRigidBody& add_body(double mass_kg, const glm::dvec3& at_m) {
    auto body = std::make_unique<btRigidBody>(btScalar(mass_kg), nullptr, &point, btVector3(0, 0, 0));
    body->setWorldTransform(btTransform(btQuaternion::getIdentity(), bullet(at_m)));
    body->setInterpolationWorldTransform(body->getWorldTransform());
    body->setAngularFactor(0);
    body->setActivationState(DISABLE_DEACTIVATION);
    world.addRigidBody(body.get(), 0, 0);
    return *bodies.emplace_back(std::move(body));
  }
  /// A spring along these axes of a frame in `a`; everything else is free. At the present places of the bodies its force is
  /// 0.
  Spring& add_spring(btRigidBody& a, btRigidBody& b, const btMatrix3x3& frame, int axes, double stiffness, double damping,
                     bool limit) {
    const btTransform in_a(frame, b.getWorldTransform().getOrigin() - a.getWorldTransform().getOrigin());
    auto spring = std::make_unique<Spring>(a, b, in_a, btTransform(frame));
    for (int axis = 0; axis < 6; ++axis) spring->setLimit(axis, 1, -1);
    for (int axis = 0; axis < axes; ++axis) {
      spring->enableSpring(axis, true);
      spring->setStiffness(axis, btScalar(stiffness), limit);
      spring->setDamping(axis, btScalar(damping), limit);
    }
    world.addConstraint(spring.get(), true);
    return *springs.emplace_back(std::move(spring));
  }

  btSphereShape point{btScalar(0.001)};
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btSoftRigidDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  std::vector<std::unique_ptr<Spring>> springs;
  std::unique_ptr<btSoftBody> soft;
};

class Bullet final : public evenstep::ForeignSolver {
 public:
  explicit Bullet(const evenstep::SolverRequest& request)
      : options_(request.options, {"model", "coupling", "coupling_damping", "stiffness", "damping", "mass", "edge",
                                   "iterations", "limit", "particles"}),
        limit_(options_.flag("limit", false)),
        world_(options_.count("iterations", 50, 1, 100'000)) {
    if (options_.has_particles())
      add_particles(options_.particles());
    else
      add_tools(request.tool_count, options_.word("model", {"tool", "soft"}) == "soft");
  }

  evenstep::ToolResponse step(std::span<const glm::dvec3> positions_m, double step_s) override {
    for (std::size_t tool = 0; tool < positions_m.size(); ++tool)
      hands_[tool]->setWorldTransform(btTransform(btQuaternion::getIdentity(), bullet(positions_m[tool])));
    world_.world.stepSimulation(btScalar(step_s), 0);
    evenstep::ToolResponse response;
    for (std::size_t tool = 0; tool < positions_m.size(); ++tool)
      response.force_N[tool] = ours(felt_[tool].m_appliedForceBodyA);
    return response;
  }

  evenstep::SolverCapabilities capabilities() const override {
    return {.state_digest = true, .particles = particles_.has_value()};
  }
  std::uint64_t state_digest() override {
    std::uint64_t digest = 0;
    const auto add = [&](const btVector3& v) {
      for (int axis = 0; axis < 3; ++axis) digest = evenstep::mix(digest, static_cast<double>(v[axis]));
    };
    for (const auto& body : world_.bodies) add(body->getWorldTransform().getOrigin()), add(body->getLinearVelocity());
    if (!world_.soft) return digest;
    for (int n = 0; n < world_.soft->m_nodes.size(); ++n) add(world_.soft->m_nodes[n].m_x), add(world_.soft->m_nodes[n].m_v);
    return digest;
  }
  evenstep::ParticleState particles() override {
    evenstep::ParticleState state;
    for (std::size_t n = 0; n < particles_->rest_m.size(); ++n) {
      const btRigidBody& body = *world_.bodies[n];
      state.displacement_m.push_back(ours(body.getWorldTransform().getOrigin()) - particles_->rest_m[n]);
      state.velocity_m_per_s.push_back(ours(body.getLinearVelocity()));
    }
    return state;
  }

 private:
  void add_tools(int count, bool soft) {
    if (soft && count > 1)
      throw SolverError(SolverFault::bad_scene, fmt::format("the model 'soft' has one tool, not {}", count),
                        "one [[device]]");
    if (soft) add_cloth(options_.count("edge", 9, 3, 99));
    felt_.resize(static_cast<std::size_t>(count));
    for (btJointFeedback& felt : felt_) add_tool(felt, soft);
  }

  /// The hand is a kinematic body: Bullet derives its speed from the places where it is put. A spring along three axes joins
  /// the tool to it.
  void add_tool(btJointFeedback& felt, bool soft) {
    btRigidBody& hand = world_.add_body(0, {});
    hand.setCollisionFlags(hand.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    hands_.push_back(&hand);
    btRigidBody& tool = world_.add_body(options_.number("mass", 0.05, 1e-9, 1e6), {});
    const btMatrix3x3 straight = btMatrix3x3::getIdentity();
    Spring& coupling = world_.add_spring(hand, tool, straight, 3, options_.number("coupling", 2000, 0, 1e12),
                                         options_.number("coupling_damping", 10, 0, 1e9), limit_);
    coupling.setJointFeedback(&felt);
    if (soft) return world_.soft->appendAnchor(world_.soft->m_nodes.size() / 2, &tool, true);
    btRigidBody& ground = world_.add_body(0, {});
    world_.add_spring(ground, tool, straight, 3, options_.number("stiffness", 200, 0, 1e12),
                      options_.number("damping", 0, 0, 1e9), limit_);
  }

  /// A square of 10 cm in the plane z = 0, held at its four corners.
  void add_cloth(int edge) {
    const btScalar half = btScalar(0.05);
    constexpr int kCorners = 1 + 2 + 4 + 8;
    world_.soft.reset(btSoftBodyHelpers::CreatePatch(world_.world.getWorldInfo(), {-half, -half, 0}, {half, -half, 0},
                                                     {-half, half, 0}, {half, half, 0}, edge, edge, kCorners, true));
    world_.soft->m_materials[0]->m_kLST = btScalar(options_.number("stiffness", 0.5, 0, 1));
    world_.soft->m_cfg.kDP = btScalar(options_.number("damping", 0.05, 0, 1));
    world_.soft->m_cfg.piterations = options_.count("iterations", 50, 1, 100'000);
    world_.soft->setTotalMass(btScalar(options_.number("mass", 0.05, 1e-9, 1e6)));
    world_.world.addSoftBody(world_.soft.get());
  }

  void add_particles(const Particles& particles) {
    particles_ = particles;
    for (std::size_t n = 0; n < particles.rest_m.size(); ++n)
      world_.add_body(particles.is_fixed[n] ? 0 : particles.mass_kg, particles.rest_m[n]);
    for (const auto& [a, b] : particles.springs) {
      const btVector3 x = bullet(particles.rest_m[b] - particles.rest_m[a]).normalized();
      btVector3 y, z;
      btPlaneSpace1(x, y, z);
      world_.add_spring(*world_.bodies[a], *world_.bodies[b],
                        {x.x(), y.x(), z.x(), x.y(), y.y(), z.y(), x.z(), y.z(), z.z()}, 1, particles.stiffness_N_per_m, 0,
                        limit_);
    }
    for (std::size_t n = 0; n < particles.displacement_m.size(); ++n) {
      btTransform at = world_.bodies[n]->getWorldTransform();
      at.setOrigin(at.getOrigin() + bullet(particles.displacement_m[n]));
      world_.bodies[n]->setWorldTransform(at);
      world_.bodies[n]->setInterpolationWorldTransform(at);
    }
  }

  Options options_;
  bool limit_;
  World world_;
  std::vector<btRigidBody*> hands_;
  std::vector<btJointFeedback> felt_;
  std::optional<Particles> particles_;
};

}  // namespace

std::unique_ptr<evenstep::ForeignSolver> make_bullet(const evenstep::SolverRequest& request) {
  return std::make_unique<Bullet>(request);
}

}  // namespace engines
