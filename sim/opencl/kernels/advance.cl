// One substep of symplectic Euler for every cell. Fixed and ghost cells stay where they are; grabbed ones go with their
// tool, whose displacement and velocity at the end of the substep are u0, v0 and u1, v1: `mobile` is 2 for those of tool 0
// and 3 for those of tool 1, whatever the forces on them come to. So a grab needs no launch of its own. The choice is made
// among numbers that are there already: a condition around them can keep the loop over work-items from vectorising
// (measured: seven times slower).
#ifdef GRAB0
#define WITH_TOOL_0 (mobile[i] == 2.0f)
#else
#define WITH_TOOL_0 0
#endif
#ifdef GRAB1
#define WITH_TOOL_1 (mobile[i] == 3.0f)
#else
#define WITH_TOOL_1 0
#endif
#if defined(GRAB0) || defined(GRAB1)
#define HOLDING_TOOLS , float4 u0, float4 v0, float4 u1, float4 v1
#define HELD_OR(FREE, TOOL0, TOOL1) select(select(FREE, TOOL0, with0), TOOL1, with1)
#else
#define HOLDING_TOOLS
#define HELD_OR(FREE, TOOL0, TOOL1) FREE
#endif
#ifdef AXIAL_DAMPING
#define VELOCITIES READ(v), WRITE(new_v)  // separate arrays, because a neighbour still reads the old velocity
#else
#define VELOCITIES WRITE(v)
#define new_vx vx
#define new_vy vy
#define new_vz vz
#endif
#if defined(DAMPING) && defined(REGIONS)
#define DECAYED * (DECAY + (1.0f - DECAY) * (mobile[i] - inverse_mass[i]))  // the same drag for a particle of another mass
#elif defined(DAMPING)
#define DECAYED * DECAY
#else
#define DECAYED
#endif
// step g of a component: -0 where g is 0, which does not change a bit of any sum.
#ifdef GRAVITY
#ifdef VARIABLE_STEP
#define FALL(COMPONENT) + STEP_GRAVITY.COMPONENT * mobile[i]
#else
#define FALL(COMPONENT) + STEP_GRAVITY_##COMPONENT * mobile[i]
#endif
#else
#define FALL(COMPONENT)
#endif
__kernel void advance(READ(u), WRITE(next_), VELOCITIES, __global const float* restrict active,
                      __global const float* restrict mobile MATERIALS TOOLS HOLDING_TOOLS STEP_ARGUMENTS) {
  const size_t i = get_global_id(0) + FIRST;
  ALL_FORCES
  // For all others mobile is 1 or 0. It is a factor, because a product cannot become a branch.
  const float acceleration = ACCELERATION * inverse_mass[i], h = STEP * mobile[i];
  const float wx = (vx[i] DECAYED + fx * acceleration) FALL(x);
  const float wy = (vy[i] DECAYED + fy * acceleration) FALL(y);
  const float wz = (vz[i] DECAYED + fz * acceleration) FALL(z);
  const int with0 = WITH_TOOL_0, with1 = WITH_TOOL_1;
  new_vx[i] = HELD_OR(wx, v0.x, v1.x);
  new_vy[i] = HELD_OR(wy, v0.y, v1.y);
  new_vz[i] = HELD_OR(wz, v0.z, v1.z);
  next_x[i] = HELD_OR(xi + wx * h, u0.x, u1.x);
  next_y[i] = HELD_OR(yi + wy * h, u0.y, u1.y);
  next_z[i] = HELD_OR(zi + wz * h, u0.z, u1.z);
}
