// One substep of symplectic Euler for every cell. Fixed and ghost cells stay where they are; grabbed ones go with their
// tool, whose displacement and velocity at the end of the substep are u0, v0 and u1, v1: `mobile` is 2 for those of tool 0
// and 3 for those of tool 1, whatever the forces on them come to. So a grab needs no launch of its own. Each tool has a
// condition with nothing but stores in it, which become masked stores (measured: a condition that chooses between the tools
// keeps the loop over work-items from vectorising, seven times slower).
#define HOLD(TOOL, U, V)            \
  if (mobile[i] == 2.0f + (TOOL)) { \
    new_vx[i] = V.x;                \
    new_vy[i] = V.y;                \
    new_vz[i] = V.z;                \
    next_x[i] = U.x;                \
    next_y[i] = U.y;                \
    next_z[i] = U.z;                \
  }
#ifdef GRAB0
#define HOLD0 HOLD(0, u0, v0)
#else
#define HOLD0
#endif
#ifdef GRAB1
#define HOLD1 HOLD(1, u1, v1)
#else
#define HOLD1
#endif
#if defined(GRAB0) || defined(GRAB1)
#define HOLDING_TOOLS , float4 u0, float4 v0, float4 u1, float4 v1
#else
#define HOLDING_TOOLS
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
  new_vx[i] = wx;
  new_vy[i] = wy;
  new_vz[i] = wz;
  next_x[i] = xi + wx * h;
  next_y[i] = yi + wy * h;
  next_z[i] = zi + wz * h;
  HOLD0 HOLD1
}
