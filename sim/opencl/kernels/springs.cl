// Shared by all kernels. The host defines, as exact hexadecimal constants:
//   SPRINGS(S)      S(offset, rx, ry, rz, L) for the 18 neighbours, in the order of summation
//   STIFFNESS, HALF_MASS, QUARTER_STIFFNESS, FIRST, CHUNK
//   STEP, ACCELERATION, DECAY of a constant step, or else VARIABLE_STEP
// One spring: d = (u_j - u_i) + r, force over k: (1 - L / len) d. The smallest normal number under the root changes no
// bit of a spring longer than 1e-15 m, and gives one of no length, which has no direction, no force instead of 0/0.
// Products with 1 or 0 instead of branches, and size_t indices (an int index turns every load into a gather), so that the
// loop over work-items vectorises; no contraction, no transcendental, so that every device computes the same bits.
#pragma OPENCL FP_CONTRACT OFF

#define ADD_SPRING(OFFSET, RX, RY, RZ, L)                                        \
  {                                                                              \
    const float dx = (ux[i + (OFFSET)] - xi) + (RX);                             \
    const float dy = (uy[i + (OFFSET)] - yi) + (RY);                             \
    const float dz = (uz[i + (OFFSET)] - zi) + (RZ);                             \
    const float length = sqrt(dx * dx + dy * dy + dz * dz + FLT_MIN);            \
    const float factor = active[i + (OFFSET)] * (1.0f - (L) / length);           \
    fx += factor * dx;                                                           \
    fy += factor * dy;                                                           \
    fz += factor * dz;                                                           \
  }
