/* The remap in plain C, with the timing of the paper: 30 times a second a visualization of 11.1 ms, and then 15 steps. The
 * hand moves evenly, and so do the positions that the steps read and the forces that the device plays. Here one thread plays
 * both parts, in programmed time; a program has two, and its device thread makes the calls of device_until. */
#include <evenstep_remap.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define STIFFNESS_N_PER_M 200.0
#define STEP_M (0.1 / 450) /* how far the hand moves in a slot */

static void check(int code) {
  if (code == EVENSTEP_REMAP_OK) return;
  fprintf(stderr, "%s\n", evenstep_remap_last_error());
  exit(1);
}

/* The largest change of velocity of a signal, in its own unit. */
typedef struct {
  double last, before, most;
} velocity_jump;
static void add(velocity_jump* jump, double value, int judged) {
  if (judged) jump->most = fmax(jump->most, fabs(value - 2 * jump->last + jump->before));
  jump->before = jump->last;
  jump->last = value;
}

/* The ticks of the device before this time, and a tick at this very time if `including`. */
static void device_until(evenstep_remap* remap, int64_t until_ns, int including, velocity_jump* felt) {
  static int64_t now_ns = 0;
  for (; now_ns < until_ns + including; now_ns += EVENSTEP_REMAP_MS) {
    const double position_m[3] = {1e-10 * (double)now_ns, 0, 0}; /* 0.1 m/s */
    double force_N[3];
    check(evenstep_remap_sample(remap, now_ns, position_m));
    check(evenstep_remap_force(remap, now_ns, force_N, NULL));
    add(felt, force_N[0], now_ns > 270 * EVENSTEP_REMAP_MS);
  }
}

int main(void) {
  evenstep_remap_options options;
  evenstep_remap* remap;
  evenstep_remap_counts counts;
  velocity_jump read = {0}, felt = {0};
  if (evenstep_remap_abi() != EVENSTEP_REMAP_ABI) return 1;
  check(evenstep_remap_options_init(&options, sizeof options));
  options.lead_ns = 261 * EVENSTEP_REMAP_US;
  options.latency_ns = 15 * EVENSTEP_REMAP_MS + 66 * EVENSTEP_REMAP_US;
  check(evenstep_remap_create(&options, &remap));
  for (int64_t k = 0; k < 60; ++k) {
    const int64_t segment_ns = k * 1000 * EVENSTEP_REMAP_MS / 30, end_ns = (k + 1) * 1000 * EVENSTEP_REMAP_MS / 30;
    const int64_t first_ns = segment_ns + 11 * EVENSTEP_REMAP_MS + 100 * EVENSTEP_REMAP_US;
    device_until(remap, segment_ns, 1, &felt);
    check(evenstep_remap_segment(remap, segment_ns));
    for (int i = 0; i < 15; ++i) {
      const int64_t step_ns = first_ns + (end_ns - first_ns) * i / 15;
      const int64_t step_end_ns = first_ns + (end_ns - first_ns) * (i + 1) / 15;
      double x_m[3], force_N[3] = {0};
      device_until(remap, step_ns, 1, &felt);
      check(evenstep_remap_begin_step(remap, step_ns, x_m, NULL));
      add(&read, x_m[0], k > 8);
      force_N[0] = -STIFFNESS_N_PER_M * x_m[0];
      device_until(remap, step_end_ns, 0, &felt);
      check(evenstep_remap_end_step(remap, step_end_ns, force_N, NULL));
    }
  }
  counts.struct_size = sizeof counts;
  check(evenstep_remap_get_counts(remap, &counts));
  evenstep_remap_destroy(remap);
  printf("velocity jump: %.2g step in, %.2g step out; %d underruns, %d late forces\n", read.most / STEP_M,
         felt.most / STEP_M / STIFFNESS_N_PER_M, (int)counts.hand_held, (int)counts.late_forces);
  return read.most < 1e-6 * STEP_M && felt.most < 1e-6 * STEP_M * STIFFNESS_N_PER_M && counts.late_forces == 0 ? 0 : 1;
}
