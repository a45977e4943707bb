/* A damped spring between each tool and the origin, as a shared object in plain C: the header says what each function does.
 * options = { stiffness = 200, damping = 0 } in N/m and N s/m. */
#include <evenstep/plugins/plugin.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
  double stiffness, damping, before[6];
  int tools, steps;
} spring;

/* The options are a JSON object of numbers without blanks; a real solver would use a JSON library. */
static double option(const char* options, const char* quoted, double otherwise) {
  const char* found = strstr(options, quoted);
  return found == NULL ? otherwise : strtod(found + strlen(quoted), NULL);
}

static int create(const evenstep_solver_request* request, void** solver, evenstep_error* error) {
  spring* made = calloc(1, sizeof *made);
  if (made == NULL) return EVENSTEP_FAILED;
  made->stiffness = option(request->part.options, "\"stiffness\":", 200);
  made->damping = option(request->part.options, "\"damping\":", 0);
  made->tools = request->tool_count;
  if (made->stiffness < 0) {
    snprintf(error->message, sizeof error->message, "the stiffness %g is below 0", made->stiffness);
    snprintf(error->remedy, sizeof error->remedy, "write options = { stiffness = 200 }");
    free(made);
    return EVENSTEP_BAD_INPUT;
  }
  *solver = made;
  return EVENSTEP_OK;
}

static int step(void* solver, const double* positions_m, double step_s, double* forces_N, evenstep_error* error) {
  spring* self = solver;
  int i;
  (void)error;
  for (i = 0; i < 3 * self->tools; ++i) {
    const double velocity = self->steps == 0 ? 0 : (positions_m[i] - self->before[i]) / step_s;
    forces_N[i] = -self->stiffness * positions_m[i] - self->damping * velocity;
    self->before[i] = positions_m[i];
  }
  ++self->steps;
  return EVENSTEP_OK;
}

static int reset(void* solver, evenstep_error* error) {
  (void)error;
  ((spring*)solver)->steps = 0;
  return EVENSTEP_OK;
}

static const evenstep_solver_functions functions = {
    .struct_size = sizeof functions, .create = create, .destroy = free, .step = step, .reset = reset};
static const evenstep_plugin plugin = {.abi = EVENSTEP_ABI, .struct_size = sizeof plugin, .name = "my spring", .solver = &functions};

EVENSTEP_EXPORT const evenstep_plugin* evenstep_plugin_v1(void) { return &plugin; }
