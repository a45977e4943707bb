// The host defines CHUNK.
// Digest of the particle state: an integer mix per cell, then sums over fixed chunks, so that no work-group size matters.
// All NaNs count as the same one, because the payload of a NaN depends on the device.
#define BITS(VALUE) ((ulong)(isnan(VALUE) ? 0x7fc00000u : as_uint(VALUE)))

// `first` is the index of the first cell; `digests` begins with it.
__kernel void cell_digest(READ(u), READ(v), __global ulong* restrict digests, ulong first) {
  const size_t index = get_global_id(0);
  const size_t i = index + first;
  ulong h = (ulong)index * 0x9e3779b97f4a7c15UL;
  h += BITS(ux[i]) * 0xff51afd7ed558ccdUL;
  h += BITS(uy[i]) * 0xc4ceb9fe1a85ec53UL;
  h += BITS(uz[i]) * 0xbf58476d1ce4e5b9UL;
  h += BITS(vx[i]) * 0x94d049bb133111ebUL;
  h += BITS(vy[i]) * 0xd6e8feb86659fd93UL;
  h += BITS(vz[i]) * 0xa0761d6478bd642fUL;
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

__kernel void chunk_sum(__global const float* restrict values, __global float* restrict sums) {
  const size_t chunk = get_global_id(0);
  float sum = 0.0f;
  for (int n = 0; n < CHUNK; ++n) sum += values[chunk * CHUNK + n];
  sums[chunk] = sum;
}
