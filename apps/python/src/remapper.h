#pragma once
/// The Remapper that a Python program has, also for lanes of C++ beside it.

#include "common.h"
#include "evenstep_remap.h"

namespace evenstep::python {

class RemapHandle {
 public:
  RemapHandle(py::handle lead, py::handle latency, const py::dict& options);
  evenstep_remap* get() const { return remap_.get(); }
  std::size_t components() const { return components_; }
  /// Of the device's thread, without Python; std::runtime_error says what was refused.
  void sample(std::int64_t now_ns, const double* position);
  void force(std::int64_t now_ns, double* force);

 private:
  struct Destroy {
    void operator()(evenstep_remap* remap) const { evenstep_remap_destroy(remap); }
  };
  std::unique_ptr<evenstep_remap, Destroy> remap_;
  std::size_t components_;
};

}  // namespace evenstep::python
