// The part of implicit Euler (implicit.cl) that depends on the scene. x is the velocity to be found, z = u + h x, r the
// residual, p the direction, q = A p. sums.cl sums one product per cell over chunks, and the host sums the chunks.
#ifdef REGIONS
#define OWN_K(I) stiffness[I]
#else
#define OWN_K(I) active[I]
#endif

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
