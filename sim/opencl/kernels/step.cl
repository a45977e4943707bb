// One substep of symplectic Euler for every cell; fixed, grabbed and ghost cells keep what they have.
__kernel void step(__global const float* restrict ux, __global const float* restrict uy, __global const float* restrict uz,
                   __global float* restrict next_x, __global float* restrict next_y, __global float* restrict next_z,
                   __global float* restrict vx, __global float* restrict vy, __global float* restrict vz,
                   __global const float* restrict active, __global const float* restrict mobile) {
  const int i = get_global_id(0) + FIRST;
  const float xi = ux[i], yi = uy[i], zi = uz[i];
  float fx = 0.0f, fy = 0.0f, fz = 0.0f;
  SPRINGS(ADD_SPRING)
  const float m = mobile[i];
  const float wx = m > 0.0f ? vx[i] * DECAY + fx * ACCELERATION : vx[i];
  const float wy = m > 0.0f ? vy[i] * DECAY + fy * ACCELERATION : vy[i];
  const float wz = m > 0.0f ? vz[i] * DECAY + fz * ACCELERATION : vz[i];
  vx[i] = wx;
  vy[i] = wy;
  vz[i] = wz;
  next_x[i] = m > 0.0f ? xi + wx * STEP : xi;
  next_y[i] = m > 0.0f ? yi + wy * STEP : yi;
  next_z[i] = m > 0.0f ? zi + wz * STEP : zi;
}
