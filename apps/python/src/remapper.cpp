// Remapper: evenstep_remap.h, which checks every argument, with arrays of numpy. No call releases the GIL, because none
// waits: releasing it would take longer than the call.

#include <fmt/format.h>

#include "common.h"
#include "remapper.h"

namespace evenstep::python {
namespace {

void check(int code) {
  if (code == EVENSTEP_REMAP_OK) return;
  const std::string message = evenstep_remap_last_error();
  if (code == EVENSTEP_REMAP_MEMORY) throw std::bad_alloc();
  raise(code == EVENSTEP_REMAP_ORDER ? "OrderError" : "ArgumentError", message);
}

const char* status_of(std::uint32_t status) {
  constexpr const char* kNames[] = {"inside", "underrun", "overrun", "empty"};
  return status < 4 ? kNames[status] : "unknown";
}

/// The integer, which may be a time, of the option, or what it was initialized with.
template <class Number>
void take_time(const py::dict& options, const char* name, Number& number) {
  if (options.contains(name)) number = static_cast<Number>(ns_of(options[name]));
}

const std::vector<const char*> kOptions = {
    "components",         "emission",        "bandwidth_Hz",      "sample_capacity", "force_capacity", "sample_window_ns",
    "sample_furthest_ns", "force_window_ns", "force_furthest_ns", "adapt",           "steps_per_s"};

evenstep_remap* make(py::handle lead, py::handle latency, const py::dict& given) {
  for (const auto& [key, value] : given) {
    const auto name = py::cast<std::string>(key);
    if (std::find(kOptions.begin(), kOptions.end(), name) == kOptions.end())
      throw py::type_error(fmt::format("Remapper has no option '{}'; it has {}", name, fmt::join(kOptions, ", ")));
  }
  evenstep_remap_options options;
  check(evenstep_remap_options_init(&options, sizeof options));
  options.lead_ns = ns_of(lead);
  options.latency_ns = ns_of(latency);
  take_time(given, "components", options.components);
  take_time(given, "sample_capacity", options.sample_capacity);
  take_time(given, "force_capacity", options.force_capacity);
  take_time(given, "sample_window_ns", options.sample_window_ns);
  take_time(given, "sample_furthest_ns", options.sample_furthest_ns);
  take_time(given, "force_window_ns", options.force_window_ns);
  take_time(given, "force_furthest_ns", options.force_furthest_ns);
  if (given.contains("bandwidth_Hz")) options.bandwidth_Hz = py::cast<double>(given["bandwidth_Hz"]);
  if (given.contains("emission")) {
    const auto word = py::cast<std::string>(given["emission"]);
    if (word != "linear" && word != "hold")
      raise("ArgumentError", fmt::format("emission is '{}'; write \"linear\" or \"hold\"", word));
    options.emission = word == "hold" ? EVENSTEP_REMAP_HOLD : EVENSTEP_REMAP_LINEAR;
  }
  if (given.contains("adapt")) {
    const py::dict adapt = given["adapt"];
    options.adapts = 1;
    take_time(adapt, "start_ns", options.adapt_start_ns);
    take_time(adapt, "least_ns", options.adapt_least_ns);
    take_time(adapt, "most_ns", options.adapt_most_ns);
    take_time(adapt, "window_ns", options.adapt_window_ns);
    take_time(adapt, "margin_ns", options.adapt_margin_ns);
    take_time(adapt, "slew_ppm", options.adapt_slew_ppm);
  }
  evenstep_remap* remap = nullptr;
  if (!given.contains("steps_per_s")) {
    check(evenstep_remap_create(&options, &remap));
    return remap;
  }
  evenstep_remap_clock clock{};
  clock.struct_size = sizeof clock;
  clock.steps = ns_of(given["steps_per_s"]);
  clock.seconds = 1;
  check(evenstep_remap_create_clocked(&options, &clock, &remap));
  return remap;
}

std::size_t components_of(const py::dict& options) {
  return options.contains("components") ? static_cast<std::size_t>(ns_of(options["components"])) : 3;
}

struct Reading {
  Doubles value;
  std::string status;
};

struct StepInput {
  Doubles position;
  std::string status;
  std::int64_t read_ns, newest_ns;
  bool has_slot;
};

py::dict counts_of(const RemapHandle& remap) {
  evenstep_remap_counts counts{};
  counts.struct_size = sizeof counts;
  check(evenstep_remap_get_counts(remap.get(), &counts));
  const auto reads = [](auto inside, auto held, auto extrapolated, auto overruns, auto empty) {
    return py::dict(py::arg("inside") = inside, py::arg("held") = held, py::arg("extrapolated") = extrapolated,
                    py::arg("overruns") = overruns, py::arg("empty") = empty);
  };
  return py::dict(py::arg("steps") = counts.steps, py::arg("acquiring") = counts.acquiring,
                  py::arg("late_forces") = counts.late_forces, py::arg("latest_force_ns") = counts.latest_force_ns,
                  py::arg("hand") = reads(counts.hand_inside, counts.hand_held, counts.hand_extrapolated,
                                          counts.hand_overruns, counts.hand_empty),
                  py::arg("force") = reads(counts.force_inside, counts.force_held, counts.force_extrapolated,
                                           counts.force_overruns, counts.force_empty));
}

}  // namespace

RemapHandle::RemapHandle(py::handle lead, py::handle latency, const py::dict& options)
    : remap_(make(lead, latency, options)), components_(components_of(options)) {}

void RemapHandle::sample(std::int64_t now_ns, const double* position) {
  if (evenstep_remap_sample(remap_.get(), now_ns, position) != EVENSTEP_REMAP_OK)
    throw std::runtime_error(evenstep_remap_last_error());
}

void RemapHandle::force(std::int64_t now_ns, double* force) {
  if (evenstep_remap_force(remap_.get(), now_ns, force, nullptr) != EVENSTEP_REMAP_OK)
    throw std::runtime_error(evenstep_remap_last_error());
}

void define_remapper(py::module_& module) {
  py::class_<Reading>(module, "Reading").def_readonly("value", &Reading::value).def_readonly("status", &Reading::status);
  py::class_<StepInput>(module, "StepInput")
      .def_readonly("position", &StepInput::position)
      .def_readonly("status", &StepInput::status)
      .def_readonly("read_ns", &StepInput::read_ns)
      .def_readonly("newest_ns", &StepInput::newest_ns)
      .def_readonly("has_slot", &StepInput::has_slot);
  const auto row = [](const RemapHandle& remap) { return Doubles(static_cast<py::ssize_t>(remap.components())); };
  const auto given = [](const RemapHandle& remap, py::handle value, const char* what) {
    return doubles_of(value, {static_cast<py::ssize_t>(remap.components())}, what);
  };
  py::class_<RemapHandle, std::shared_ptr<RemapHandle>>(module, "Remapper")
      .def(py::init([](const py::object& lead, const py::object& latency, const py::kwargs& options) {
             return std::make_shared<RemapHandle>(lead, latency, options);
           }),
           py::kw_only(), py::arg("lead"), py::arg("latency"))
      .def_property_readonly("components", &RemapHandle::components)
      .def(
          "sample",
          [given](RemapHandle& remap, py::handle now, py::handle position) {
            const Doubles values = given(remap, position, "the position is");
            check(evenstep_remap_sample(remap.get(), ns_of(now), values.data()));
          },
          py::arg("now"), py::arg("position"))
      .def(
          "force",
          [row](RemapHandle& remap, py::handle now) {
            Reading reading{row(remap), ""};
            std::uint32_t status = 0;
            check(evenstep_remap_force(remap.get(), ns_of(now), reading.value.mutable_data(), &status));
            reading.status = status_of(status);
            return reading;
          },
          py::arg("now"))
      .def(
          "segment", [](RemapHandle& remap, py::handle begin) { check(evenstep_remap_segment(remap.get(), ns_of(begin))); },
          py::arg("begin"))
      .def(
          "begin_step",
          [row](RemapHandle& remap, py::handle now, const py::object& simulated) {
            evenstep_remap_read read{};
            read.struct_size = sizeof read;
            Doubles position = row(remap);
            check(simulated.is_none() ? evenstep_remap_begin_step(remap.get(), ns_of(now), position.mutable_data(), &read)
                                      : evenstep_remap_begin_step_at(remap.get(), ns_of(now), ns_of(simulated),
                                                                     position.mutable_data(), &read));
            return StepInput{position, status_of(read.status), read.read_ns, read.newest_ns, read.has_slot != 0};
          },
          py::arg("now"), py::arg("simulated") = py::none())
      .def(
          "end_step",
          [given](RemapHandle& remap, py::handle now, py::handle force) {
            const Doubles values = given(remap, force, "the force is");
            std::int64_t emission_ns = 0;
            check(evenstep_remap_end_step(remap.get(), ns_of(now), values.data(), &emission_ns));
            return emission_ns;
          },
          py::arg("now"), py::arg("force"))
      .def("counts", &counts_of);
}

}  // namespace evenstep::python
