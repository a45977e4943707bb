#ifndef EVENSTEP_REMAP_H
#define EVENSTEP_REMAP_H
/* The remap of evenstep for C, and for every language that can call C (C#, Python, Unity, Unreal). It maps between the even
 * time of a device and the uneven time of a simulation: each step of the simulation gets a slot in even time, reads where
 * the hand was a lead before that, and its force is played a constant latency after the time of the read. Plain C99, and
 * C++. docs/parts/embedding.md explains it.
 *
 *     evenstep_remap_options options;
 *     evenstep_remap* remap;
 *     evenstep_remap_options_init(&options, sizeof options);
 *     options.lead_ns = 261 * EVENSTEP_REMAP_US;
 *     options.latency_ns = 15 * EVENSTEP_REMAP_MS + 66 * EVENSTEP_REMAP_US;
 *     if (evenstep_remap_create(&options, &remap) != EVENSTEP_REMAP_OK) puts(evenstep_remap_last_error());
 *
 *     device thread, every tick:          evenstep_remap_sample(remap, now, position_m);
 *                                         evenstep_remap_force(remap, now, force_N, NULL);
 *     simulation thread, every segment:   evenstep_remap_segment(remap, now);
 *     simulation thread, every step:      evenstep_remap_begin_step(remap, now, position_m, NULL);  ...step...
 *                                         evenstep_remap_end_step(remap, now, force_N, NULL);
 *
 * Times are nanoseconds since a start that is the same for all calls, from a clock that is never set back (CLOCK_MONOTONIC,
 * System.Diagnostics.Stopwatch, time.monotonic_ns), and lie within +-EVENSTEP_REMAP_FURTHEST_NS (31 years). Positions and
 * forces are `components` doubles each, all of them finite; their units are the caller's.
 *
 * Threads: one device thread and one simulation thread at the same time, each with its own functions; counts from any
 * thread. Create and destroy while nobody else uses the handle. No call in between waits or locks, and none allocates
 * unless it is refused.
 *
 * Every function that returns int returns a code: EVENSTEP_REMAP_OK, or what is wrong, which evenstep_remap_last_error()
 * then says in words. A call that is refused has changed nothing and written nothing. No C++ exception leaves the library.
 * A handle that was destroyed, or memory too short for what is written, cannot be detected. */

#include <stdint.h>

#if defined(_WIN32) && defined(EVENSTEP_REMAP_SHARED)
#ifdef EVENSTEP_REMAP_BUILD
#define EVENSTEP_REMAP_API __declspec(dllexport)
#else
#define EVENSTEP_REMAP_API __declspec(dllimport)
#endif
#elif defined(__GNUC__)
#define EVENSTEP_REMAP_API __attribute__((visibility("default")))
#else
#define EVENSTEP_REMAP_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* The version of this interface. It rises when a function changes; new fields are only ever added at the end of a struct,
 * whose struct_size says which of them the caller knows. */
#define EVENSTEP_REMAP_ABI 1
/* The library's version: a program that loads it compares this with EVENSTEP_REMAP_ABI. */
EVENSTEP_REMAP_API uint32_t evenstep_remap_abi(void);

#define EVENSTEP_REMAP_US INT64_C(1000)    /* a microsecond, ns */
#define EVENSTEP_REMAP_MS INT64_C(1000000) /* a millisecond, ns */
#define EVENSTEP_REMAP_FURTHEST_NS INT64_C(1000000000000000000)
#define EVENSTEP_REMAP_LONGEST_NS INT64_C(1000000000000000) /* 11 days: the limit of every length in the options */
#define EVENSTEP_REMAP_MOST_COMPONENTS 8
#define EVENSTEP_REMAP_MOST_ENTRIES 1048576 /* of a ring */

/* Codes. */
#define EVENSTEP_REMAP_OK 0
#define EVENSTEP_REMAP_INVALID 1  /* a null pointer, a number outside its range or not finite */
#define EVENSTEP_REMAP_ORDER 2    /* a time before the previous one, or begin_step and end_step do not alternate */
#define EVENSTEP_REMAP_ABI_SIZE 3 /* struct_size is not that of a version that this library knows */
#define EVENSTEP_REMAP_MEMORY 4   /* there is not enough memory */
#define EVENSTEP_REMAP_BROKEN 5   /* a fault of the library */

/* How forces are played: the latest one that is due, or the line between two, which needs one slot more latency. */
#define EVENSTEP_REMAP_HOLD 0
#define EVENSTEP_REMAP_LINEAR 1

typedef struct evenstep_remap_options {
  uint32_t struct_size; /* sizeof this struct: evenstep_remap_options_init sets it */
  uint32_t components;  /* of a position and of a force, 1 to EVENSTEP_REMAP_MOST_COMPONENTS; default 3 */
  int64_t lead_ns;      /* R(n) = slot - lead; `evenstep size` computes it and the latency. May be negative */
  int64_t latency_ns;   /* F(n) = R(n) + latency */
  uint32_t emission;    /* EVENSTEP_REMAP_LINEAR (default) or EVENSTEP_REMAP_HOLD */
  uint32_t adapts;      /* 1: the latency follows what the steps need, by the adapt_ fields; default 0 */
  double bandwidth_Hz;  /* how fast the map follows a change of pace, 1e-3 to 1e3; default 2 */
  uint32_t sample_capacity, force_capacity; /* of the rings, 2 to EVENSTEP_REMAP_MOST_ENTRIES; default 64 */
  /* A read past the newest entry gets that entry's value, or with a window > 0 the line through the last `window` of the
   * buffer, for at most `furthest`. */
  int64_t sample_window_ns, sample_furthest_ns; /* default 0: held */
  int64_t force_window_ns, force_furthest_ns;   /* default 0: held. With EVENSTEP_REMAP_HOLD no read is past the newest */
  /* Used with `adapts` = 1, in place of latency_ns: the latency starts at `start`, stays between `least` and `most`, grows
   * at once when a force was late, and shrinks by `slew` millionths when `window` has passed. */
  int64_t adapt_start_ns, adapt_least_ns, adapt_most_ns; /* default 0 */
  int64_t adapt_window_ns, adapt_margin_ns;              /* default 10 s and 1 ms */
  int64_t adapt_slew_ppm;                                /* 0 to 500000; default 5000 */
} evenstep_remap_options;

/* How a read ended. */
#define EVENSTEP_REMAP_INSIDE 0   /* between two entries, or on one */
#define EVENSTEP_REMAP_UNDERRUN 1 /* past the newest entry: held or on the line */
#define EVENSTEP_REMAP_OVERRUN 2  /* older than the ring holds: its oldest value, wrong for this time */
#define EVENSTEP_REMAP_EMPTY 3    /* no entry yet, or before the first force: zeros */

/* What a step has read. */
typedef struct evenstep_remap_read {
  uint32_t struct_size; /* set by the caller to sizeof this struct */
  uint32_t status;      /* EVENSTEP_REMAP_INSIDE, ... */
  int64_t read_ns;      /* R(n); the begin of a step that has no slot */
  int64_t newest_ns;    /* time of the newest sample that was visible; 0 if there was none */
  uint32_t has_slot;    /* 0 while the map has not seen a complete segment: the newest sample was read */
  uint32_t reserved;
} evenstep_remap_read;

typedef struct evenstep_remap_counts {
  uint32_t struct_size; /* set by the caller to sizeof this struct */
  uint32_t reserved;
  uint64_t steps;          /* that have begun */
  uint64_t acquiring;      /* of these: without a slot yet */
  uint64_t late_forces;    /* too late for a tick that needs them: after F(n); with linear emission after F(n - 1), where
                            * the line to F(n) begins */
  int64_t latest_force_ns; /* how long after that the latest of them came */
  /* Reads of the hand by steps that had a slot, and reads of forces by ticks. */
  uint64_t hand_inside, hand_held, hand_extrapolated, hand_overruns, hand_empty;
  uint64_t force_inside, force_held, force_extrapolated, force_overruns, force_empty;
} evenstep_remap_counts;

/* For a loop that knows its own simulation time, such as a game's fixed time step. */
typedef struct evenstep_remap_clock {
  uint32_t struct_size; /* set by the caller to sizeof this struct */
  uint32_t reserved;
  int64_t steps, seconds; /* so many steps simulate so many seconds: 60 and 1. Each 1 to 1e9 */
  /* By how much a step may move the slots after the loop has dropped simulated time, 1 to EVENSTEP_REMAP_LONGEST_NS; 0: by
   * all of it. */
  int64_t dropped_jump_ns;
} evenstep_remap_clock;

typedef struct evenstep_remap evenstep_remap;

/* Fills in the defaults; struct_size = sizeof *options. */
EVENSTEP_REMAP_API int evenstep_remap_options_init(evenstep_remap_options* options, uint32_t struct_size);
/* *remap is the new handle, or NULL if it was refused. */
EVENSTEP_REMAP_API int evenstep_remap_create(const evenstep_remap_options* options, evenstep_remap** remap);
/* The same for a loop that knows its own time: its steps begin with evenstep_remap_begin_step_at, and need no segments;
 * bandwidth_Hz is not used. */
EVENSTEP_REMAP_API int evenstep_remap_create_clocked(const evenstep_remap_options* options,
                                                     const evenstep_remap_clock* clock, evenstep_remap** remap);
/* NULL is allowed. */
EVENSTEP_REMAP_API void evenstep_remap_destroy(evenstep_remap* remap);

/* Device thread. The times of samples do not decrease; a force may be asked for at any time. `status` may be NULL. */
EVENSTEP_REMAP_API int evenstep_remap_sample(evenstep_remap* remap, int64_t now_ns, const double* position);
EVENSTEP_REMAP_API int evenstep_remap_force(evenstep_remap* remap, int64_t now_ns, double* force, uint32_t* status);

/* Simulation thread. A segment is one visualization and its steps; call evenstep_remap_segment at the begin of each, or no
 * step ever has a slot. begin_step and end_step alternate; the times of segments do not decrease, nor do those of steps.
 * `read` and `emission_ns` may be NULL; *emission_ns becomes F(n). */
EVENSTEP_REMAP_API int evenstep_remap_segment(evenstep_remap* remap, int64_t begin_ns);
EVENSTEP_REMAP_API int evenstep_remap_begin_step(evenstep_remap* remap, int64_t now_ns, double* position,
                                                 evenstep_remap_read* read);
/* The same with the step's own simulation time from any origin, with what the loop has dropped so far added to it. A handle
 * of evenstep_remap_create has no use for it. */
EVENSTEP_REMAP_API int evenstep_remap_begin_step_at(evenstep_remap* remap, int64_t now_ns, int64_t simulated_ns,
                                                    double* position, evenstep_remap_read* read);
EVENSTEP_REMAP_API int evenstep_remap_end_step(evenstep_remap* remap, int64_t now_ns, const double* force,
                                               int64_t* emission_ns);

/* Any thread. Each number was true a moment ago. */
EVENSTEP_REMAP_API int evenstep_remap_get_counts(const evenstep_remap* remap, evenstep_remap_counts* counts);

/* What was wrong in the last refused call on this thread; "" if none was refused. Valid until the next refused call. */
EVENSTEP_REMAP_API const char* evenstep_remap_last_error(void);

#ifdef __cplusplus
}
#endif
#endif
