// A plug-in whose functions do what its options tell them: {"step":"refuses"} makes that function fail with words, "throws"
// and "throws 3" make it throw, "says nothing" makes it fail without words. Other words are described where they are read.
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>

#include "evenstep/plugins/plugin.h"

namespace {

struct Told {
  std::string options;
  const evenstep_grip* grip = nullptr;
  double numbers[6] = {1, 2, 3, 4, 5, 6};
  std::int64_t steps_ns[2] = {10, 20};
  std::int64_t boundary_ns = 0, began_ns = 0, ended_ns = 0;

  bool is(const char* function, const char* what) const {
    return options.find(std::string("\"") + function + "\":\"" + what + "\"") != std::string::npos;
  }
};

int done(const Told& told, const char* function, evenstep_error* error) {
  if (told.is(function, "throws")) throw std::runtime_error("out of cheese");
  if (told.is(function, "throws 3")) throw 3;
  if (told.is(function, "says nothing")) return 42;
  if (!told.is(function, "refuses")) return EVENSTEP_OK;
  std::snprintf(error->message, sizeof error->message, "no");
  std::snprintf(error->remedy, sizeof error->remedy, "ask again");
  return EVENSTEP_BAD_INPUT;
}

template <class Request>
int create(const Request* request, void** object, evenstep_error* error) {
  auto told = std::make_unique<Told>(Told{request->part.options});
  const int code = done(*told, "create", error);
  if (code == EVENSTEP_OK) *object = told.release();
  return code;
}
void destroy(void* object) {
  auto* const told = static_cast<Told*>(object);
  const bool throws = told->is("destroy", "throws");
  delete told;
  if (throws) throw std::runtime_error("too late");
}
Told& of(void* object) { return *static_cast<Told*>(object); }

// ---- solver

int step(void* object, const double* positions_m, double, double* forces_N, evenstep_error* error) {
  for (int axis = 0; axis < 3; ++axis) forces_N[axis] = -positions_m[axis];
  return done(of(object), "step", error);
}
int contacts(void* object, evenstep_contact* contact, evenstep_error* error) {
  contact->touching = contact->unilateral = 1;
  for (int i = 0; i < 9; ++i) contact->stiffness_N_per_m[i] = i;
  contact->gap_m = 0.5;
  for (int axis = 0; axis < 3; ++axis) contact->point_m[axis] = 10 + axis, contact->normal[axis] = 20 + axis;
  return done(of(object), "contacts", error);
}
int state_digest(void* object, std::uint64_t* digest, evenstep_error* error) {
  *digest = 7;
  return done(of(object), "state_digest", error);
}
int energy(void* object, double* energy_J, evenstep_error* error) {
  *energy_J = 0.25;
  return done(of(object), "energy", error);
}
/// "fewer" and "more": a count that is not possible; "nowhere": no velocities; "none": no particle, and no place.
int particles(void* object, std::int64_t* count, const double** displacements_m, const double** velocities_m_per_s,
              evenstep_error* error) {
  Told& told = of(object);
  *count = told.is("particles", "fewer") ? -1 : told.is("particles", "more") ? INT64_MAX : 1;
  *displacements_m = told.numbers;
  *velocities_m_per_s = told.is("particles", "nowhere") ? nullptr : told.numbers + 3;
  if (told.is("particles", "none")) *count = 0, *displacements_m = *velocities_m_per_s = nullptr;
  return done(told, "particles", error);
}
int reset(void* object, evenstep_error* error) { return done(of(object), "reset", error); }

// ---- device

int create_device(const evenstep_device_request* request, void** object, evenstep_error* error) {
  const int code = create(request, object, error);
  if (code != EVENSTEP_OK) return code;
  of(*object).grip = request->grip;
  if (request->path != nullptr) of(*object).numbers[0] = static_cast<double>(std::strlen(request->path));
  return code;
}
int start(void* object, evenstep_error* error) { return done(of(object), "start", error); }
/// "asks": where the hand is. Otherwise it gives a position of its own, and says that it is neither fresh nor drivable.
int read(void* object, std::int64_t, evenstep_sample* sample, evenstep_error* error) {
  Told& told = of(object);
  sample->sequence = 9;
  sample->at_range = 1;
  if (told.is("read", "asks")) told.grip->hand(told.grip->host, sample->position_m);
  if (told.is("read", "asks")) return EVENSTEP_OK;
  sample->fresh = sample->drivable = 0;
  std::memcpy(sample->position_m, told.numbers, sizeof sample->position_m);
  return done(told, "read", error);
}
int write(void* object, const double*, evenstep_error* error) { return done(of(object), "write", error); }
void stop(void* object) {
  evenstep_error error{};
  done(of(object), "stop", &error);
}

// ---- map: a slot is known once its step has ended, and is then the sum of the last three times that it was told

int boundary(void* object, std::int64_t, std::int64_t begin_ns, evenstep_error* error) {
  of(object).boundary_ns = begin_ns;
  return done(of(object), "boundary", error);
}
int began(void* object, std::int64_t, std::int64_t at_ns, evenstep_error* error) {
  of(object).began_ns = at_ns;
  return done(of(object), "began", error);
}
int ended(void* object, std::int64_t, std::int64_t at_ns, evenstep_error* error) {
  of(object).ended_ns = at_ns;
  return done(of(object), "ended", error);
}
int slot(void* object, std::int64_t, std::int64_t* slot_ns, std::int32_t* known, evenstep_error* error) {
  const Told& told = of(object);
  *known = told.ended_ns != 0;
  *slot_ns = told.boundary_ns + told.began_ns + told.ended_ns;
  return done(told, "slot", error);
}

// ---- timing: "ends": no segment; "fewer", "more", "nowhere": as of particles; "beside": a visualization beside the steps

int next(void* object, evenstep_segment* segment, evenstep_error* error) {
  Told& told = of(object);
  segment->more = !told.is("next", "ends");
  segment->end_ns = 30;
  segment->step_count = told.is("next", "fewer") ? -1 : told.is("next", "more") ? INT64_MAX : 1;
  segment->steps_ns = told.is("next", "nowhere") ? nullptr : told.steps_ns;
  if (told.is("next", "beside")) segment->concurrent = 1, segment->visualization_end_ns = 30;
  return done(told, "next", error);
}

constexpr evenstep_solver_functions kSolver{sizeof(evenstep_solver_functions),
                                            0,
                                            create<evenstep_solver_request>,
                                            destroy,
                                            step,
                                            contacts,
                                            state_digest,
                                            energy,
                                            particles,
                                            reset};
constexpr evenstep_device_functions kDevice{
    sizeof(evenstep_device_functions), 0, create_device, destroy, start, read, write, stop};
constexpr evenstep_map_functions kMap{
    sizeof(evenstep_map_functions), 0, create<evenstep_map_request>, destroy, boundary, began, ended, slot};
constexpr evenstep_timing_functions kTiming{sizeof(evenstep_timing_functions), 0, create<evenstep_timing_request>, destroy,
                                            next};
constexpr evenstep_plugin kPlugin{EVENSTEP_ABI, sizeof(evenstep_plugin), "told\x1b[2J", &kSolver, &kDevice, &kMap, &kTiming};

}  // namespace

const evenstep_plugin* evenstep_plugin_v1(void) { return &kPlugin; }
