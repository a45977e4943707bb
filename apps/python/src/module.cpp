// The extension module evenstep._core. Its users are the Python sources in apps/python/evenstep, which say what it all
// means.

#include <spdlog/spdlog.h>

#include "common.h"
#include "parts.h"

PYBIND11_MODULE(_core, module) {
  spdlog::set_level(spdlog::level::err);  // what is worth a warning of the program's is in the results
  evenstep::python::define_parts(module);
  evenstep::python::define_runs(module);
  evenstep::python::define_remapper(module);
  evenstep::python::define_clock(module);
}
