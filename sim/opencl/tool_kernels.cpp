#include "opencl/tool_kernels.h"

namespace evenstep::internal {

ToolKernels::ToolKernels(const CellBuffers& cells, const std::vector<std::uint32_t>& watched, const ClCommands& commands)
    : cells_(cells), watched_(watched), commands_(commands) {
  std::vector<cl_uint> grabbed, coupled;
  std::size_t probes = 0;
  for (std::size_t tool = 0; tool < cells.scene.tools.size(); ++tool) {
    const auto& held = cells.lattice.held[tool];
    std::vector<cl_uint>& to = cells.features.grab[tool] ? grabbed : coupled;
    to.insert(to.end(), held.begin(), held.end());
    probes += cells.is_probe(tool);
  }
  grabbed_count_ = grabbed.size();
  coupled_count_ = coupled.size();
  if (!grabbed.empty()) grabbed_ = commands.buffer_of(grabbed);
  if (!coupled.empty()) coupled_ = commands.buffer_of(coupled);
  if (probes > 0) probe_cells_ = commands.buffer(cells.lattice.span * cells.features.probe_values() * sizeof(float));
  if (!watched.empty()) watched_cells_ = commands.buffer_of(watched);
  result_ = ClResults(commands, 3 * (grabbed_count_ + coupled_count_) + probes * probe_size() + 3 * watched.size());
}

void ToolKernels::bind(std::size_t direction, const ClField& u, const ClField& v) {
  Kernels& kernels = kernels_[direction];
  if (grabbed_count_ > 0) bind_grab(kernels, u, v);
  if (coupled_count_ > 0) {
    kernels.coupling_force = commands_.kernel("coupling_force");
    kernels.coupling_force.add(coupled_, static_cast<cl_uint>(coupled_count_), u, v);
    cells_.add_tools(kernels.coupling_force);
    kernels.coupling_force.add(static_cast<cl_uint>(3 * grabbed_count_), result_.buffer());
  }
  if (!watched_.empty()) {
    kernels.displacements = commands_.kernel("displacements");
    kernels.displacements.add(watched_cells_, static_cast<cl_uint>(watched_.size()), u, static_cast<cl_uint>(watched_at()),
                              result_.buffer());
  }
  for (std::size_t tool = 0; tool < cells_.scene.tools.size(); ++tool) {
    if (!cells_.is_probe(tool)) continue;
    bind_probe(kernels.probe[tool], tool, u);
    probe_sums_[tool] = commands_.kernel("probe_sums");
    probe_sums_[tool].add(probe_cells_, cl_ulong{cells_.chunks()}, static_cast<cl_uint>(probe_at(tool)), result_.buffer());
  }
}

void ToolKernels::bind_grab(Kernels& kernels, const ClField& u, const ClField& v) const {
  if (!cells_.holding.get()) {
    const cl_float4 none{};
    kernels.grab = commands_.kernel("grab");
    add_grabbed(kernels.grab);
    kernels.grab.tools_at = kernels.grab.next();
    kernels.grab.add(none, none, none, none, u, v);
  }
  kernels.grab_force = commands_.kernel("grab_force");
  kernels.grab_force.add(grabbed_, static_cast<cl_uint>(grabbed_count_), u);
  if (cells_.features.axial_damping) kernels.grab_force.add(v);
  kernels.grab_force.add(cells_.active);
  if (cells_.features.regions) kernels.grab_force.add(cells_.stiffness);
  kernels.grab_force.add(cl_uint{0}, result_.buffer());
}

void ToolKernels::bind_probe(BoundKernel& probe, std::size_t tool, const ClField& u) {
  const ToolConstants<float>& constants = cells_.constants.tools[tool];
  const auto& [x, y, z] = constants.center_m;
  probe = commands_.kernel(cells_.features.local_model ? "probe_model_cells" : "probe_cells");
  probe.add(u, cells_.rest_m, cells_.mobile, cl_ulong{cells_.lattice.first}, constants.stiffness);
  radius_at_ = probe.next();
  probe.add(constants.radius_m, cl_float4{{x, y, z, 0}}, probe_cells_);
  probe.tools_at = probe.next();
  probe.add(cl_float4{});
}

void ToolKernels::add_grabbed(BoundKernel& kernel) const {
  const std::size_t of_tool_0 = cells_.features.grab[0] ? cells_.lattice.held[0].size() : 0;
  kernel.add(grabbed_, static_cast<cl_uint>(grabbed_count_), static_cast<cl_uint>(of_tool_0));
}

void ToolKernels::enqueue_grabbed(const BoundKernel& kernel) const {
  commands_.enqueue(kernel, commands_.padded(grabbed_count_));
}

void ToolKernels::put_grabs(std::size_t direction, const ToolStates& tools) {
  if (grabbed_count_ == 0) return;
  BoundKernel& grab = kernels_[direction].grab;
  set_tool_states(grab, grab.tools_at, tools);
  enqueue_grabbed(grab);
}

void ToolKernels::read(std::size_t direction, const ToolStates& now, ToolReadings& readings) {
  if (result_.empty()) return commands_.finish();
  Kernels& kernels = kernels_[direction];
  result_.give_back();
  if (grabbed_count_ > 0) enqueue_grabbed(kernels.grab_force);
  if (coupled_count_ > 0) {
    cells_.set_tools(kernels.coupling_force, now);
    commands_.enqueue(kernels.coupling_force, commands_.padded(coupled_count_));
  }
  for (std::size_t tool = 0; tool < cells_.scene.tools.size(); ++tool) {
    if (cells_.is_probe(tool)) enqueue_probe(kernels, tool, now, cells_.constants.tools[tool].radius_m);
  }
  if (!watched_.empty()) commands_.enqueue(kernels.displacements, commands_.padded(watched_.size()));
  take_result(result_.read(), readings);
}

void ToolKernels::enqueue_probe(Kernels& kernels, std::size_t tool, const ToolStates& now, float radius_m) {
  BoundKernel& probe = kernels.probe[tool];
  probe.set(radius_at_, radius_m);
  probe.set(probe.tools_at, float4(now[tool].offset_m));
  commands_.enqueue(probe, cells_.lattice.span);
  commands_.enqueue(probe_sums_[tool], probe_size());
}

ProbeSums ToolKernels::probe_result(std::span<const float> result, std::size_t tool) const {
  return add_partials(result.subspan(probe_at(tool), probe_size()), cells_.features.local_model);
}

ProbeSums ToolKernels::read_probe(std::size_t direction, std::size_t tool, const ToolStates& now, float radius_m) {
  result_.give_back();
  enqueue_probe(kernels_[direction], tool, now, radius_m);
  return probe_result(result_.read(), tool);
}

void ToolKernels::take_result(std::span<const float> result, ToolReadings& readings) const {
  std::size_t n = 0, grabbed = 0, coupled = 3 * grabbed_count_;
  for (std::size_t tool = 0; tool < cells_.scene.tools.size(); ++tool) {
    std::size_t& from = cells_.features.grab[tool] ? grabbed : coupled;
    for (std::size_t held = 0; held < cells_.lattice.held[tool].size(); ++held, from += 3)
      readings.held_N[n++] = {result[from], result[from + 1], result[from + 2]};
    if (!cells_.is_probe(tool)) continue;
    readings.probes[tool] = probe_result(result, tool);
  }
  for (std::size_t w = 0; w < watched_.size(); ++w) {
    const std::size_t from = watched_at() + 3 * w;
    readings.displacement_m[w] = {result[from], result[from + 1], result[from + 2]};
  }
}

}  // namespace evenstep::internal
