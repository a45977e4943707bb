#include "library_parts.h"

#include <fmt/format.h>

#include <cstring>
#include <exception>
#include <stdexcept>

#include "excerpt.h"

namespace evenstep::internal {
namespace {

constexpr const char* kRemedy = "see what the library does there";

std::string text_in(const char* buffer, std::size_t size) { return excerpt({buffer, strnlen(buffer, size)}, size); }

/// What has gone wrong, as the library says.
struct Refusal {
  int code;
  std::string message, remedy;
};

/// Calls a function of the library and throws what `refuse` makes of its refusal.
template <class Refuse, class Call>
void ask(const char* function, Refuse refuse, Call call) {
  evenstep_error error{};
  int code = EVENSTEP_FAILED;
  try {
    code = call(&error);
  } catch (const std::exception& thrown) {
    throw refuse(Refusal{EVENSTEP_FAILED, fmt::format("{} threw an exception: {}", function, excerpt(thrown.what(), 400)),
                         "catch it in the library, and return EVENSTEP_FAILED"});
  } catch (...) {
    throw refuse(Refusal{EVENSTEP_FAILED, fmt::format("{} threw something that is no std::exception", function),
                         "catch it in the library, and return EVENSTEP_FAILED"});
  }
  if (code == EVENSTEP_OK) return;
  const std::string message = text_in(error.message, sizeof error.message),
                    remedy = text_in(error.remedy, sizeof error.remedy);
  throw refuse(Refusal{code,
                       message.empty() ? fmt::format("{} returned {}", function, code)
                                       : fmt::format("{} returned {}: {}", function, code, message),
                       remedy.empty() ? kRemedy : remedy});
}

SolverError solver_error(const Refusal& refusal) {
  return SolverError(refusal.code == EVENSTEP_BAD_INPUT       ? SolverFault::bad_input
                     : refusal.code == EVENSTEP_UNSTABLE_STEP ? SolverFault::unstable_step
                                                              : SolverFault::unavailable,
                     refusal.message, refusal.remedy);
}
/// For parts whose errors have no kinds.
std::runtime_error plain_error(const Refusal& refusal) { return std::runtime_error(refusal.message); }

/// What the library has made, and how it is given back.
class Made {
 public:
  explicit Made(void (*destroy)(void*)) : destroy_(destroy) {}
  Made(const Made&) = delete;
  Made& operator=(const Made&) = delete;
  ~Made() {
    if (!is_made_ || destroy_ == nullptr) return;
    try {
      destroy_(object);
    } catch (...) {  // nobody is left to hear of it
    }
  }
  template <class Functions, class Request, class Refuse>
  void make(const Functions& functions, const Request& request, Refuse refuse) {
    if (functions.create != nullptr)
      ask("create", refuse, [&](evenstep_error* error) { return functions.create(&request, &object, error); });
    is_made_ = functions.create != nullptr;
  }

  void* object = nullptr;

 private:
  void (*destroy_)(void*);
  bool is_made_ = false;
};

template <class Request>
evenstep_request part_of(const std::string& options, std::uint64_t seed) {
  return {.struct_size = sizeof(Request), .reserved = 0, .options = options.c_str(), .seed = seed};
}

std::vector<glm::dvec3> vectors(const double* numbers, std::int64_t count) {
  std::vector<glm::dvec3> out(static_cast<std::size_t>(count));
  for (glm::dvec3& v : out) {
    v = {numbers[0], numbers[1], numbers[2]};
    numbers += 3;
  }
  return out;
}

class LibrarySolver final : public ForeignSolver {
 public:
  LibrarySolver(const evenstep_solver_functions& functions, const SolverRequest& request)
      : call_(functions), solver_(functions.destroy), contacts_(static_cast<std::size_t>(request.tool_count)) {
    solver_.make(functions,
                 evenstep_solver_request{.part = part_of<evenstep_solver_request>(request.options, request.seed),
                                         .step_s = request.step_s,
                                         .tool_count = request.tool_count,
                                         .variable_step = request.variable_step ? 1 : 0,
                                         .local_model = static_cast<std::int32_t>(request.local_model),
                                         .reserved = 0},
                 solver_error);
  }
  ToolResponse step(std::span<const glm::dvec3> positions_m, double step_s) override {
    std::array<double, 3 * kMaxTools> positions{}, forces{};
    for (std::size_t tool = 0; tool < positions_m.size(); ++tool) {
      for (int axis = 0; axis < 3; ++axis) positions[3 * tool + static_cast<std::size_t>(axis)] = positions_m[tool][axis];
    }
    ask("step", solver_error,
        [&](evenstep_error* error) { return call_.step(solver_.object, positions.data(), step_s, forces.data(), error); });
    ToolResponse response;
    for (std::size_t tool = 0; tool < positions_m.size(); ++tool)
      response.force_N[tool] = {forces[3 * tool], forces[3 * tool + 1], forces[3 * tool + 2]};
    return response;
  }
  SolverCapabilities capabilities() const override {
    return {.contacts = call_.contacts != nullptr,
            .state_digest = call_.state_digest != nullptr,
            .energy = call_.energy != nullptr,
            .particles = call_.particles != nullptr,
            .reset = call_.reset != nullptr};
  }
  std::span<const ToolContact> contacts() const override {
    std::array<evenstep_contact, kMaxTools> given{};
    ask("contacts", solver_error,
        [&](evenstep_error* error) { return call_.contacts(solver_.object, given.data(), error); });
    for (std::size_t tool = 0; tool < contacts_.size(); ++tool) {
      const evenstep_contact& from = given[tool];
      ToolContact& contact = contacts_[tool];
      contact.touching = from.touching != 0;
      contact.unilateral = from.unilateral != 0;
      contact.gap_m = from.gap_m;
      for (int axis = 0; axis < 3; ++axis) {
        contact.point_m[axis] = from.point_m[axis];
        contact.normal[axis] = from.normal[axis];
        for (int other = 0; other < 3; ++other)
          contact.stiffness_N_per_m[axis][other] = from.stiffness_N_per_m[3 * axis + other];
      }
    }
    return contacts_;
  }
  std::uint64_t state_digest() override {
    std::uint64_t digest = 0;
    ask("state_digest", solver_error,
        [&](evenstep_error* error) { return call_.state_digest(solver_.object, &digest, error); });
    return digest;
  }
  double energy_J() override {
    double energy_J = 0;
    ask("energy", solver_error, [&](evenstep_error* error) { return call_.energy(solver_.object, &energy_J, error); });
    return energy_J;
  }
  ParticleState particles() override {
    constexpr std::int64_t kMostParticles = 100'000'000;
    std::int64_t count = 0;
    const double *displacements_m = nullptr, *velocities_m_per_s = nullptr;
    ask("particles", solver_error, [&](evenstep_error* error) {
      return call_.particles(solver_.object, &count, &displacements_m, &velocities_m_per_s, error);
    });
    if (count < 0 || count > kMostParticles || (count > 0 && (displacements_m == nullptr || velocities_m_per_s == nullptr)))
      throw SolverError(SolverFault::unavailable,
                        fmt::format("particles gave {} of them, or no place where they are", count), kRemedy);
    return {vectors(displacements_m, count), vectors(velocities_m_per_s, count)};
  }
  void reset() override {
    ask("reset", solver_error, [&](evenstep_error* error) { return call_.reset(solver_.object, error); });
  }

 private:
  const evenstep_solver_functions& call_;
  Made solver_;
  mutable std::vector<ToolContact> contacts_;  // one per tool
};

/// An exception of the grip must not pass through the library's code: it is kept, and thrown when that code has returned.
class CarriedGrip {
 public:
  explicit CarriedGrip(SimulatedGrip* grip) : grip_(grip) {}
  evenstep_grip table() { return {this, hand, drive}; }
  void throw_kept() {
    if (kept_) std::rethrow_exception(std::exchange(kept_, nullptr));
  }

 private:
  static void hand(void* host, double position_m[3]) {
    auto& self = *static_cast<CarriedGrip*>(host);
    self.keeping([&] {
      const glm::dvec3 at = self.grip_->hand_m();
      for (int axis = 0; axis < 3; ++axis) position_m[axis] = at[axis];
    });
  }
  static void drive(void* host, const double force_N[3]) {
    auto& self = *static_cast<CarriedGrip*>(host);
    self.keeping([&] { self.grip_->drive({force_N[0], force_N[1], force_N[2]}); });
  }
  template <class Call>
  void keeping(Call call) {
    try {
      call();
    } catch (...) {
      if (!kept_) kept_ = std::current_exception();
    }
  }

  SimulatedGrip* grip_;
  std::exception_ptr kept_;
};

class LibraryDevice final : public HapticDevice {
 public:
  LibraryDevice(const evenstep_device_functions& functions, const DeviceRequest& request)
      : call_(functions), carried_(request.grip), grip_(carried_.table()), device_(functions.destroy) {
    const evenstep_device_request asked{.part = part_of<evenstep_device_request>(request.options, request.seed),
                                        .device = request.device.c_str(),
                                        .rate_num = request.rate.num,
                                        .rate_den = request.rate.den,
                                        .first_tick_ns = request.first_tick.ns,
                                        .grip = request.grip == nullptr ? nullptr : &grip_,
                                        .path = request.path.empty() ? nullptr : request.path.c_str()};
    device_.make(functions, asked, plain_error);
    carried_.throw_kept();
  }
  void start() override {
    if (call_.start == nullptr) return;
    asking("start", [&](evenstep_error* error) { return call_.start(device_.object, error); });
  }
  void stop() noexcept override {
    try {
      call_.stop(device_.object);
    } catch (...) {  // the motors' log says whether it did stop
    }
  }
  DeviceSample read(RealTime now) override {
    evenstep_sample given{};
    given.fresh = given.drivable = 1;
    asking("read", [&](evenstep_error* error) { return call_.read(device_.object, now.ns, &given, error); });
    return {.position_m = {given.position_m[0], given.position_m[1], given.position_m[2]},
            .sequence = given.sequence,
            .fresh = given.fresh != 0,
            .at_range = given.at_range != 0,
            .drivable = given.drivable != 0};
  }
  void write(const glm::dvec3& force_N) override {
    const double force[3] = {force_N.x, force_N.y, force_N.z};
    asking("write", [&](evenstep_error* error) { return call_.write(device_.object, force, error); });
  }

 private:
  template <class Call>
  void asking(const char* function, Call call) {
    ask(function, plain_error, call);
    carried_.throw_kept();
  }

  const evenstep_device_functions& call_;
  CarriedGrip carried_;
  evenstep_grip grip_;
  Made device_;
};

class LibraryMap final : public ForeignMap {
 public:
  LibraryMap(const evenstep_map_functions& functions, const MapRequest& request)
      : call_(functions), map_(functions.destroy) {
    map_.make(functions,
              evenstep_map_request{.part = part_of<evenstep_map_request>(request.options, request.seed),
                                   .step_rate_num = request.step_rate.num,
                                   .step_rate_den = request.step_rate.den},
              plain_error);
  }
  void boundary(std::int64_t n, RealTime begin) override {
    ask("boundary", plain_error, [&](evenstep_error* error) { return call_.boundary(map_.object, n, begin.ns, error); });
  }
  void began(std::int64_t n, RealTime at) override {
    if (call_.began == nullptr) return;
    ask("began", plain_error, [&](evenstep_error* error) { return call_.began(map_.object, n, at.ns, error); });
  }
  void ended(std::int64_t n, RealTime at) override {
    if (call_.ended == nullptr) return;
    ask("ended", plain_error, [&](evenstep_error* error) { return call_.ended(map_.object, n, at.ns, error); });
  }
  std::optional<RealTime> slot(std::int64_t n) override {
    std::int64_t slot_ns = 0;
    std::int32_t known = 0;
    ask("slot", plain_error, [&](evenstep_error* error) { return call_.slot(map_.object, n, &slot_ns, &known, error); });
    if (known == 0) return std::nullopt;
    return RealTime{slot_ns};
  }

 private:
  const evenstep_map_functions& call_;
  Made map_;
};

class LibraryTiming final : public StepTiming {
 public:
  LibraryTiming(const evenstep_timing_functions& functions, const TimingRequest& request)
      : call_(functions), source_(functions.destroy) {
    source_.make(functions, evenstep_timing_request{part_of<evenstep_timing_request>(request.options, request.seed)},
                 plain_error);
  }
  bool next(SegmentTiming& segment) override {
    evenstep_segment given{};
    ask("next", plain_error, [&](evenstep_error* error) { return call_.next(source_.object, &given, error); });
    if (given.more == 0) return false;
    if (given.step_count < 0 || given.step_count > static_cast<std::int64_t>(kMostDrawnPieces) ||
        (given.step_count > 0 && given.steps_ns == nullptr))
      throw std::runtime_error(fmt::format("next gave a segment of {} steps, or no place where they are", given.step_count));
    segment.begin = RealTime{given.begin_ns};
    segment.end = RealTime{given.end_ns};
    segment.concurrent = given.concurrent != 0;
    segment.visualization.reset();
    if (given.visualization_begin_ns != 0 || given.visualization_end_ns != 0)
      segment.visualization = Interval{RealTime{given.visualization_begin_ns}, RealTime{given.visualization_end_ns}};
    segment.steps.clear();
    for (std::int64_t i = 0; i < given.step_count; ++i)
      segment.steps.push_back({RealTime{given.steps_ns[2 * i]}, RealTime{given.steps_ns[2 * i + 1]}});
    return true;
  }

 private:
  const evenstep_timing_functions& call_;
  Made source_;
};

}  // namespace

SolverFactory solver_factory(const evenstep_solver_functions& functions) {
  return [&functions](const SolverRequest& request) { return std::make_unique<LibrarySolver>(functions, request); };
}
DeviceFactory device_factory(const evenstep_device_functions& functions) {
  return [&functions](const DeviceRequest& request) { return std::make_unique<LibraryDevice>(functions, request); };
}
MapFactory map_factory(const evenstep_map_functions& functions) {
  return [&functions](const MapRequest& request) { return std::make_unique<LibraryMap>(functions, request); };
}
TimingFactory timing_factory(const evenstep_timing_functions& functions) {
  return [&functions](const TimingRequest& request) { return std::make_unique<LibraryTiming>(functions, request); };
}

}  // namespace evenstep::internal
