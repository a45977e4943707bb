// Mechanical energy per cell: the kinetic energy of a mobile particle, half the energy of each of its springs, and the
// energy of a coupling or a probe on it; sums.cl adds them up. The potential of gravity, which has a sign, is kept apart.
#define ADD_STRETCH(OFFSET, RX, RY, RZ, L, C)                                     \
  {                                                                               \
    const float dx = (ux[i + (OFFSET)] - xi) + (RX);                              \
    const float dy = (uy[i + (OFFSET)] - yi) + (RY);                              \
    const float dz = (uz[i + (OFFSET)] - zi) + (RZ);                              \
    const float stretch = sqrt(dx * dx + dy * dy + dz * dz) - (L);                \
    springs += active[i + (OFFSET)] * (MEAN(OFFSET)(stretch * stretch));          \
  }
#define ADD_COUPLING_ENERGY(TOOL, K, B, HALF_K)                                   \
  {                                                                               \
    const float dx = t##TOOL.x - xi, dy = t##TOOL.y - yi, dz = t##TOOL.z - zi;    \
    energy += (HALF_K) * held##TOOL[i] * (dx * dx + dy * dy + dz * dz);           \
  }
#define ADD_PROBE_ENERGY(TOOL, K, HALF_K, RADIUS, CX, CY, CZ)                     \
  {                                                                               \
    FROM_PROBE(t##TOOL, CX, CY, CZ)                                               \
    const float depth = (RADIUS) - distance;                                      \
    const float inside = INSIDE(depth);                             \
    energy += (HALF_K) * mobile[i] * (inside * inside);                           \
  }
#ifdef REGIONS
#define MASSES , __global const float* restrict mass
#else
#define MASSES
#define mass mobile
#endif
#ifdef GRAVITY
#define GRAVITY_ENERGIES , __global float* restrict gravity_energies
#else
#define GRAVITY_ENERGIES
#endif

__kernel void cell_energy(READ(u), READ(v), __global const float* restrict active,
                          __global const float* restrict mobile STIFFNESSES MASSES TOOLS,
                          __global float* restrict energies GRAVITY_ENERGIES) {
  const size_t index = get_global_id(0);
  const size_t i = index + FIRST;
  const float xi = ux[i], yi = uy[i], zi = uz[i];
  OWN_STIFFNESS
  float springs = 0.0f;
  SPRINGS(ADD_STRETCH)
  const float speed2 = vx[i] * vx[i] + vy[i] * vy[i] + vz[i] * vz[i];
  float energy = HALF_MASS * mass[i] * speed2 + QUARTER_STIFFNESS * active[i] * springs;
#ifdef COUPLINGS
  COUPLINGS(ADD_COUPLING_ENERGY)
#endif
#ifdef PROBED
  PROBES(ADD_PROBE_ENERGY)
#endif
  energies[index] = energy;
#ifdef GRAVITY
  gravity_energies[index] = -(mass[i] * (WEIGHT_x * xi + WEIGHT_y * yi + WEIGHT_z * zi));
#endif
}
