// Shared by all kernels. The host defines, as exact hexadecimal constants:
//   SPRINGS(S)      S(offset, rx, ry, rz, L) for the 18 neighbours, in the order of summation
//   STEP, ACCELERATION, DECAY, STIFFNESS, MASS, FIRST, CHUNK
// One spring: d = (u_j - u_i) + r, force over k: (1 - L / len) d. Selection instead of branches, so that the loop over
// work-items vectorises; no contraction, no transcendental, so that every device computes the same bits.
#pragma OPENCL FP_CONTRACT OFF

#define ADD_SPRING(OFFSET, RX, RY, RZ, L)                           \
  {                                                                 \
    const float dx = (ux[i + (OFFSET)] - xi) + (RX);                \
    const float dy = (uy[i + (OFFSET)] - yi) + (RY);                \
    const float dz = (uz[i + (OFFSET)] - zi) + (RZ);                \
    const float length = sqrt(dx * dx + dy * dy + dz * dz);         \
    float factor = 1.0f - (L) / length;                             \
    factor = active[i + (OFFSET)] > 0.0f ? factor : 0.0f;           \
    fx += factor * dx;                                              \
    fy += factor * dy;                                              \
    fz += factor * dz;                                              \
  }
