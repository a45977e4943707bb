#include "common.h"

#include <fmt/format.h>

namespace evenstep::python {

Held hold(py::object object) {
  return {new py::object(std::move(object)), [](py::object* held) {
            const py::gil_scoped_acquire gil;
            delete held;
          }};
}

std::int64_t ns_of(py::handle time) {
  if (PyLong_Check(time.ptr())) {
    const long long ns = PyLong_AsLongLong(time.ptr());
    if (ns == -1 && PyErr_Occurred() != nullptr) throw py::error_already_set();
    return ns;
  }
  if (py::hasattr(time, "dtype")) {  // numpy: its integers, and timedelta64 in whatever unit
    const auto kind = py::cast<std::string>(time.attr("dtype").attr("kind"));
    if (kind == "i" || kind == "u") return py::cast<std::int64_t>(py::int_(py::reinterpret_borrow<py::object>(time)));
    if (kind == "m")
      return py::cast<std::int64_t>(time.attr("astype")("timedelta64[ns]").attr("astype")("int64").attr("item")());
  }
  throw py::type_error(fmt::format("a time is an int, in ns, or a numpy.timedelta64, not {}; 15 ms is 15_000_000",
                                   py::cast<std::string>(py::str(py::type::of(time).attr("__name__")))));
}

Doubles doubles_of(py::handle given, const std::vector<py::ssize_t>& shape, const std::string& what) {
  Doubles array = Doubles::ensure(given);
  if (!array) {
    PyErr_Clear();
    throw py::type_error(fmt::format("{} {}, which is no array of numbers", what, py::cast<std::string>(py::repr(given))));
  }
  const std::vector<py::ssize_t> has(array.shape(), array.shape() + array.ndim());
  if (has != shape)
    throw py::value_error(fmt::format("{} an array of shape {}, and the shape must be {}", what,
                                      py::cast<std::string>(py::repr(array.attr("shape"))),
                                      py::cast<std::string>(py::repr(py::tuple(py::cast(shape))))));
  return array;
}

py::object json_loads(const std::string& text) { return py::module_::import("json").attr("loads")(text); }

void raise(const char* name, const std::string& message, const std::vector<Diagnostic>& errors, const std::string& remedy,
           const py::object& run, const py::object& cause) {
  py::list places;
  for (const Diagnostic& error : errors) places.append(py::make_tuple(error.file, error.line, error.column, error.message));
  const py::object type = py::module_::import("evenstep._errors").attr(name);
  const py::object value = type(message, places, remedy, run);
  if (!cause.is_none()) value.attr("__cause__") = cause;
  PyErr_SetObject(type.ptr(), value.ptr());
  throw py::error_already_set();
}

void warn(const std::string& file, const std::string& damage) {
  if (damage.empty()) return;
  if (PyErr_WarnEx(PyExc_UserWarning, (file + ": " + damage).c_str(), 2) != 0) throw py::error_already_set();
}

void raise(const std::vector<Diagnostic>& errors) {
  std::string message;
  for (const Diagnostic& error : errors) message += (message.empty() ? "" : "\n") + text(error);
  raise("ScenarioError", message, errors);
}

std::runtime_error FirstError::keep(const py::error_already_set& error) {
  if (error.trace()) PyException_SetTraceback(error.value().ptr(), error.trace().ptr());
  if (!first_) first_ = hold(error.value());
  // Where it was raised: the last frame of the traceback.
  std::string place;
  py::object frame = error.trace() ? py::reinterpret_borrow<py::object>(error.trace()) : py::none();
  while (!frame.is_none() && !frame.attr("tb_next").is_none()) frame = frame.attr("tb_next");
  if (!frame.is_none())
    place = fmt::format(" ({}:{})", py::cast<std::string>(frame.attr("tb_frame").attr("f_code").attr("co_filename")),
                        py::cast<int>(frame.attr("tb_lineno")));
  return std::runtime_error(fmt::format("{}: {}{}", py::cast<std::string>(error.type().attr("__name__")),
                                        py::cast<std::string>(py::str(error.value())), place));
}

namespace {
std::atomic<Interruptible*> current{nullptr};
static_assert(std::atomic<Interruptible*>::is_always_lock_free, "read in a signal handler");
}  // namespace

Interruptible::Interruptible(Scheduler* scheduler) : scheduler_(scheduler) {
  const py::module_ threading = py::module_::import("threading");
  if (!threading.attr("current_thread")().is(threading.attr("main_thread")())) return;
  outer_ = current.exchange(this);
  struct sigaction ours {};
  ours.sa_handler = &Interruptible::on_signal;
  sigemptyset(&ours.sa_mask);
  sigaction(SIGINT, &ours, &before_);
  installed_ = true;
  if (before_.sa_handler == SIG_IGN) sigaction(SIGINT, &before_, nullptr);  // a program that wants none gets none
}

Interruptible::~Interruptible() {
  if (!installed_) return;
  sigaction(SIGINT, &before_, nullptr);
  current.store(outer_);
}

void Interruptible::on_signal(int signal) {
  Interruptible* const all = current.load();
  void (*python)(int) = SIG_DFL;
  for (Interruptible* one = all; one != nullptr; one = one->outer_) {  // a part can start a run of its own
    one->flag_.store(true);
    if (one->scheduler_ != nullptr) one->scheduler_->request_stop();
    python = one->before_.sa_handler;
  }
  if (python != SIG_DFL && python != SIG_IGN) python(signal);
}

void Interruptible::raise_if() const {
  if (!flag_.load()) return;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  PyErr_SetNone(PyExc_KeyboardInterrupt);  // Python's own was raised in a part, and ended that
  throw py::error_already_set();
}

}  // namespace evenstep::python
