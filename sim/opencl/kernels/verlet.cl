// One substep of velocity Verlet in two passes. Here v is the half step's velocity, with which all forces are evaluated.
__kernel void drift(READ(begin_v), READ(a), WRITE(v), WRITE(u), __global const float* restrict mobile STEP_ARGUMENTS) {
  const size_t i = get_global_id(0) + FIRST;
  const float wx = begin_vx[i] + ax[i] * HALF_STEP;
  const float wy = begin_vy[i] + ay[i] * HALF_STEP;
  const float wz = begin_vz[i] + az[i] * HALF_STEP;
  const float h = STEP * mobile[i];
  vx[i] = wx;
  vy[i] = wy;
  vz[i] = wz;
  ux[i] += wx * h;
  uy[i] += wy * h;
  uz[i] += wz * h;
}

#ifdef DAMPING
#define DAMPED(COMPONENT) - v##COMPONENT[i] * damping
#else
#define DAMPED(COMPONENT)
#endif
#ifdef GRAVITY
#define FALLING(COMPONENT) + GRAVITY_##COMPONENT * mobile[i]
#else
#define FALLING(COMPONENT)
#endif
__kernel void accelerate(READ(u), READ(v), WRITE(end_v), WRITE(a), __global const float* restrict active,
                         __global const float* restrict mobile MATERIALS TOOLS STEP_ARGUMENTS) {
  const size_t i = get_global_id(0) + FIRST;
  ALL_FORCES
  const float per_kg = STIFFNESS_PER_KG * inverse_mass[i];
#ifdef DAMPING
  const float damping = DAMPING_PER_S * inverse_mass[i];
#endif
  const float bx = (fx * per_kg DAMPED(x)) FALLING(x);
  const float by = (fy * per_kg DAMPED(y)) FALLING(y);
  const float bz = (fz * per_kg DAMPED(z)) FALLING(z);
  ax[i] = bx;
  ay[i] = by;
  az[i] = bz;
  end_vx[i] = vx[i] + bx * HALF_STEP;
  end_vy[i] = vy[i] + by * HALF_STEP;
  end_vz[i] = vz[i] + bz * HALF_STEP;
}
