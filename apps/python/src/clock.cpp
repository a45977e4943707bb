// VirtualClock: the scheduler with its virtual clock, for coroutines and loops of Python, and for a lane of C++ beside them.

#include <fmt/format.h>

#include <set>

#include "common.h"
#include "evenstep/clock/virtual_clock.h"
#include "evenstep/scheduler/scheduler.h"
#include "evenstep/scheduler/stepped_thread.h"
#include "remapper.h"

namespace evenstep::python {
namespace {

Lane lane_of(const std::string& word) {
  for (const Lane lane : {Lane::completion, Lane::device, Lane::launch})
    if (word == lane_name(lane)) return lane;
  throw py::value_error("lane is '" + word + "'; there are completion, device and launch");
}

/// Work for `external`: a callable, which runs where the step begins; its result is handed over where the step ends.
class PythonWork final : public Work {
 public:
  explicit PythonWork(py::object callable) : callable_(hold(std::move(callable))) {}
  void run() override {
    const py::gil_scoped_acquire gil;
    try {
      result_ = hold((*callable_)());
    } catch (const py::error_already_set& error) {
      error_ = hold(error.value());
    }
  }
  const Held& result() const { return result_; }
  const Held& error() const { return error_; }

 private:
  Held callable_, result_, error_;
};

/// What a coroutine awaits.
struct Wait {
  RealTime at;
  Lane lane = Lane::launch;
  EventName name;
  std::shared_ptr<PythonWork> work;  ///< of `external`
  bool is_external = false;
};

class PythonClock {
 public:
  explicit PythonClock(std::optional<std::uint64_t> permute_ties)
      : scheduler_(std::make_unique<Scheduler>(clock_, executor_, SchedulerOptions{.permute_ties = permute_ties})) {}
  ~PythonClock() { close(); }
  void close() {
    if (running_) throw std::logic_error("close() is called by what runs under this clock; call it after run()");
    const py::gil_scoped_release without_gil;  // loops are ended, and they need it for that
    threads_.clear();
    scheduler_.reset();
  }

  Scheduler& scheduler() {
    if (!scheduler_) throw std::logic_error("the clock is closed");
    return *scheduler_;
  }
  FirstError& error() { return error_; }
  /// The name as that of an event; its text lives as long as the clock.
  EventName event(const std::string& name) {
    EventName event;
    event.text = names_.insert(name).first->c_str();
    event.digest = name_digest(name);
    return event;
  }
  void keep(std::unique_ptr<SteppedThread> thread) { threads_.push_back(std::move(thread)); }
  void note(py::handle value) {
    if (!running_) throw std::logic_error("note() belongs into an event: after the first await");
    const Doubles numbers = Doubles::ensure(value);
    if (!numbers) throw py::error_already_set();
    for (py::ssize_t i = 0; i < numbers.size(); ++i) scheduler().note(numbers.data()[i]);
  }
  std::string run(RealTime end) {
    if (running_) throw std::logic_error("run() is running already: a coroutine awaits instead");
    RunStatus status;
    {
      const Interruptible interruptible(&scheduler());
      running_ = true;
      {
        const py::gil_scoped_release without_gil;
        status = scheduler_->run(end);
      }
      running_ = false;
      interruptible.raise_if();
    }
    if (status.end == RunEnd::failed && !error_.value().is_none()) {
      const py::object value = error_.value();
      PyErr_SetObject(py::type::of(value).ptr(), value.ptr());
      throw py::error_already_set();
    }
    if (status.end == RunEnd::failed || status.end == RunEnd::limit) raise("RunFailed", status.message);
    return status.end == RunEnd::idle ? "idle" : status.end == RunEnd::stopped ? "stopped" : "reached_end";
  }

 private:
  VirtualClock clock_;
  InlineExecutor executor_;
  std::set<std::string> names_;
  FirstError error_;
  bool running_ = false;
  std::unique_ptr<Scheduler> scheduler_;
  std::vector<std::unique_ptr<SteppedThread>> threads_;
};

/// Lets the coroutine go on to its next await. Empty: it has returned.
std::optional<Wait> resume(PythonClock& clock, const Held& coroutine, const std::optional<Wait>& before) {
  const py::gil_scoped_acquire gil;
  try {
    if (before && before->work && before->work->error())
      return py::cast<Wait>(coroutine->attr("throw")(*before->work->error()));
    const py::object answer = !before        ? py::object(py::none())
                              : before->work ? *before->work->result()
                                             : py::object(py::int_(clock.scheduler().now().ns));
    return py::cast<Wait>(coroutine->attr("send")(answer));
  } catch (const py::error_already_set& error) {
    if (error.matches(PyExc_StopIteration)) return std::nullopt;
    throw clock.error().keep(error);
  } catch (const py::cast_error&) {
    throw std::runtime_error("a coroutine awaits something that is no wait of this clock: await clock.until(t)");
  }
}

Task coroutine_lane(PythonClock& clock, Held coroutine) {
  std::optional<Wait> wait = resume(clock, coroutine, std::nullopt);
  while (wait) {
    if (wait->is_external) {
      co_await clock.scheduler().external(wait->at, wait->work.get(), wait->name);
    } else {
      co_await clock.scheduler().until(wait->at, wait->lane, wait->name);
    }
    wait = resume(clock, coroutine, wait);
  }
}

/// A device in C++: at each tick it gives a row of `positions` to the remapper and keeps the force in the row of `forces`.
struct DeviceLane {
  std::shared_ptr<RemapHandle> remap;
  Rate rate;
  RealTime origin;
  const double* positions;
  double* forces;
  std::int64_t ticks;
  Held owner;  ///< of both arrays
};
Task device_lane(Scheduler& scheduler, DeviceLane device, EventName name) {
  const std::size_t components = device.remap->components();
  for (std::int64_t k = 0; k < device.ticks; ++k) {
    co_await scheduler.until(tick_time(device.rate, k, device.origin), Lane::device, name);
    const std::size_t row = static_cast<std::size_t>(k) * components;
    device.remap->sample(scheduler.now().ns, device.positions + row);
    device.remap->force(scheduler.now().ns, device.forces + row);
    for (std::size_t i = 0; i < components; ++i) scheduler.note(device.forces[row + i]);
  }
}

py::array start_device(PythonClock& clock, std::shared_ptr<RemapHandle> remap, std::pair<std::int64_t, std::int64_t> rate_Hz,
                       py::handle given, py::handle origin, const std::string& name) {
  const auto components = static_cast<py::ssize_t>(remap->components());
  const py::ssize_t ticks = py::len(given);
  Doubles positions = doubles_of(given, {ticks, components}, "positions are");
  Doubles forces({ticks, components});
  std::fill_n(forces.mutable_data(), forces.size(), 0.0);
  if (rate_Hz.first <= 0 || rate_Hz.second <= 0)
    throw py::value_error("rate_Hz is (ticks, seconds), both above 0: (1000, 1)");
  DeviceLane device{std::move(remap),
                    {rate_Hz.first, rate_Hz.second},
                    {ns_of(origin)},
                    positions.data(),
                    forces.mutable_data(),
                    ticks,
                    hold(py::make_tuple(positions, forces))};
  clock.scheduler().spawn(device_lane(clock.scheduler(), std::move(device), clock.event(name)));
  return forces;
}

/// The clock of a loop that blocks.
struct LoopTime {
  BlockingClock* clock;
};

void start_loop(PythonClock& clock, py::object loop, const std::string& name, const std::string& lane) {
  const Held held = hold(std::move(loop));
  PythonClock* const owner = &clock;
  const SteppedThreadOptions options{.name = clock.event(name), .lane = lane_of(lane)};
  const auto body = [held, owner](BlockingClock& time) {
    const py::gil_scoped_acquire gil;
    const auto given = std::make_shared<LoopTime>(LoopTime{&time});
    try {
      (*held)(given);
    } catch (const py::error_already_set& error) {
      given->clock = nullptr;
      if (error.matches(py::module_::import("evenstep._errors").attr("Stopped"))) throw Stopped{};
      throw owner->error().keep(error);
    }
    given->clock = nullptr;
  };
  const py::gil_scoped_release without_gil;  // it runs up to its first sleep
  clock.keep(std::make_unique<SteppedThread>(clock.scheduler(), options, body));
}

BlockingClock& there(const LoopTime& time) {
  if (time.clock == nullptr) throw py::value_error("the loop is over, and its clock with it");
  return *time.clock;
}

void sleep(const LoopTime& time, py::handle at, const py::object& lane) {
  BlockingClock& clock = there(time);
  const RealTime until{ns_of(at)};
  const std::optional<Lane> in = lane.is_none() ? std::nullopt : std::optional(lane_of(py::cast<std::string>(lane)));
  bool stopped = false;
  {
    const py::gil_scoped_release without_gil;
    try {
      in ? clock.sleep_until(until, *in) : clock.sleep_until(until);
    } catch (const Stopped&) {
      stopped = true;
    }
  }
  if (stopped) raise("Stopped", "the run is over");
}

}  // namespace

void define_clock(py::module_& module) {
  py::class_<Wait>(module, "Wait");
  py::class_<LoopTime, std::shared_ptr<LoopTime>>(module, "LoopTime")
      .def_property_readonly("now_ns", [](const LoopTime& time) { return there(time).now().ns; })
      .def("sleep_until", &sleep, py::arg("at"), py::arg("lane") = py::none());
  py::class_<PythonClock>(module, "Clock")
      .def(py::init<std::optional<std::uint64_t>>(), py::arg("permute_ties") = py::none())
      .def_property_readonly("now_ns", [](PythonClock& clock) { return clock.scheduler().now().ns; })
      .def_property_readonly("trace_hash",
                             [](PythonClock& clock) { return fmt::format("{:016x}", clock.scheduler().trace_hash()); })
      .def("events",
           [](PythonClock& clock) {
             py::list events;
             for (const Event& event : clock.scheduler().events())
               events.append(py::make_tuple(event.time.ns, lane_name(event.lane), event.name.text));
             return events;
           })
      .def("wait_until",
           [](PythonClock& clock, py::handle at, const std::string& lane, const std::string& name) {
             return Wait{{ns_of(at)}, lane_of(lane), clock.event(name), nullptr, false};
           })
      .def("wait_for",
           [](PythonClock& clock, py::handle end, const py::object& work, const std::string& name) {
             auto started = work.is_none() ? nullptr : std::make_shared<PythonWork>(work);
             return Wait{{ns_of(end)}, Lane::completion, clock.event(name), std::move(started), true};
           })
      .def("spawn", [](PythonClock& clock,
                       py::object coroutine) { clock.scheduler().spawn(coroutine_lane(clock, hold(std::move(coroutine)))); })
      .def("device", &start_device)
      .def("loop", &start_loop)
      .def("note", &PythonClock::note)
      .def("close", &PythonClock::close)
      .def("run", [](PythonClock& clock, py::handle end) { return clock.run({ns_of(end)}); });
}

}  // namespace evenstep::python
