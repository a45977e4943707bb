// Digest of the particle state: an integer mix per cell, then sums over fixed chunks, so that no work-group size matters.
__kernel void cell_digest(__global const uint* restrict ux, __global const uint* restrict uy, __global const uint* restrict uz,
                          __global const uint* restrict vx, __global const uint* restrict vy, __global const uint* restrict vz,
                          __global ulong* restrict digests) {
  const size_t index = get_global_id(0);
  const size_t i = index + FIRST;
  ulong h = (ulong)index * 0x9e3779b97f4a7c15UL;
  h += (ulong)ux[i] * 0xff51afd7ed558ccdUL;
  h += (ulong)uy[i] * 0xc4ceb9fe1a85ec53UL;
  h += (ulong)uz[i] * 0xbf58476d1ce4e5b9UL;
  h += (ulong)vx[i] * 0x94d049bb133111ebUL;
  h += (ulong)vy[i] * 0xd6e8feb86659fd93UL;
  h += (ulong)vz[i] * 0xa0761d6478bd642fUL;
  h ^= h >> 32;
  h *= 0xe7037ed1a0b428dbUL;
  digests[index] = h ^ (h >> 29);
}

__kernel void chunk_digest(__global const ulong* restrict digests, __global ulong* restrict sums) {
  const size_t chunk = get_global_id(0);
  ulong sum = 0;
  for (int n = 0; n < CHUNK; ++n) sum += digests[chunk * CHUNK + n];
  sums[chunk] = sum;
}
