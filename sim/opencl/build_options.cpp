#include "opencl/build_options.h"

#include <fmt/format.h>

namespace evenstep::internal {
namespace {

/// "%a" is exact; a decimal rendering of 20.0f is not even a float literal.
std::string hex(float value) { return fmt::format("{:a}f", value); }

/// A component of a spring at rest, which the kernels add. Adding -0 changes no number, so the compiler leaves that addition
/// out; adding 0 would turn -0 into 0. No result tells them apart: a component that is 0 is squared, or multiplied and added
/// to a sum that began with 0, and such a sum never is -0.
std::string rest(float value) { return value == 0 ? "-0.0f" : hex(value); }

/// Every spring, coupling and probe with its constants, as arguments of macros (kernels/springs.cl).
std::string tissue_options(const TissueConstants<float>& constants, const Lattice& lattice, const SceneFeatures& features) {
  std::string springs, couplings, probes;
  for (std::size_t s = 0; s < kNeighbours; ++s) {
    const auto& [x, y, z] = constants.rest_m[s];
    springs += fmt::format("S({},{},{},{},{},{})", lattice.offset[s], rest(x), rest(y), rest(z), hex(constants.length_m[s]),
                           hex(constants.axial_s_per_m2[s]));
  }
  for (std::size_t t = 0; t < kMaxTools; ++t) {
    const ToolConstants<float>& tool = constants.tools[t];
    const auto& [x, y, z] = tool.center_m;
    if (features.spring[t])
      couplings +=
          fmt::format("C({},{},{},{})", t, hex(tool.stiffness), hex(tool.damping_s), hex(tool.half_stiffness_N_per_m));
    if (features.probe[t])
      probes += fmt::format("P({},{},{},{},{},{},{})", t, hex(tool.stiffness), hex(tool.half_stiffness_N_per_m),
                            hex(tool.radius_m), hex(x), hex(y), hex(z));
  }
  std::string options = "-DSPRINGS(S)=" + springs;
  if (!couplings.empty()) options += " -DCOUPLINGS(C)=" + couplings;
  if (features.grab[0]) options += " -DGRAB0";
  if (features.grab[1]) options += " -DGRAB1";
  if (features.spring[0]) options += " -DHELD0";
  if (features.spring[1]) options += " -DHELD1";
  if (!probes.empty()) options += " -DPROBED -DPROBES(P)=" + probes;
  return options;
}

}  // namespace

std::string common_options(cl_device_id device) {
  std::string options = fmt::format("-DCHUNK={}", kChunk);
  cl_device_fp_config config = 0;
  check_cl(cl().clGetDeviceInfo(device, CL_DEVICE_SINGLE_FP_CONFIG, sizeof config, &config, nullptr), "clGetDeviceInfo");
  // By default, GPUs may be off by 2.5 to 3 ulp in / and sqrt.
  if (config & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) options += " -cl-fp32-correctly-rounded-divide-sqrt";
  return options;
}

std::string build_options(const TissueConstants<float>& constants, const Lattice& lattice, const SceneFeatures& features,
                          cl_device_id device) {
  std::string options = common_options(device) + ' ' + tissue_options(constants, lattice, features);
  options += fmt::format(" -DSTIFFNESS={} -DSTIFFNESS_PER_KG={} -DHALF_MASS={} -DQUARTER_STIFFNESS={} -DFIRST={}UL",
                         hex(constants.stiffness_N_per_m), hex(constants.stiffness_per_kg), hex(constants.half_mass_kg),
                         hex(constants.quarter_stiffness_N_per_m), lattice.first);
  const auto vector = [](const char* name, const std::array<float, 3>& v) {
    return fmt::format(" -D{0}_x={1} -D{0}_y={2} -D{0}_z={3}", name, hex(v[0]), hex(v[1]), hex(v[2]));
  };
  if (features.regions) options += " -DREGIONS";
  if (features.axial_damping) options += " -DAXIAL_DAMPING";
  if (features.damping) options += " -DDAMPING -DDAMPING_PER_S=" + hex(constants.damping_per_s);
  if (features.gravity)
    options += " -DGRAVITY" + vector("GRAVITY", constants.gravity_m_per_s2) + vector("WEIGHT", constants.weight_N);
  if (features.variable_step) {
    options += " -DVARIABLE_STEP";
  } else {
    options += fmt::format(" -DSTEP={} -DHALF_STEP={} -DACCELERATION={} -DDECAY={}", hex(constants.step_s),
                           hex(constants.half_step_s), hex(constants.acceleration), hex(constants.decay));
    if (features.gravity) options += vector("STEP_GRAVITY", constants.gravity);
  }
  return options;
}

std::string implicit_options(const TissueConstants<float>& constants, const SceneFeatures& features) {
  const auto& [x, y, z] = constants.gravity_m_per_s2;
  const bool general = features.regions || features.axial_damping || features.tool_forces();
  return fmt::format(" -DDRAG_PER_S={} -DFALL_x={} -DFALL_y={} -DFALL_z={}{}", hex(constants.damping_per_s), hex(x), hex(y),
                     hex(z), general ? " -DGENERAL_SYSTEM" : "");
}

}  // namespace evenstep::internal
