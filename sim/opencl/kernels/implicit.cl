// Implicit Euler by the method of conjugate gradients, with the same operations as cpu/methods/implicit.cpp. Here is what
// does not depend on the scene. implicit_system.cl has the rest, and says what the names mean. `first` is the index of the
// first cell.

// During the whole substep a grabbed particle has one velocity: the one that takes it from where it is to its tool.
__kernel void aim_grabs(__global const uint* restrict cells, uint count, uint split, READ(u), WRITE(v), float h, float4 t0,
                        float4 w0, float4 t1, float4 w1) {
  const uint n = get_global_id(0);
  if (n >= count) return;
  const uint i = cells[n];
  const float4 t = n < split ? t0 : t1;
  vx[i] = (t.x - ux[i]) / h;
  vy[i] = (t.y - uy[i]) / h;
  vz[i] = (t.z - uz[i]) / h;
}

// Sets the part of x that is known beforehand: the velocity of particles that do not move by their forces.
__kernel void begin_solve(READ(u), READ(v), __global const float* restrict mobile, WRITE(x), WRITE(z), ulong first,
                          float h) {
  const size_t i = get_global_id(0) + first;
  const bool free = mobile[i] > 0.0f;
  const float x = free ? 0.0f : vx[i], y = free ? 0.0f : vy[i], z = free ? 0.0f : vz[i];
  xx[i] = x;
  xy[i] = y;
  xz[i] = z;
  zx[i] = ux[i] + h * x;
  zy[i] = uy[i] + h * y;
  zz[i] = uz[i] + h * z;
}

// x <- x + alpha p, r <- r - alpha q, and r . r / D.
__kernel void advance_solution(READ(p), READ(q), __global const float* restrict scale, WRITE(x), WRITE(r),
                               __global float* restrict products, ulong first, float alpha) {
  const size_t index = get_global_id(0);
  const size_t i = index + first;
  const float ax = rx[i] - alpha * qx[i], ay = ry[i] - alpha * qy[i], az = rz[i] - alpha * qz[i];
  xx[i] += alpha * px[i];
  xy[i] += alpha * py[i];
  xz[i] += alpha * pz[i];
  rx[i] = ax;
  ry[i] = ay;
  rz[i] = az;
  products[index] = scale[index] * (ax * ax + ay * ay + az * az);
}

// p <- r / D + beta p.
__kernel void advance_direction(READ(r), __global const float* restrict scale, WRITE(p), ulong first, float beta) {
  const size_t index = get_global_id(0);
  const size_t i = index + first;
  px[i] = scale[index] * rx[i] + beta * px[i];
  py[i] = scale[index] * ry[i] + beta * py[i];
  pz[i] = scale[index] * rz[i] + beta * pz[i];
}

// u <- u + h x, v <- x.
__kernel void finish_solve(READ(x), WRITE(u), WRITE(v), ulong first, float h) {
  const size_t i = get_global_id(0) + first;
  const float x = xx[i], y = xy[i], z = xz[i];
  ux[i] += h * x;
  uy[i] += h * y;
  uz[i] += h * z;
  vx[i] = x + 0.0f * (x - vx[i]);  // implicit midpoint has 1 in the place of 0
  vy[i] = y + 0.0f * (y - vy[i]);
  vz[i] = z + 0.0f * (z - vz[i]);
}
