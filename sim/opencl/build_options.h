#pragma once
/// The constants of a scene as options for the compiler of the kernels, so that a kernel contains only what the scene has.

#include <string>

#include "opencl/cl_handle.h"
#include "src/features.h"
#include "src/lattice.h"
#include "src/tissue_constants.h"

namespace evenstep::internal {

/// Of the kernels that know nothing of the scene.
std::string common_options(cl_device_id device);
/// Of the scene's own kernels.
std::string build_options(const TissueConstants<float>& constants, const Lattice& lattice, const SceneFeatures& features,
                          cl_device_id device);
/// Further options for those of implicit Euler, which need them even if they are neutral.
std::string implicit_options(const TissueConstants<float>& constants, const SceneFeatures& features);

}  // namespace evenstep::internal
