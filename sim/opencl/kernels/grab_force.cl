// Spring force on each grabbed particle, newtons: what the hand feels, before the host's sum in fixed order.
__kernel void grab_force(__global const uint* restrict cells, uint count, __global const float* restrict ux,
                         __global const float* restrict uy, __global const float* restrict uz,
                         __global const float* restrict active, __global float* restrict forces) {
  const uint n = get_global_id(0);
  if (n >= count) return;
  const size_t i = cells[n];
  const float xi = ux[i], yi = uy[i], zi = uz[i];
  float fx = 0.0f, fy = 0.0f, fz = 0.0f;
  SPRINGS(ADD_SPRING)
  forces[3 * n] = fx * STIFFNESS;
  forces[3 * n + 1] = fy * STIFFNESS;
  forces[3 * n + 2] = fz * STIFFNESS;
}
