#pragma once
/// The functions of OpenCL that the solver calls. The loader, libOpenCL, is opened when the first of them is called: a run
/// of a spring never loads it.

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

// clang-format off
#define EVENSTEP_CL_FUNCTIONS(X)                                                                                   \
  X(clBuildProgram) X(clCreateBuffer) X(clCreateCommandQueue) X(clCreateContext) X(clCreateKernel)                 \
  X(clCreateProgramWithSource) X(clEnqueueCopyBuffer) X(clEnqueueFillBuffer) X(clEnqueueNDRangeKernel)             \
  X(clEnqueueMapBuffer) X(clEnqueueReadBuffer) X(clEnqueueUnmapMemObject) X(clEnqueueWriteBuffer)                  \
  X(clFinish) X(clGetDeviceIDs) X(clGetDeviceInfo)                                                                 \
  X(clGetEventProfilingInfo) X(clGetPlatformIDs) X(clGetPlatformInfo) X(clGetProgramBuildInfo)                     \
  X(clReleaseCommandQueue) X(clReleaseContext) X(clReleaseEvent) X(clReleaseKernel) X(clReleaseMemObject)          \
  X(clReleaseProgram) X(clSetKernelArg) X(clWaitForEvents)
// clang-format on

namespace evenstep::internal {

struct ClLibrary {
#define EVENSTEP_DECLARE(name) decltype(&::name) name = nullptr;
  EVENSTEP_CL_FUNCTIONS(EVENSTEP_DECLARE)
#undef EVENSTEP_DECLARE
};

/// Throws SolverError with the remedy if libOpenCL is not installed.
const ClLibrary& cl();

}  // namespace evenstep::internal
