// Puts the grabbed particles where their tools are. Entries below `split` belong to tool 0.
__kernel void grab(__global const uint* restrict cells, uint count, uint split, float4 u0, float4 v0, float4 u1, float4 v1,
                   WRITE(u), WRITE(v)) {
  const uint n = get_global_id(0);
  if (n >= count) return;
  const uint i = cells[n];
  const float4 u = n < split ? u0 : u1;
  const float4 v = n < split ? v0 : v1;
  ux[i] = u.x;
  uy[i] = u.y;
  uz[i] = u.z;
  vx[i] = v.x;
  vy[i] = v.y;
  vz[i] = v.z;
}
