// One substep of symplectic Euler for every cell. Fixed, grabbed and ghost cells stay where they are.
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
                      __global const float* restrict mobile MATERIALS TOOLS STEP_ARGUMENTS) {
  const size_t i = get_global_id(0) + FIRST;
  ALL_FORCES
  // mobile is 1 or 0. It is a factor, because a product cannot become a branch.
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
}
