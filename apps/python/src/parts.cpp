#include "parts.h"

#include <fmt/format.h>

#include <algorithm>

#include "evenstep/format/registry.h"

namespace evenstep::python {
namespace {

using Error = std::shared_ptr<FirstError>;

/// Calls Python; what is raised there goes on as what C++ parts throw.
template <class Call>
auto guarded(const Error& error, Call call) -> decltype(call()) {
  const py::gil_scoped_acquire gil;
  try {
    return call();
  } catch (const py::error_already_set& raised) {
    const std::runtime_error kept = error->keep(raised);
    const py::object value = raised.value();
    if (py::hasattr(value, "reason") && py::hasattr(value, "remedy")) {  // evenstep.SolverError
      const auto reason = py::cast<std::string>(value.attr("reason"));
      throw SolverError(reason == "unstable-step" ? SolverFault::unstable_step : SolverFault::bad_input, kept.what(),
                        py::cast<std::string>(value.attr("remedy")));
    }
    throw kept;
  } catch (const py::builtin_exception& wrong) {  // what a part has returned
    throw std::runtime_error(wrong.what());
  }
}

Doubles row_of(const glm::dvec3& v) { return Doubles(3, &v.x); }

glm::dvec3 vector_of(const double* at) { return {at[0], at[1], at[2]}; }

/// A request as an object with these members.
py::object request(const std::string& name, const std::string& options, std::uint64_t seed, const py::dict& more) {
  more["name"] = name;
  more["options"] = json_loads(options);
  more["seed"] = seed;
  return py::module_::import("types").attr("SimpleNamespace")(**more);
}

/// A part's object: it is called, and dropped, with the GIL only.
class Part {
 public:
  Part(const Held& make, const py::object& wanted, Error error) : error_(std::move(error)), object_(hold((*make)(wanted))) {}
  bool has(const char* name) const { return py::hasattr(*object_, name); }
  template <class... Arguments>
  py::object call(const char* name, Arguments&&... arguments) const {
    return object_->attr(name)(std::forward<Arguments>(arguments)...);
  }
  const Error& error() const { return error_; }
  const py::object& object() const { return *object_; }

 private:
  Error error_;
  Held object_;
};

class PythonSolver final : public ForeignSolver {
 public:
  PythonSolver(Part part, int tools) : part_(std::move(part)), tools_(tools) {
    has_ = {.state_digest = part_.has("state_digest"),
            .energy = part_.has("energy_J"),
            .particles = part_.has("particles"),
            .reset = part_.has("reset")};
  }
  ToolResponse step(std::span<const glm::dvec3> positions_m, double step_s) override {
    return guarded(part_.error(), [&] {
      Doubles tools({static_cast<py::ssize_t>(positions_m.size()), py::ssize_t{3}});
      double* at = tools.mutable_data();
      for (const glm::dvec3& x : positions_m) *at++ = x.x, *at++ = x.y, *at++ = x.z;
      const Doubles forces = doubles_of(part_.call("step", tools, step_s), {tools_, 3}, "step() returned");
      ToolResponse response;
      for (int tool = 0; tool < tools_; ++tool)
        response.force_N[static_cast<std::size_t>(tool)] = vector_of(forces.data() + 3 * tool);
      return response;
    });
  }
  SolverCapabilities capabilities() const override { return has_; }
  std::uint64_t state_digest() override {
    return guarded(part_.error(), [&] { return py::cast<std::uint64_t>(part_.call("state_digest")); });
  }
  double energy_J() override {
    return guarded(part_.error(), [&] { return py::cast<double>(part_.call("energy_J")); });
  }
  ParticleState particles() override {
    return guarded(part_.error(), [&] {
      const py::tuple both = part_.call("particles");
      ParticleState state;
      for (auto& [vectors, given] :
           {std::pair{&state.displacement_m, both[0]}, std::pair{&state.velocity_m_per_s, both[1]}}) {
        const Doubles rows = Doubles::ensure(given);
        if (!rows || rows.ndim() != 2 || rows.shape(1) != 3)
          throw py::value_error("particles() must return two arrays of shape (n, 3): displacements, m, and velocities, m/s");
        for (py::ssize_t i = 0; i < rows.shape(0); ++i) vectors->push_back(vector_of(rows.data(i, 0)));
      }
      return state;
    });
  }
  void reset() override {
    guarded(part_.error(), [&] { part_.call("reset"); });
  }

 private:
  Part part_;
  int tools_;
  SolverCapabilities has_;
};

/// The hand and the motors of a simulated device, for as long as the device is there.
struct Grip {
  SimulatedGrip* grip;
  SimulatedGrip& there() const {
    if (grip == nullptr) throw py::value_error("the run is over, and the grip with it; read what you need before that");
    return *grip;
  }
};

class PythonDevice final : public HapticDevice {
 public:
  PythonDevice(Part part, std::shared_ptr<Grip> grip) : part_(std::move(part)), grip_(std::move(grip)) {}
  ~PythonDevice() override { grip_->grip = nullptr; }
  DeviceSample read(RealTime now) override {
    return guarded(part_.error(), [&] {
      const py::object position = part_.call("read", now.ns);
      last_.fresh = !position.is_none();
      if (last_.fresh) last_.position_m = vector_of(doubles_of(position, {3}, "read() returned").data());
      return last_;
    });
  }
  void write(const glm::dvec3& force_N) override {
    guarded(part_.error(), [&] { part_.call("write", row_of(force_N)); });
  }
  void stop() noexcept override {
    try {
      guarded(part_.error(), [&] { part_.call("stop"); });
    } catch (const std::exception&) {  // the run looks whether the motors still drive
    }
  }

 private:
  Part part_;
  std::shared_ptr<Grip> grip_;
  DeviceSample last_;
};

class PythonMap final : public ForeignMap {
 public:
  explicit PythonMap(Part part) : part_(std::move(part)), begins_(part_.has("began")), ends_(part_.has("ended")) {}
  void boundary(std::int64_t n, RealTime begin) override {
    guarded(part_.error(), [&] { part_.call("boundary", n, begin.ns); });
  }
  void began(std::int64_t n, RealTime at) override {
    if (begins_) guarded(part_.error(), [&] { part_.call("began", n, at.ns); });
  }
  void ended(std::int64_t n, RealTime at) override {
    if (ends_) guarded(part_.error(), [&] { part_.call("ended", n, at.ns); });
  }
  std::optional<RealTime> slot(std::int64_t n) override {
    return guarded(part_.error(), [&]() -> std::optional<RealTime> {
      const py::object at = part_.call("slot", n);
      if (at.is_none()) return std::nullopt;
      return RealTime{ns_of(at)};
    });
  }

 private:
  Part part_;
  bool begins_, ends_;
};

Interval interval_of(py::handle pair) {
  const py::sequence both = py::reinterpret_borrow<py::sequence>(pair);
  return {{ns_of(both[0])}, {ns_of(both[1])}};
}

class PythonTiming final : public StepTiming {
 public:
  explicit PythonTiming(Part part) : part_(std::move(part)), segments_(hold(py::iter(part_.object()))) {}
  bool next(SegmentTiming& segment) override {
    return guarded(part_.error(), [&] {
      const py::object given = py::module_::import("builtins").attr("next")(*segments_, py::none());
      if (given.is_none()) return false;
      segment = {};
      segment.begin = {ns_of(given.attr("begin_ns"))};
      const py::object visualization = given.attr("visualization");
      if (!visualization.is_none()) segment.visualization = interval_of(visualization);
      for (const py::handle step : given.attr("steps")) segment.steps.push_back(interval_of(step));
      segment.end = segment.visualization ? segment.visualization->end : segment.begin;
      if (!segment.steps.empty()) segment.end = std::max(segment.end, segment.steps.back().end);
      return true;
    });
  }

 private:
  Part part_;
  Held segments_;
};

template <class Make>
void each(const py::dict& given, const char* kind, Make make) {
  if (!given.contains(kind)) return;
  for (const auto& [name, callable] : py::cast<py::dict>(given[kind]))
    make(py::cast<std::string>(name), hold(py::reinterpret_borrow<py::object>(callable)));
}

}  // namespace

void define_parts(py::module_& module) {
  py::class_<Grip, std::shared_ptr<Grip>>(module, "Grip")
      .def("hand_m", [](const Grip& grip) { return row_of(grip.there().hand_m()); })
      .def("drive", [](const Grip& grip, py::handle force_N) {
        grip.there().drive(vector_of(doubles_of(force_N, {3}, "the force is").data()));
      });
}

Registry registry_of(const py::dict& given, const Error& error) {
  Registry registry;
  each(given, "solver", [&](const std::string& name, const Held& make) {
    registry.add_solver(name, [make, error](const SolverRequest& wanted) -> std::unique_ptr<ForeignSolver> {
      return guarded(error, [&] {
        const py::dict more(py::arg("step_s") = wanted.step_s, py::arg("tool_count") = wanted.tool_count,
                            py::arg("variable_step") = wanted.variable_step);
        return std::make_unique<PythonSolver>(Part(make, request(wanted.name, wanted.options, wanted.seed, more), error),
                                              wanted.tool_count);
      });
    });
  });
  each(given, "device", [&](const std::string& name, const Held& make) {
    registry.add_device(name, [make, error](const DeviceRequest& wanted) -> std::unique_ptr<HapticDevice> {
      return guarded(error, [&] {
        const auto grip = std::make_shared<Grip>(Grip{wanted.grip});
        const py::dict more(py::arg("device") = wanted.device,
                            py::arg("rate_Hz") = py::make_tuple(wanted.rate.num, wanted.rate.den),
                            py::arg("first_tick_ns") = wanted.first_tick.ns, py::arg("grip") = grip);
        return std::make_unique<PythonDevice>(Part(make, request(wanted.name, wanted.options, wanted.seed, more), error),
                                              grip);
      });
    });
  });
  each(given, "map", [&](const std::string& name, const Held& make) {
    registry.add_map(name, [make, error](const MapRequest& wanted) -> std::unique_ptr<ForeignMap> {
      return guarded(error, [&] {
        const py::dict more(py::arg("step_rate_Hz") = py::make_tuple(wanted.step_rate.num, wanted.step_rate.den));
        return std::make_unique<PythonMap>(Part(make, request(wanted.name, wanted.options, wanted.seed, more), error));
      });
    });
  });
  each(given, "timing", [&](const std::string& name, const Held& make) {
    registry.add_timing(name, [make, error](const TimingRequest& wanted) -> std::unique_ptr<StepTiming> {
      return guarded(error, [&] {
        return std::make_unique<PythonTiming>(
            Part(make, request(wanted.name, wanted.options, wanted.seed, py::dict()), error));
      });
    });
  });
  return registry;
}

}  // namespace evenstep::python
