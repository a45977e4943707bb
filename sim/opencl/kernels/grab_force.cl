// The force of the springs on each grabbed particle, newtons. The host adds them up in fixed order to what the hand feels.
#define GRAB_FORCE(N)                             \
  {                                               \
    const size_t i = cells[N];                    \
    SPRING_FORCE                                  \
    forces[first + 3 * (N)] = fx * STIFFNESS;     \
    forces[first + 3 * (N) + 1] = fy * STIFFNESS; \
    forces[first + 3 * (N) + 2] = fz * STIFFNESS; \
  }
__kernel void grab_force(__global const uint* restrict cells, uint count, READ(u) NEIGHBOUR_VELOCITIES,
                         __global const float* restrict active STIFFNESSES, uint first, __global float* restrict forces) {
  const uint n = get_global_id(0);
  if (n < count) GRAB_FORCE(n)
}
// Both in one launch of a single work-group. A grabbed particle may be the neighbour of another: all are put first.
__kernel void grab_and_force(GRABS, WRITE(u), WRITE(v), __global const float* restrict active STIFFNESSES, uint first,
                             __global float* restrict forces) {
  const uint n = get_local_id(0);
  if (n < count) PUT_GRABBED(n)
  barrier(CLK_GLOBAL_MEM_FENCE);
  if (n < count) GRAB_FORCE(n)
}
