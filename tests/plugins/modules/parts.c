/* One part of each kind, in plain C99: what tests/own_parts/parts.h has, behind plugin.h. */
#include "evenstep/plugins/plugin.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static double option(const char* options, const char* name, double otherwise) {
  char quoted[64];
  snprintf(quoted, sizeof quoted, "\"%s\":", name);
  const char* found = strstr(options, quoted);
  return found == NULL ? otherwise : strtod(found + strlen(quoted), NULL);
}

static int refuse(int code, evenstep_error* error, const char* message) {
  snprintf(error->message, sizeof error->message, "%s", message);
  snprintf(error->remedy, sizeof error->remedy, "write another option");
  return code;
}

/* ---- solver: F = -k x ---- */

typedef struct {
  double stiffness, fail_at, fail_with, flaky, energy_J;
  int tools, steps;
  uint64_t digest;
} spring;

static int spring_create(const evenstep_solver_request* request, void** solver, evenstep_error* error) {
  spring* made;
  if (request->part.struct_size != sizeof *request) return refuse(EVENSTEP_FAILED, error, "another header");
  if (option(request->part.options, "refuse", 0) != 0) return refuse(EVENSTEP_FAILED, error, "no such mesh\nat \"x\"\x80");
  made = calloc(1, sizeof *made);
  made->stiffness = option(request->part.options, "stiffness", 200);
  made->fail_at = option(request->part.options, "fail_at", -1);
  made->fail_with = option(request->part.options, "fail_with", EVENSTEP_FAILED);
  made->tools = request->tool_count;
  made->digest = request->part.seed;
  *solver = made;
  return EVENSTEP_OK;
}
static void spring_destroy(void* solver) { free(solver); }
static int spring_step(void* solver, const double* positions_m, double step_s, double* forces_N, evenstep_error* error) {
  spring* self = solver;
  int i;
  (void)step_s;
  if (self->steps == (int)self->fail_at) return refuse((int)self->fail_with, error, "cannot go on");
  self->energy_J = 0;
  for (i = 0; i < 3 * self->tools; ++i) {
    forces_N[i] = positions_m[i] * -self->stiffness;
    self->energy_J += 0.5 * self->stiffness * positions_m[i] * positions_m[i];
  }
  self->digest = self->digest * 31 + (uint64_t)self->steps++;
  return EVENSTEP_OK;
}
static int spring_contacts(void* solver, evenstep_contact* contacts, evenstep_error* error) {
  spring* self = solver;
  int tool, axis;
  (void)error;
  for (tool = 0; tool < self->tools; ++tool) {
    contacts[tool].touching = 1;
    for (axis = 0; axis < 3; ++axis) contacts[tool].stiffness_N_per_m[4 * axis] = self->stiffness;
  }
  return EVENSTEP_OK;
}
static int spring_digest(void* solver, uint64_t* digest, evenstep_error* error) {
  (void)error;
  *digest = ((spring*)solver)->digest;
  return EVENSTEP_OK;
}
static int spring_energy(void* solver, double* energy_J, evenstep_error* error) {
  (void)error;
  *energy_J = ((spring*)solver)->energy_J;
  return EVENSTEP_OK;
}
static int spring_reset(void* solver, evenstep_error* error) {
  (void)error;
  ((spring*)solver)->steps = 0;
  return EVENSTEP_OK;
}
static const evenstep_solver_functions solver = {.struct_size = sizeof solver,
                                                 .create = spring_create,
                                                 .destroy = spring_destroy,
                                                 .step = spring_step,
                                                 .contacts = spring_contacts,
                                                 .state_digest = spring_digest,
                                                 .energy = spring_energy,
                                                 .reset = spring_reset};

/* ---- device: the hand as it is ---- */

static int arm_create(const evenstep_device_request* request, void** device, evenstep_error* error) {
  if (request->grip == NULL) return refuse(EVENSTEP_FAILED, error, "there is no such arm");
  *device = (void*)request->grip;
  return EVENSTEP_OK;
}
static int arm_read(void* device, int64_t now_ns, evenstep_sample* sample, evenstep_error* error) {
  const evenstep_grip* grip = device;
  (void)now_ns, (void)error;
  grip->hand(grip->host, sample->position_m);
  return EVENSTEP_OK;
}
static int arm_write(void* device, const double force_N[3], evenstep_error* error) {
  const evenstep_grip* grip = device;
  (void)error;
  grip->drive(grip->host, force_N);
  return EVENSTEP_OK;
}
static void arm_stop(void* device) {
  const evenstep_grip* grip = device;
  const double none[3] = {0, 0, 0};
  grip->drive(grip->host, none);
}
static const evenstep_device_functions device = {
    .struct_size = sizeof device, .create = arm_create, .read = arm_read, .write = arm_write, .stop = arm_stop};

/* ---- map: the steps of a segment are due at the pace of the scene from its begin on ---- */

typedef struct {
  int64_t num, den, first, begin_ns;
} pacer;

static int pacer_create(const evenstep_map_request* request, void** map, evenstep_error* error) {
  pacer* made = calloc(1, sizeof *made);
  (void)error;
  made->num = request->step_rate_num;
  made->den = request->step_rate_den;
  *map = made;
  return EVENSTEP_OK;
}
static void pacer_destroy(void* map) { free(map); }
static int pacer_boundary(void* map, int64_t n, int64_t begin_ns, evenstep_error* error) {
  pacer* self = map;
  (void)error;
  self->first = n;
  self->begin_ns = begin_ns;
  return EVENSTEP_OK;
}
static int pacer_slot(void* map, int64_t n, int64_t* slot_ns, int32_t* known, evenstep_error* error) {
  const pacer* self = map;
  (void)error;
  *slot_ns = self->begin_ns + (n - self->first) * 1000000000 * self->den / self->num;
  *known = 1;
  return EVENSTEP_OK;
}
static const evenstep_map_functions map = {.struct_size = sizeof map,
                                           .create = pacer_create,
                                           .destroy = pacer_destroy,
                                           .boundary = pacer_boundary,
                                           .slot = pacer_slot};

/* ---- timing: segments of 32 ms, 8 ms of visualization and 16 steps of 1.5 ms ---- */

typedef struct {
  int64_t k, steps_ns[32];
} even;

static int even_create(const evenstep_timing_request* request, void** source, evenstep_error* error) {
  if (option(request->part.options, "refuse", 0) != 0) return refuse(EVENSTEP_FAILED, error, "no such GPU");
  *source = calloc(1, sizeof(even));
  return EVENSTEP_OK;
}
static void even_destroy(void* source) { free(source); }
static int even_next(void* source, evenstep_segment* segment, evenstep_error* error) {
  even* self = source;
  int i;
  (void)error;
  segment->begin_ns = self->k++ * 32000000;
  segment->end_ns = segment->begin_ns + 32000000;
  segment->visualization_begin_ns = segment->begin_ns;
  segment->visualization_end_ns = segment->begin_ns + 8000000;
  segment->step_count = 16;
  segment->steps_ns = self->steps_ns;
  for (i = 0; i < 16; ++i) {
    self->steps_ns[2 * i] = segment->visualization_end_ns + i * 1500000;
    self->steps_ns[2 * i + 1] = self->steps_ns[2 * i] + 1500000;
  }
  segment->more = 1;
  return EVENSTEP_OK;
}
static const evenstep_timing_functions timing = {
    .struct_size = sizeof timing, .create = even_create, .destroy = even_destroy, .next = even_next};

static const evenstep_plugin plugin = {EVENSTEP_ABI, sizeof plugin, "parts in C", &solver, &device, &map, &timing};

EVENSTEP_EXPORT const evenstep_plugin* evenstep_plugin_v1(void) { return &plugin; }
