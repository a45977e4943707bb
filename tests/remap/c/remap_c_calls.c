#include "remap_c_calls.h"

#include <stddef.h>
#include <stdio.h>

#ifdef __cplusplus
#define PLAY remap_c_play_as_cpp
#else
#define PLAY remap_c_play
#endif

static int make(evenstep_remap* remap, remap_c_call* call) {
  evenstep_remap_read read;
  int code;
  switch (call->what) {
    case REMAP_C_SAMPLE:
      return evenstep_remap_sample(remap, call->at_ns, call->value);
    case REMAP_C_FORCE:
      return evenstep_remap_force(remap, call->at_ns, call->value, &call->status);
    case REMAP_C_SEGMENT:
      return evenstep_remap_segment(remap, call->at_ns);
    case REMAP_C_BEGIN_STEP:
      read.struct_size = sizeof read;
      code = evenstep_remap_begin_step(remap, call->at_ns, call->value, &read);
      call->status = read.status;
      call->has_slot = read.has_slot;
      call->time_ns = read.read_ns;
      return code;
    default:
      return evenstep_remap_end_step(remap, call->at_ns, call->value, &call->time_ns);
  }
}

int PLAY(const evenstep_remap_options* options, remap_c_call* calls, int count, evenstep_remap_counts* counts) {
  evenstep_remap* remap;
  int i, first = evenstep_remap_create(options, &remap);
  if (first != EVENSTEP_REMAP_OK) return first;
  for (i = 0; i < count; ++i) {
    calls[i].code = make(remap, &calls[i]);
    if (first == EVENSTEP_REMAP_OK) first = calls[i].code;
  }
  counts->struct_size = sizeof *counts;
  i = evenstep_remap_get_counts(remap, counts);
  evenstep_remap_destroy(remap);
  if (first != EVENSTEP_REMAP_OK || i != EVENSTEP_REMAP_OK) puts(evenstep_remap_last_error());
  return first != EVENSTEP_REMAP_OK ? first : i;
}
