#pragma once
/// What all parts of the Python module share: holding Python objects outside the GIL, times, arrays, and errors.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <atomic>
#include <csignal>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "evenstep/scheduler/scheduler.h"
#include "evenstep/text/diagnostic.h"

namespace evenstep::python {
namespace py = pybind11;

/// A Python object that C++ may copy and drop without holding the GIL.
using Held = std::shared_ptr<py::object>;
Held hold(py::object object);

/// Nanoseconds of an int or a numpy.timedelta64. A float is refused: it would hide which clock it is from.
std::int64_t ns_of(py::handle time);

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
/// `given` as a C-contiguous array of exactly this shape; py::value_error says what it is instead. `what`: "step()
/// returned".
Doubles doubles_of(py::handle given, const std::vector<py::ssize_t>& shape, const std::string& what);

/// The JSON text as Python objects.
py::object json_loads(const std::string& text);

/// Raises evenstep.NAME(message, errors, remedy, run).
[[noreturn]] void raise(const char* name, const std::string& message, const std::vector<Diagnostic>& errors = {},
                        const std::string& remedy = "", const py::object& run = py::none(),
                        const py::object& cause = py::none());
[[noreturn]] void raise(const std::vector<Diagnostic>& errors);  ///< ScenarioError

/// Warns, if there is something to warn of; raises if the program turns warnings into errors.
void warn(const std::string& file, const std::string& damage);

/// The first Python exception that left a part, kept until the run is over.
class FirstError {
 public:
  /// Call with the GIL. Returns the exception for C++, with type, message and place of the Python one.
  std::runtime_error keep(const py::error_already_set& error);
  py::object value() const { return first_ ? *first_ : py::object(py::none()); }

 private:
  Held first_;
};

/// While this lives, Ctrl-C in the main thread sets `interrupted()`, stops `scheduler` if there is one, and does what Python
/// does by itself, too. In other threads it does nothing, as Ctrl-C is the main thread's.
class Interruptible {
 public:
  explicit Interruptible(Scheduler* scheduler = nullptr);
  ~Interruptible();
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;
  const std::atomic<bool>* interrupted() const { return &flag_; }
  /// With the GIL: raises KeyboardInterrupt (or what the program's own handler raises) if there was one.
  void raise_if() const;

 private:
  static void on_signal(int signal);
  std::atomic<bool> flag_{false};
  Scheduler* scheduler_;
  Interruptible* outer_ = nullptr;
  bool installed_ = false;
  struct sigaction before_ {};
};

void define_runs(py::module_& module);
void define_remapper(py::module_& module);
void define_clock(py::module_& module);

}  // namespace evenstep::python
