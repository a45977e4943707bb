#pragma once
/* What the tests of evenstep_remap.h ask of a program in C; remap_c_calls.c is compiled as C99 and once more as C++. */

#include "evenstep_remap.h"

#ifdef __cplusplus
extern "C" {
#endif

enum remap_c_what { REMAP_C_SAMPLE, REMAP_C_FORCE, REMAP_C_SEGMENT, REMAP_C_BEGIN_STEP, REMAP_C_END_STEP };

/* A call, and what it gave. */
typedef struct remap_c_call {
  int what;
  int64_t at_ns;
  double value[EVENSTEP_REMAP_MOST_COMPONENTS]; /* in for a sample and an end, out for a force and a begin */
  int code;
  uint32_t status, has_slot;
  int64_t time_ns; /* R(n) of a begin, F(n) of an end */
} remap_c_call;

/* Makes a remap, makes the calls, and takes the counts. Returns the first code that is not EVENSTEP_REMAP_OK. */
int remap_c_play(const evenstep_remap_options* options, remap_c_call* calls, int count, evenstep_remap_counts* counts);
int remap_c_play_as_cpp(const evenstep_remap_options* options, remap_c_call* calls, int count,
                        evenstep_remap_counts* counts);

#ifdef __cplusplus
}
#endif
