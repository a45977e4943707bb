// Mechanical energy: kinetic of the mobile particles and half of each spring's per cell, then sums over fixed chunks.
#define ADD_STRETCH(OFFSET, RX, RY, RZ, L)                                        \
  {                                                                               \
    const float dx = (ux[i + (OFFSET)] - xi) + (RX);                              \
    const float dy = (uy[i + (OFFSET)] - yi) + (RY);                              \
    const float dz = (uz[i + (OFFSET)] - zi) + (RZ);                              \
    const float stretch = sqrt(dx * dx + dy * dy + dz * dz) - (L);                \
    springs += active[i + (OFFSET)] * (stretch * stretch);                        \
  }

__kernel void cell_energy(__global const float* restrict ux, __global const float* restrict uy,
                          __global const float* restrict uz,
                          __global const float* restrict vx, __global const float* restrict vy,
                          __global const float* restrict vz,
                          __global const float* restrict active, __global const float* restrict mobile,
                          __global float* restrict energies) {
  const size_t index = get_global_id(0);
  const size_t i = index + FIRST;
  const float xi = ux[i], yi = uy[i], zi = uz[i];
  float springs = 0.0f;
  SPRINGS(ADD_STRETCH)
  const float speed2 = vx[i] * vx[i] + vy[i] * vy[i] + vz[i] * vz[i];
  energies[index] = HALF_MASS * mobile[i] * speed2 + QUARTER_STIFFNESS * active[i] * springs;
}

__kernel void chunk_energy(__global const float* restrict energies, __global float* restrict sums) {
  const size_t chunk = get_global_id(0);
  float sum = 0.0f;
  for (int n = 0; n < CHUNK; ++n) sum += energies[chunk * CHUNK + n];
  sums[chunk] = sum;
}
