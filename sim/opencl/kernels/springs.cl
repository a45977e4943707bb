// Shared by all kernels of the scene. The host defines, as exact hexadecimal constants:
//   SPRINGS(S)      S(offset, rx, ry, rz, L, c / (k L^2)) for the 18 neighbours, in the order of summation
//   STIFFNESS, STIFFNESS_PER_KG, HALF_MASS, QUARTER_STIFFNESS, FIRST
//   STEP, HALF_STEP, ACCELERATION of a constant step, or else VARIABLE_STEP
// and, for the features that the scene has:
//   REGIONS, AXIAL_DAMPING, DAMPING (its factor DECAY or its DAMPING_PER_S), GRAVITY(G)
//   HELD0, HELD1    the tool is a spring coupling; COUPLINGS(C) C(tool, k, b, k / 2 in N/m) for those
//   PROBED          a tool is a probe; PROBES(P) P(tool, k, k / 2 in N/m, radius, cx, cy, cz) for those
// One spring: d = (u_j - u_i) + r, and its force divided by k is (1 - L / len) d. The smallest normal number is added under
// the root: it does not change a bit for a spring longer than 1e-15 m, and gives a spring of length 0, which has no
// direction, no force instead of 0/0.

#ifdef REGIONS
#define STIFFNESSES , __global const float* restrict stiffness
#define MATERIALS STIFFNESSES, __global const float* restrict inverse_mass
#define OWN_STIFFNESS const float ki = stiffness[i];
#define MEAN(OFFSET) ((ki + stiffness[i + (OFFSET)]) * 0.5f) *
#else
#define STIFFNESSES
#define MATERIALS
#define inverse_mass mobile
#define OWN_STIFFNESS
#define MEAN(OFFSET)
#endif

#ifdef AXIAL_DAMPING
#define NEIGHBOUR_VELOCITIES , READ(v)
#define OWN_VELOCITY const float vxi = vx[i], vyi = vy[i], vzi = vz[i];
#define AXIAL(OFFSET, C)                                                                                       \
  +(C) * (((vx[i + (OFFSET)] - vxi) * dx + (vy[i + (OFFSET)] - vyi) * dy + (vz[i + (OFFSET)] - vzi) * dz) * part) * part
#else
#define NEIGHBOUR_VELOCITIES
#define OWN_VELOCITY
#define AXIAL(OFFSET, C)
#endif

#define ADD_SPRING(OFFSET, RX, RY, RZ, L, C)                                     \
  {                                                                              \
    const float dx = (ux[i + (OFFSET)] - xi) + (RX);                             \
    const float dy = (uy[i + (OFFSET)] - yi) + (RY);                             \
    const float dz = (uz[i + (OFFSET)] - zi) + (RZ);                             \
    const float part = (L) / sqrt(dx * dx + dy * dy + dz * dz + FLT_MIN);        \
    const float factor = active[i + (OFFSET)] * (MEAN(OFFSET)(1.0f - part) AXIAL(OFFSET, C)); \
    fx += factor * dx;                                                           \
    fy += factor * dy;                                                           \
    fz += factor * dz;                                                           \
  }

// Declares fx, fy, fz: the force of the springs on cell i.
#define SPRING_FORCE                                  \
  const float xi = ux[i], yi = uy[i], zi = uz[i];     \
  OWN_STIFFNESS OWN_VELOCITY                          \
  float fx = 0.0f, fy = 0.0f, fz = 0.0f;              \
  SPRINGS(ADD_SPRING)

// The force of the tools on it, divided by k, from their displacement t and velocity w.
#ifdef HELD0
#define HELD0_ARGUMENT , __global const float* restrict held0
#else
#define HELD0_ARGUMENT
#endif
#ifdef HELD1
#define HELD1_ARGUMENT , __global const float* restrict held1
#else
#define HELD1_ARGUMENT
#endif
#ifdef COUPLINGS
#define ADD_COUPLING(TOOL, K, B, HALF_K)                                                        \
  fx += held##TOOL[i] * ((K) * (t##TOOL.x - xi) + (B) * (w##TOOL.x - vx[i]));                   \
  fy += held##TOOL[i] * ((K) * (t##TOOL.y - yi) + (B) * (w##TOOL.y - vy[i]));                   \
  fz += held##TOOL[i] * ((K) * (t##TOOL.z - zi) + (B) * (w##TOOL.z - vz[i]));
#define COUPLING_FORCES COUPLINGS(ADD_COUPLING)
#else
#define COUPLING_FORCES
#endif

#ifdef PROBED
#define REST_ARGUMENTS , READ(rest_)
#define ADD_PROBE(TOOL, K, HALF_K, RADIUS, CX, CY, CZ)                                          \
  {                                                                                             \
    FROM_PROBE(t##TOOL, CX, CY, CZ)                                                             \
    const float depth = (RADIUS) - distance;                                                    \
    const float factor = (K) * INSIDE(depth) / distance;                        \
    fx += factor * dx;                                                                          \
    fy += factor * dy;                                                                          \
    fz += factor * dz;                                                                          \
  }
#define PROBE_FORCES PROBES(ADD_PROBE)
#else
#define REST_ARGUMENTS
#define PROBE_FORCES
#endif
#if defined(COUPLINGS) || defined(PROBED)
#define TOOLS HELD0_ARGUMENT HELD1_ARGUMENT REST_ARGUMENTS, float4 t0, float4 w0, float4 t1, float4 w1
#else
#define TOOLS
#endif

#define ALL_FORCES SPRING_FORCE COUPLING_FORCES PROBE_FORCES

// If the step varies, everything that depends on it is an argument with the name of the constant that it replaces.
#ifdef VARIABLE_STEP
#define STEP_ARGUMENTS , float STEP, float HALF_STEP, float ACCELERATION, float DECAY, float4 STEP_GRAVITY
#else
#define STEP_ARGUMENTS
#endif
