#pragma once
/// The paths that every sample, step and event takes, one object each: the same work is timed by bench_core_paths and
/// counted in instructions by count_instructions.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace evenstep::bench {

class CorePath {
 public:
  virtual ~CorePath() = default;
  /// Does the path `count` times. What it makes is used, so that nothing of it is left out by the compiler.
  virtual void run(std::int64_t count) = 0;
};

std::vector<std::string> core_path_names();
/// nullptr for a name that is not one of them.
std::unique_ptr<CorePath> make_core_path(const std::string& name);

}  // namespace evenstep::bench
