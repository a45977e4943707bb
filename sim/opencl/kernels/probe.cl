// Partial sums over the particles that a probe touches, each over CHUNK cells one `partials` apart, so that neighbouring
// work-items read neighbouring cells: values[first + value * partials + partial].
__kernel void probe_sums(READ(u), READ(rest_), __global const float* restrict mobile, float stiffness, float radius,
                         float4 c, uint first, __global float* restrict values, float4 t) {
  const size_t part = get_global_id(0), partials = get_global_size(0);
  float fx = 0.0f, fy = 0.0f, fz = 0.0f;
#ifdef LOCAL_MODEL
  float depths = 0.0f, px = 0.0f, py = 0.0f, pz = 0.0f, least = FLT_MAX;
  float kxx = 0.0f, kyy = 0.0f, kzz = 0.0f, kxy = 0.0f, kxz = 0.0f, kyz = 0.0f;
#endif
  for (size_t chunk = 0; chunk < CHUNK; ++chunk) {
    const size_t i = chunk * partials + part + FIRST;
    const float xi = ux[i], yi = uy[i], zi = uz[i];
    FROM_PROBE(t, c.x, c.y, c.z)
    const float depth = radius - distance;
    const float inside = depth > 0.0f ? depth : 0.0f;
    const float factor = mobile[i] * (stiffness * inside / distance);
    fx += factor * dx;
    fy += factor * dy;
    fz += factor * dz;
#ifdef LOCAL_MODEL
    const float weight = mobile[i] * inside;
    depths += weight;
    px += weight * (rest_x[i] + xi);
    py += weight * (rest_y[i] + yi);
    pz += weight * (rest_z[i] + zi);
    // k (n n' + (1 - r/|d|) (I - n n')); nothing at the very centre, which has no direction.
    const float k = depth > 0.0f && square > 0.0f ? mobile[i] * stiffness : 0.0f;
    const float ratio = radius / distance, across = k * (1.0f - ratio);
    const float nx = dx / distance, ny = dy / distance, nz = dz / distance, along = k * ratio;
    kxx += along * (nx * nx) + across;
    kyy += along * (ny * ny) + across;
    kzz += along * (nz * nz) + across;
    kxy += along * (nx * ny);
    kxz += along * (nx * nz);
    kyz += along * (ny * nz);
    const float gap = mobile[i] > 0.0f ? distance - radius : FLT_MAX;
    least = gap < least ? gap : least;
#endif
  }
  __global float* const sums = values + first + part;
  sums[0] = fx;
  sums[partials] = fy;
  sums[2 * partials] = fz;
#ifdef LOCAL_MODEL
  const float more[] = {depths, px, py, pz, kxx, kyy, kzz, kxy, kxz, kyz, least};
  for (int n = 0; n < 11; ++n) sums[(3 + n) * partials] = more[n];
#endif
}
