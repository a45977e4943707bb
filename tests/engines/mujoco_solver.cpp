#include <mujoco/mujoco.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <mutex>

#include "engines.h"
#include "evenstep/time/digest.h"
#include "mujoco_models.h"

namespace engines {
namespace {

using evenstep::SolverError;
using evenstep::SolverFault;

struct Deleter {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};

/// MuJoCo's reader of XML keeps the last model in a global variable. Its warnings go to a global function, which by default
/// writes MUJOCO_LOG.TXT. Here the text of a warning is read from the data instead.
std::unique_ptr<mjModel, Deleter> compile(const std::string& text) {
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  mju_user_warning = [](const char*) {};
  const auto files = std::make_unique<mjVFS>();  // 2 MB: too large for a stack
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), "model.xml", static_cast<int>(text.size()));
  std::memcpy(files->filedata[mj_findFileVFS(files.get(), "model.xml")], text.data(), text.size());
  char error[1000] = "";
  std::unique_ptr<mjModel, Deleter> model(mj_loadXML("model.xml", files.get(), error, sizeof error));
  mj_deleteVFS(files.get());
  if (!model) throw SolverError(SolverFault::bad_scene, std::string("MuJoCo refuses the model: ") + error, "see its XML");
  return model;
}

class Mujoco final : public evenstep::ForeignSolver {
 public:
  explicit Mujoco(const evenstep::SolverRequest& request)
      : scene_(mujoco_scene(request)), model_(compile(scene_.xml)), data_(mj_makeData(model_.get())) {
    for (int tool = 0; tool < request.tool_count; ++tool)
      holds_.push_back(mj_name2id(model_.get(), mjOBJ_EQUALITY, fmt::format("hold{}", tool).c_str()));
    reset();
  }

  evenstep::ToolResponse step(std::span<const glm::dvec3> positions_m, double step_s) override {
    for (std::size_t tool = 0; tool < positions_m.size(); ++tool) {
      for (int axis = 0; axis < 3; ++axis)
        data_->mocap_pos[3 * tool + axis] = scene_.tool_rest_m[axis] + positions_m[tool][axis];
    }
    model_->opt.timestep = step_s;
    mj_step(model_.get(), data_.get());
    refuse_instability();
    evenstep::ToolResponse response;
    for (std::size_t tool = 0; tool < positions_m.size(); ++tool) response.force_N[tool] = held_N(holds_[tool]);
    return response;
  }

  evenstep::SolverCapabilities capabilities() const override {
    return {.state_digest = true, .energy = true, .particles = scene_.particles.has_value(), .reset = true};
  }
  std::uint64_t state_digest() override {
    std::uint64_t digest = 0;
    for (int i = 0; i < model_->nq; ++i) digest = evenstep::mix(digest, data_->qpos[i]);
    for (int i = 0; i < model_->nv; ++i) digest = evenstep::mix(digest, data_->qvel[i]);
    return digest;
  }
  /// The energy that MuJoCo has at the begin of the last step: of gravity, springs and motion, without what constraints
  /// store.
  double energy_J() override { return data_->energy[0] + data_->energy[1]; }
  evenstep::ParticleState particles() override {
    evenstep::ParticleState state;
    const Particles& particles = *scene_.particles;
    const double *x = data_->qpos, *v = data_->qvel;
    for (const bool fixed : particles.is_fixed) {
      state.displacement_m.push_back(fixed ? glm::dvec3(0) : glm::dvec3(x[0], x[1], x[2]));
      state.velocity_m_per_s.push_back(fixed ? glm::dvec3(0) : glm::dvec3(v[0], v[1], v[2]));
      if (!fixed) x += 3, v += 3;
    }
    return state;
  }
  void reset() override {
    mj_resetData(model_.get(), data_.get());
    if (!scene_.particles) return;
    double* x = data_->qpos;
    for (std::size_t n = 0; n < scene_.particles->rest_m.size(); ++n) {
      if (scene_.particles->is_fixed[n]) continue;
      for (int axis = 0; axis < 3; ++axis) *x++ = scene_.particles->displacement_m[n][axis];
    }
  }

 private:
  /// The force of a weld or ball joint on the hand: the first three of its rows.
  glm::dvec3 held_N(int hold) const {
    for (int row = 0; row < data_->ne; ++row) {
      const double* force_N = data_->efc_force + row;
      if (data_->efc_id[row] == hold) return {force_N[0], force_N[1], force_N[2]};
    }
    return glm::dvec3(0);
  }
  /// MuJoCo resets an unstable scene to its begin and goes on. A hand would feel that, so it is an error here.
  void refuse_instability() const {
    for (const int kind : {mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC, mjWARN_BADCTRL}) {
      const mjWarningStat& warning = data_->warning[kind];
      if (warning.number > 0)
        throw SolverError(SolverFault::unstable_step,
                          std::string("MuJoCo reset the scene: ") + mju_warningText(kind, warning.lastinfo),
                          "a shorter step, less stiffness or more mass");
    }
    for (const int kind : {mjWARN_CONTACTFULL, mjWARN_CNSTRFULL}) {
      if (data_->warning[kind].number > 0)
        throw SolverError(SolverFault::bad_scene, std::string("MuJoCo: ") + mju_warningText(kind, 0),
                          "a larger <size> in the model");
    }
  }

  MujocoScene scene_;
  std::unique_ptr<mjModel, Deleter> model_;
  std::unique_ptr<mjData, Deleter> data_;
  std::vector<int> holds_;
};

}  // namespace

std::unique_ptr<evenstep::ForeignSolver> make_mujoco(const evenstep::SolverRequest& request) {
  return std::make_unique<Mujoco>(request);
}

}  // namespace engines
