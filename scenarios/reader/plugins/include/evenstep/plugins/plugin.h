#pragma once
/// A solver, device, map or timing source in a shared object, for a scenario that names its file:
///
///   [scene]
///   library = "libmine.so"
///
/// This header is plain C99 and needs nothing else of evenstep. The library exports one function, evenstep_plugin_v1, which
/// gives a table of functions for each part that it has:
///
///   static int step(void* solver, const double* positions_m, double step_s, double* forces_N, evenstep_error* error) {
///     for (int axis = 0; axis < 3; ++axis) forces_N[axis] = -200 * positions_m[axis];
///     return EVENSTEP_OK;
///   }
///   static const evenstep_solver_functions solver = {.struct_size = sizeof solver, .step = step};
///   static const evenstep_plugin plugin = {EVENSTEP_ABI, sizeof plugin, "my-spring", &solver};
///   EVENSTEP_EXPORT const evenstep_plugin* evenstep_plugin_v1(void) { return &plugin; }
///
/// A function may be NULL unless it is said to be required. Every function except stop and destroy returns EVENSTEP_OK or
/// the code of what went wrong; in that case it may write the reason into `error`, which belongs to evenstep and is empty
/// before each call. An exception must not leave a function; if evenstep sees one, it counts as EVENSTEP_FAILED.
///
/// Memory belongs to the side that allocated it. What evenstep passes is valid until the function returns, unless stated
/// otherwise. Strings are UTF-8 and end with 0. Positions and forces are x, y, z of one tool after the other.
///
/// create is called once per strategy, by any thread. Several of the objects that it makes are used at the same time, each
/// by one thread at a time, so they must not share anything that changes. The library is given the time and the seed, and
/// must take neither from elsewhere: the same inputs must give the same answers, bit for bit; `--repeat` names a part that
/// breaks this. A library is never unloaded.

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define EVENSTEP_ABI 1  ///< of this header; evenstep refuses a library with another one
#if defined(__GNUC__)
#define EVENSTEP_EXPORT __attribute__((visibility("default")))
#else
#define EVENSTEP_EXPORT
#endif

/// What a function returns. The last two have names that [expect_stop] knows: "bad-input", "unstable-step".
enum { EVENSTEP_OK = 0, EVENSTEP_FAILED = 1, EVENSTEP_BAD_INPUT = 2, EVENSTEP_UNSTABLE_STEP = 3 };

typedef struct evenstep_error {
  char message[480];  ///< what went wrong; cut off if it is longer
  char remedy[160];   ///< what the user can do about it
} evenstep_error;

/// What the request for every part begins with. `struct_size` is the size of the whole request.
typedef struct evenstep_request {
  uint32_t struct_size;
  uint32_t reserved;
  const char* options;  ///< the scenario's `options` as a JSON object, keys in alphabetical order
  uint64_t seed;        ///< [run] seed, from which all random numbers must follow
} evenstep_request;

// ---- solver -----------------------------------------------------------------------------------------------------------

enum { EVENSTEP_LOCAL_MODEL_NONE = 0, EVENSTEP_LOCAL_MODEL_INSTANTANEOUS = 1, EVENSTEP_LOCAL_MODEL_SETTLED = 2 };

typedef struct evenstep_solver_request {
  evenstep_request part;
  double step_s;          ///< nominal simulated seconds per step; > 0
  int32_t tool_count;     ///< 1 or 2
  int32_t variable_step;  ///< not 0: steps will differ from step_s
  int32_t local_model;    ///< not NONE: contacts will be read, with this stiffness
  int32_t reserved;
} evenstep_solver_request;

/// Where a tool touches and how stiff the contact is; evenstep/sim/solver.h says what each member means.
typedef struct evenstep_contact {
  int32_t touching, unilateral;
  double point_m[3], normal[3];
  double gap_m;
  double stiffness_N_per_m[9];  ///< symmetric
} evenstep_contact;

typedef struct evenstep_solver_functions {
  uint32_t struct_size;
  uint32_t reserved;
  /// Without create, every other function gets NULL as its solver.
  int (*create)(const evenstep_solver_request* request, void** solver, evenstep_error* error);
  void (*destroy)(void* solver);
  /// Required. Advances the scene by step_s simulated seconds (> 0), at the end of which the tools are at `positions_m`
  /// (3 tool_count entries, m, finite); writes as many entries of the forces on the hand, N, which are 0 before the call.
  int (*step)(void* solver, const double* positions_m, double step_s, double* forces_N, evenstep_error* error);
  /// Capabilities. A run does without those that are NULL, and says so.
  int (*contacts)(void* solver, evenstep_contact* contacts, evenstep_error* error);  ///< tool_count entries
  int (*state_digest)(void* solver, uint64_t* digest, evenstep_error* error);        ///< of the whole state, bit for bit
  int (*energy)(void* solver, double* energy_J, evenstep_error* error);              ///< of all that moves or is stored
  /// `*displacements_m` and `*velocities_m_per_s`: 3 *count entries each, owned by the solver, read before the next call.
  int (*particles)(void* solver, int64_t* count, const double** displacements_m, const double** velocities_m_per_s,
                   evenstep_error* error);
  int (*reset)(void* solver, evenstep_error* error);  ///< to the state before the first step; NULL: another solver is made
} evenstep_solver_functions;

// ---- device -----------------------------------------------------------------------------------------------------------

/// The hand on a simulated device, and its motors. Valid as long as the device.
typedef struct evenstep_grip {
  void* host;
  void (*hand)(void* host, double position_m[3]);      ///< where the hand is now
  void (*drive)(void* host, const double force_N[3]);  ///< from now on the motors render this
} evenstep_grip;

typedef struct evenstep_device_request {
  evenstep_request part;
  const char* device;          ///< name of the [[device]]
  int64_t rate_num, rate_den;  ///< ticks per second
  int64_t first_tick_ns;
  const evenstep_grip* grip;  ///< of a simulated device, otherwise NULL
  const char* path;           ///< of a real one (--device NAME=PATH), otherwise NULL
} evenstep_device_request;

typedef struct evenstep_sample {
  double position_m[3];
  uint32_t sequence;  ///< of the newest report
  int32_t fresh;      ///< 0: no new report since the last read; 1 before the call
  int32_t at_range;   ///< not 0: along an axis the position is at an end of what the device can report
  int32_t drivable;   ///< 0: the device says that its motors are off; 1 before the call
} evenstep_sample;

typedef struct evenstep_device_functions {
  uint32_t struct_size;
  uint32_t reserved;
  int (*create)(const evenstep_device_request* request, void** device, evenstep_error* error);  ///< required
  void (*destroy)(void* device);
  int (*start)(void* device, evenstep_error* error);                                          ///< may block
  int (*read)(void* device, int64_t now_ns, evenstep_sample* sample, evenstep_error* error);  ///< required
  int (*write)(void* device, const double force_N[3], evenstep_error* error);                 ///< required
  void (*stop)(void* device);  ///< required: from now on the device renders no force
} evenstep_device_functions;

// ---- map --------------------------------------------------------------------------------------------------------------

typedef struct evenstep_map_request {
  evenstep_request part;
  int64_t step_rate_num, step_rate_den;  ///< steps per second of simulation time
} evenstep_map_request;

/// evenstep/remap/foreign_map.h says when each is called. Without create, every other function gets NULL as its map.
typedef struct evenstep_map_functions {
  uint32_t struct_size;
  uint32_t reserved;
  int (*create)(const evenstep_map_request* request, void** map, evenstep_error* error);
  void (*destroy)(void* map);
  int (*boundary)(void* map, int64_t n, int64_t begin_ns, evenstep_error* error);  ///< required
  int (*began)(void* map, int64_t n, int64_t at_ns, evenstep_error* error);
  int (*ended)(void* map, int64_t n, int64_t at_ns, evenstep_error* error);
  /// Required. `*known` is 0 before the call, and stays so while the map does not know the slot yet.
  int (*slot)(void* map, int64_t n, int64_t* slot_ns, int32_t* known, evenstep_error* error);
} evenstep_map_functions;

// ---- timing source ----------------------------------------------------------------------------------------------------

typedef struct evenstep_timing_request {
  evenstep_request part;
} evenstep_timing_request;

/// One segment (evenstep/scheduler/step_timing.h). All 0 before the call.
typedef struct evenstep_segment {
  int64_t begin_ns, end_ns;
  int64_t visualization_begin_ns, visualization_end_ns;  ///< both 0: there is none
  int64_t step_count;
  const int64_t* steps_ns;  ///< begin and end of each step: 2 step_count entries, the source's, read before the next call
  int32_t concurrent;
  int32_t more;  ///< set to 1 for a segment; left 0 at the end
} evenstep_segment;

typedef struct evenstep_timing_functions {
  uint32_t struct_size;
  uint32_t reserved;
  int (*create)(const evenstep_timing_request* request, void** source, evenstep_error* error);  ///< required
  void (*destroy)(void* source);
  int (*next)(void* source, evenstep_segment* segment, evenstep_error* error);  ///< required
} evenstep_timing_functions;

// ---- entry ------------------------------------------------------------------------------------------------------------

/// What a library has. It and all that it points to must not change until the program ends.
typedef struct evenstep_plugin {
  uint32_t abi;          ///< EVENSTEP_ABI
  uint32_t struct_size;  ///< sizeof(evenstep_plugin)
  const char* name;      ///< for messages and reports, at most 60 characters
  const evenstep_solver_functions* solver;
  const evenstep_device_functions* device;
  const evenstep_map_functions* map;
  const evenstep_timing_functions* timing;
} evenstep_plugin;

/// The only function that a library must export. NULL: it has nothing to offer, which is an error.
EVENSTEP_EXPORT const evenstep_plugin* evenstep_plugin_v1(void);

#ifdef __cplusplus
}
#endif
