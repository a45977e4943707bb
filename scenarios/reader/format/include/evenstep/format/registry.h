#pragma once
/// The parts that a program brings along, by name. A scenario names them, and every command runs with them:
///
///   int main(int argc, char** argv) {
///     evenstep::Registry registry = evenstep::builtin();
///     registry.add_solver("my-tissue", [](const evenstep::SolverRequest& request) {
///       return std::make_unique<MySolver>(request);
///     });
///     return evenstep::command_line(argc, argv, registry);
///   }
///
/// A registry is passed as an argument; there is no global one. The reader puts the factory of each part that a scenario
/// names into the Scenario, so nothing after it looks up a name. Factories are called by several threads at once.

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "evenstep/device/foreign_device.h"
#include "evenstep/remap/foreign_map.h"
#include "evenstep/scheduler/foreign_timing.h"
#include "evenstep/sim/foreign_solver.h"

namespace evenstep {

class Registry {
 public:
  /// Each throws std::invalid_argument for an empty name, an empty function or a name that a part of the same kind already
  /// has.
  void add_solver(const std::string& name, SolverFactory make) { add(solvers_, "solver", name, std::move(make)); }
  void add_device(const std::string& name, DeviceFactory make) { add(devices_, "device", name, std::move(make)); }
  void add_map(const std::string& name, MapFactory make) { add(maps_, "map", name, std::move(make)); }
  void add_timing(const std::string& name, TimingFactory make) { add(timings_, "timing source", name, std::move(make)); }

  using Solvers = std::map<std::string, SolverFactory, std::less<>>;
  using Devices = std::map<std::string, DeviceFactory, std::less<>>;
  using Maps = std::map<std::string, MapFactory, std::less<>>;
  using Timings = std::map<std::string, TimingFactory, std::less<>>;
  const Solvers& solvers() const { return solvers_; }
  const Devices& devices() const { return devices_; }
  const Maps& maps() const { return maps_; }
  const Timings& timings() const { return timings_; }

 private:
  static void check(const char* kind, const std::string& name, bool can_be_made, bool is_taken);
  template <class Parts, class Make>
  static void add(Parts& parts, const char* kind, const std::string& name, Make make) {
    check(kind, name, static_cast<bool>(make), parts.contains(name));
    parts.emplace(name, std::move(make));
  }

  Solvers solvers_;
  Devices devices_;
  Maps maps_;
  Timings timings_;
};

/// The registry of the program `evenstep`. It is empty, because evenstep's own parts have words of their own in a scenario
/// and need no entry.
inline Registry builtin() { return {}; }

}  // namespace evenstep
