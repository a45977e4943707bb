#pragma once
/// The constants of a scene as options for the kernels' compiler: only what the scene has is in the kernels.

#include <string>

#include "opencl/cl_handle.h"
#include "src/features.h"
#include "src/lattice.h"
#include "src/tissue_constants.h"

namespace evenstep::internal {

std::string build_options(const TissueConstants<float>& constants, const Lattice& lattice, const SceneFeatures& features,
                          cl_device_id device);
/// What the kernels of implicit Euler need beside these, be it neutral.
std::string implicit_options(const TissueConstants<float>& constants, const SceneFeatures& features);

}  // namespace evenstep::internal
