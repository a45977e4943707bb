// The displacements of a few cells, for the local model on the host.
__kernel void displacements(__global const uint* restrict cells, uint count, READ(u), uint first,
                            __global float* restrict values) {
  const uint n = get_global_id(0);
  if (n >= count) return;
  values[first + 3 * n] = ux[cells[n]];
  values[first + 3 * n + 1] = uy[cells[n]];
  values[first + 3 * n + 2] = uz[cells[n]];
}
