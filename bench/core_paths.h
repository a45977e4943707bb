#pragma once
/// The paths that every sample, step and event takes, as one object each. bench_core_paths measures the time of this work,
/// and count_instructions counts its instructions.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace evenstep::bench {

class CorePath {
 public:
  virtual ~CorePath() = default;
  /// Takes the path `count` times. Its results are used, so that the compiler leaves nothing out.
  virtual void run(std::int64_t count) = 0;
};

std::vector<std::string> core_path_names();
/// The path of this name; nullptr if there is none.
std::unique_ptr<CorePath> make_core_path(const std::string& name);

}  // namespace evenstep::bench
