#pragma once
/// The constants of a scene as options for the compiler of the kernels, so that a kernel contains only what the scene has.

#include <string>

#include "opencl/cl_handle.h"
#include "src/features.h"
#include "src/tissue/constants.h"
#include "src/tissue/lattice.h"

namespace evenstep::internal {

/// For the kernels that do not depend on the scene.
std::string common_options(cl_device_id device);
/// For the scene's own kernels.
std::string build_options(const TissueConstants<float>& constants, const Lattice& lattice, const SceneFeatures& features,
                          cl_device_id device);
/// Further options for the kernels of implicit Euler, which need these constants even if they are neutral.
std::string implicit_options(const TissueConstants<float>& constants, const SceneFeatures& features);

}  // namespace evenstep::internal
