// What the tool feels through a probe. It takes two kernels, because only a loop over work-items is vectorised: the first
// writes what every cell contributes to cells[value * span + index]; the second adds up partial sums over CHUNK cells that
// are `partials` apart, sums[first + value * partials + partial], in the same order as the plain loop.
#define PROBE READ(u), READ(rest_), __global const float* restrict mobile, ulong first, float stiffness, float radius, \
              float4 c, __global float* restrict cells, float4 t
#define FORCE_OF_PROBE                                                       \
  const size_t index = get_global_id(0), span = get_global_size(0);          \
  const size_t i = index + first;                                            \
  const float xi = ux[i], yi = uy[i], zi = uz[i];                            \
  FROM_PROBE(t, c.x, c.y, c.z)                                               \
  const float depth = radius - distance;                                     \
  const float inside = INSIDE(depth);                                        \
  const float factor = mobile[i] * (stiffness * inside / distance);          \
  cells[index] = factor * dx;                                                \
  cells[span + index] = factor * dy;                                         \
  cells[2 * span + index] = factor * dz;

__kernel void probe_cells(PROBE) { FORCE_OF_PROBE }

// The same, and what the local model is made of.
__kernel void probe_model_cells(PROBE) {
  FORCE_OF_PROBE
  const float weight = mobile[i] * inside;
  cells[3 * span + index] = weight;
  cells[4 * span + index] = weight * (rest_x[i] + xi);
  cells[5 * span + index] = weight * (rest_y[i] + yi);
  cells[6 * span + index] = weight * (rest_z[i] + zi);
  // k (n n' + (1 - r/|d|) (I - n n')), and 0 at the very centre, where there is no direction.
  const float k = depth > 0.0f && square > 0.0f ? mobile[i] * stiffness : 0.0f;
  const float ratio = radius / distance, across = k * (1.0f - ratio);
  const float nx = dx / distance, ny = dy / distance, nz = dz / distance, along = k * ratio;
  cells[7 * span + index] = along * (nx * nx) + across;
  cells[8 * span + index] = along * (ny * ny) + across;
  cells[9 * span + index] = along * (nz * nz) + across;
  cells[10 * span + index] = along * (nx * ny);
  cells[11 * span + index] = along * (nx * nz);
  cells[12 * span + index] = along * (ny * nz);
  cells[13 * span + index] = mobile[i] > 0.0f ? distance - radius : FLT_MAX;
}

// One work-item per value and partial sum. The last value of the local model, the gap, is a minimum instead of a sum.
__kernel void probe_sums(__global const float* restrict cells, ulong partials, uint first, __global float* restrict values) {
  const size_t item = get_global_id(0);
  const size_t value = item / partials, part = item % partials;
  __global const float* const of_value = cells + value * partials * CHUNK + part;
  float sum = value == 13 ? FLT_MAX : 0.0f;
  for (size_t chunk = 0; chunk < CHUNK; ++chunk) {
    const float cell = of_value[chunk * partials];
    sum = value == 13 ? (cell < sum ? cell : sum) : sum + cell;
  }
  values[first + item] = sum;
}
