// Puts the grabbed particles where their tool is at the end of the substep. Entries below `split` belong to tool 0.
#define GRABS __global const uint* restrict cells, uint count, uint split, float4 u0, float4 v0, float4 u1, float4 v1
#define PUT_GRABBED(N)                      \
  {                                         \
    const uint i = cells[N];                \
    const float4 u = (N) < split ? u0 : u1; \
    const float4 v = (N) < split ? v0 : v1; \
    ux[i] = u.x;                            \
    uy[i] = u.y;                            \
    uz[i] = u.z;                            \
    vx[i] = v.x;                            \
    vy[i] = v.y;                            \
    vz[i] = v.z;                            \
  }
__kernel void grab(GRABS, WRITE(u), WRITE(v)) {
  const uint n = get_global_id(0);
  if (n < count) PUT_GRABBED(n)
}
