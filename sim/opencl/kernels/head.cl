// Comes before all other kernels, in both programs that the host builds: the one of the scene, which is compiled with the
// scene's constants (springs.cl), and the one that is the same for every scene (sums.cl), so that a driver with a cache
// compiles it only once.
// Products with 1 or 0 stand in the place of branches, and indices are size_t (an int index turns every load into a gather),
// so that the loop over work-items vectorises. There is no contraction and no transcendental function, so that every device
// computes the same bits.
#pragma OPENCL FP_CONTRACT OFF

#define READ(V) __global const float* restrict V##x, __global const float* restrict V##y, __global const float* restrict V##z
#define WRITE(V) __global float* restrict V##x, __global float* restrict V##y, __global float* restrict V##z

// The vector from a probe's centre to cell i, and its length.
#define FROM_PROBE(T, CX, CY, CZ)                                                               \
  const float dx = (xi - T.x) + (rest_x[i] - (CX));                                             \
  const float dy = (yi - T.y) + (rest_y[i] - (CY));                                             \
  const float dz = (zi - T.z) + (rest_z[i] - (CZ));                                             \
  const float square = dx * dx + dy * dy + dz * dz, distance = sqrt(square + FLT_MIN);
// The depth, or 0 outside. A conditional expression would become a branch around the division (measured: seven times
// slower).
#define INSIDE(DEPTH) (((DEPTH) + fabs(DEPTH)) * 0.5f)
