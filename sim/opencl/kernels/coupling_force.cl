// What the hand feels from each particle that a spring coupling holds: minus its force on the particle, newtons.
__kernel void coupling_force(__global const uint* restrict cells, uint count, READ(u), READ(v) TOOLS, uint first,
                             __global float* restrict forces) {
  const uint n = get_global_id(0);
  if (n >= count) return;
  const size_t i = cells[n];
  const float xi = ux[i], yi = uy[i], zi = uz[i];
  float fx = 0.0f, fy = 0.0f, fz = 0.0f;
  COUPLING_FORCES
  forces[first + 3 * n] = -(fx * STIFFNESS);
  forces[first + 3 * n + 1] = -(fy * STIFFNESS);
  forces[first + 3 * n + 2] = -(fz * STIFFNESS);
}
