// One substep of symplectic Euler for every cell; fixed, grabbed and ghost cells stay where they are.
// Where the step varies, what depends on it are arguments named as the constants that they stand for.
#ifdef VARIABLE_STEP
#define STEP_ARGUMENTS , float STEP, float ACCELERATION, float DECAY
#else
#define STEP_ARGUMENTS
#endif
__kernel void advance(__global const float* restrict ux, __global const float* restrict uy,
                      __global const float* restrict uz,
                      __global float* restrict next_x, __global float* restrict next_y, __global float* restrict next_z,
                      __global float* restrict vx, __global float* restrict vy, __global float* restrict vz,
                      __global const float* restrict active, __global const float* restrict mobile STEP_ARGUMENTS) {
  const size_t i = get_global_id(0) + FIRST;
  const float xi = ux[i], yi = uy[i], zi = uz[i];
  float fx = 0.0f, fy = 0.0f, fz = 0.0f;
  SPRINGS(ADD_SPRING)
  // mobile is 1 or 0: a product cannot become a branch.
  const float acceleration = ACCELERATION * mobile[i], h = STEP * mobile[i];
  const float wx = vx[i] * DECAY + fx * acceleration;
  const float wy = vy[i] * DECAY + fy * acceleration;
  const float wz = vz[i] * DECAY + fz * acceleration;
  vx[i] = wx;
  vy[i] = wy;
  vz[i] = wz;
  next_x[i] = xi + wx * h;
  next_y[i] = yi + wy * h;
  next_z[i] = zi + wz * h;
}
