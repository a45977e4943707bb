// The force of the springs on each grabbed particle, newtons. The host adds them up in fixed order to what the hand feels.
__kernel void grab_force(__global const uint* restrict cells, uint count, READ(u) NEIGHBOUR_VELOCITIES,
                         __global const float* restrict active STIFFNESSES, uint first, __global float* restrict forces) {
  const uint n = get_global_id(0);
  if (n >= count) return;
  const size_t i = cells[n];
  SPRING_FORCE
  forces[first + 3 * n] = fx * STIFFNESS;
  forces[first + 3 * n + 1] = fy * STIFFNESS;
  forces[first + 3 * n + 2] = fz * STIFFNESS;
}
