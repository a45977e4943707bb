// Implicit Euler, with the same operations as cpu/methods/implicit.cpp. x is the velocity to be found, z = u + h x, r the
// residual, p the direction, q = A p. One product per cell is summed over chunks by sums.cl, and over
// the chunks by the host.
#ifdef REGIONS
#define OWN_K(I) stiffness[I]
#else
#define OWN_K(I) active[I]
#endif

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
__kernel void begin_solve(READ(u), READ(v), __global const float* restrict mobile, WRITE(x), WRITE(z), float h) {
  const size_t i = get_global_id(0) + FIRST;
  const bool free = mobile[i] > 0.0f;
  const float x = free ? 0.0f : vx[i], y = free ? 0.0f : vy[i], z = free ? 0.0f : vz[i];
  xx[i] = x;
  xy[i] = y;
  xz[i] = z;
  zx[i] = ux[i] + h * x;
  zy[i] = uy[i] + h * y;
  zz[i] = uz[i] + h * z;
}

// r = M (h a - (x - v0)), p = r / D. The macros of the forces use the names u and v for z and x.
__kernel void residual(READ(u), READ(v), __global const float* restrict active, __global const float* restrict mobile
                       MATERIALS TOOLS, READ(old_), __global const float* restrict mass,
                       __global const float* restrict scale, WRITE(r), WRITE(p),
                       __global float* restrict products, float h) {
  const size_t index = get_global_id(0);
  const size_t i = index + FIRST;
  ALL_FORCES
  const float per_kg = STIFFNESS_PER_KG * inverse_mass[i], moves = mobile[i], drag = DRAG_PER_S * inverse_mass[i];
  const float ax = fx * per_kg + (moves * FALL_x - drag * vx[i]);
  const float ay = fy * per_kg + (moves * FALL_y - drag * vy[i]);
  const float az = fz * per_kg + (moves * FALL_z - drag * vz[i]);
  const float qx = mass[i] * (h * ax - (vx[i] - old_x[i]));
  const float qy = mass[i] * (h * ay - (vy[i] - old_y[i]));
  const float qz = mass[i] * (h * az - (vz[i] - old_z[i]));
  const float sx = scale[index] * qx, sy = scale[index] * qy, sz = scale[index] * qz;
  rx[i] = qx;
  ry[i] = qy;
  rz[i] = qz;
  px[i] = sx;
  py[i] = sy;
  pz[i] = sz;
  products[index] = qx * sx + qy * sy + qz * sz;
}

// A spring's k (n n' + max(0, 1 - L/|d|) (I - n n')) times the difference of p between its ends.
#ifdef GENERAL_SYSTEM
#define OF_MATERIAL(OFFSET)                                                  \
  const float k = (OWN_K(i) + OWN_K(i + (OFFSET))) * 0.5f;                   \
  across *= k;                                                               \
  along = k * along + system.z;
#else
#define OF_MATERIAL(OFFSET)
#endif
#define ADD_APPLIED(OFFSET, RX, RY, RZ, L, C)                                                     \
  {                                                                                               \
    const float dx = (ux[i + (OFFSET)] - xi) + (RX);                                              \
    const float dy = (uy[i + (OFFSET)] - yi) + (RY);                                              \
    const float dz = (uz[i + (OFFSET)] - zi) + (RZ);                                              \
    const float wx = pxi - px[i + (OFFSET)], wy = pyi - py[i + (OFFSET)], wz = pzi - pz[i + (OFFSET)]; \
    const float inverse = 1.0f / sqrt(dx * dx + dy * dy + dz * dz + FLT_MIN);                     \
    const float stretched = 1.0f - (L) * inverse;                                                 \
    float across = INSIDE(stretched), along = 1.0f - across;                                      \
    OF_MATERIAL(OFFSET)                                                                           \
    along *= (dx * wx + dy * wy + dz * wz) * inverse * inverse;                                   \
    sx += active[i + (OFFSET)] * (across * wx + along * dx);                                      \
    sy += active[i + (OFFSET)] * (across * wy + along * dy);                                      \
    sz += active[i + (OFFSET)] * (across * wz + along * dz);                                      \
  }
#define APPLY_COUPLING(TOOL, K, B, HALF_K)                 \
  {                                                        \
    const float held = held##TOOL[i] * ((K) + drag.s##TOOL); \
    sx += held * pxi;                                      \
    sy += held * pyi;                                      \
    sz += held * pzi;                                      \
  }
#define APPLY_PROBE(TOOL, K, HALF_K, RADIUS, CX, CY, CZ)                               \
  {                                                                                    \
    FROM_PROBE(t##TOOL, CX, CY, CZ)                                                    \
    const float inverse = 1.0f / distance;                                             \
    const float stiff = (RADIUS) - distance > 0.0f ? (K) : 0.0f;                       \
    const float along = (stiff * inverse * inverse) * (dx * pxi + dy * pyi + dz * pzi); \
    sx += along * dx;                                                                  \
    sy += along * dy;                                                                  \
    sz += along * dz;                                                                  \
  }
#ifdef COUPLINGS
#define APPLY_COUPLINGS COUPLINGS(APPLY_COUPLING)
#else
#define APPLY_COUPLINGS
#endif
#ifdef PROBED
#define APPLY_PROBES PROBES(APPLY_PROBE)
#else
#define APPLY_PROBES
#endif

// q = A p and p . q; system = inertia, stiffness, axial; drag = a coupling's b / h over the scene's stiffness.
__kernel void apply_system(READ(u), __global const float* restrict active, __global const float* restrict mobile STIFFNESSES
                           TOOLS, READ(p), __global const float* restrict mass, WRITE(q), __global float* restrict products,
                           float4 system, float4 drag) {
  const size_t index = get_global_id(0);
  const size_t i = index + FIRST;
  const float xi = ux[i], yi = uy[i], zi = uz[i];
  const float pxi = px[i], pyi = py[i], pzi = pz[i];
  float sx = 0.0f, sy = 0.0f, sz = 0.0f;
  SPRINGS(ADD_APPLIED)
  APPLY_COUPLINGS
  APPLY_PROBES
  // The drag is that of the scene's mass, which is 1 here, on every particle.
  const float inertia = system.x * mass[i] + (system.x - 1.0f) * (mobile[i] - mass[i]), stiff = system.y * mobile[i];
  const float ax = inertia * pxi + stiff * sx;
  const float ay = inertia * pyi + stiff * sy;
  const float az = inertia * pzi + stiff * sz;
  qx[i] = ax;
  qy[i] = ay;
  qz[i] = az;
  products[index] = pxi * ax + pyi * ay + pzi * az;
}

// x <- x + alpha p, r <- r - alpha q, and r . r / D.
__kernel void advance_solution(READ(p), READ(q), __global const float* restrict scale, WRITE(x), WRITE(r),
                               __global float* restrict products, float alpha) {
  const size_t index = get_global_id(0);
  const size_t i = index + FIRST;
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
__kernel void advance_direction(READ(r), __global const float* restrict scale, WRITE(p), float beta) {
  const size_t index = get_global_id(0);
  const size_t i = index + FIRST;
  px[i] = scale[index] * rx[i] + beta * px[i];
  py[i] = scale[index] * ry[i] + beta * py[i];
  pz[i] = scale[index] * rz[i] + beta * pz[i];
}

// u <- u + h x, v <- x.
__kernel void finish_solve(READ(x), WRITE(u), WRITE(v), float h) {
  const size_t i = get_global_id(0) + FIRST;
  const float x = xx[i], y = xy[i], z = xz[i];
  ux[i] += h * x;
  uy[i] += h * y;
  uz[i] += h * z;
  vx[i] = x + 0.0f * (x - vx[i]);  // as implicit midpoint does it, with 1
  vy[i] = y + 0.0f * (y - vy[i]);
  vz[i] = z + 0.0f * (z - vz[i]);
}
