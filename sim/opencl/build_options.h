#pragma once
/// The constants of a scene as options for the compiler of the kernels, so that a kernel contains only what the scene has.

#include <string>

#include "opencl/cl_handle.h"
#include "src/features.h"
#include "src/lattice.h"
#include "src/tissue_constants.h"

namespace evenstep::internal {

std::string build_options(const TissueConstants<float>& constants, const Lattice& lattice, const SceneFeatures& features,
                          cl_device_id device);
/// Of the sums over chunks, which know nothing of the scene.
std::string sums_options();
/// Further options for the kernels of implicit Euler, which need them even if they are neutral.
std::string implicit_options(const TissueConstants<float>& constants, const SceneFeatures& features);

}  // namespace evenstep::internal
