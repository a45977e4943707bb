#pragma once
/// The reason why a run stopped before its end.

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

namespace evenstep {

struct StrategyRecord;

/// The worst of all reasons: the motors of a simulated device still render a force after the run.
inline constexpr const char* kStillDriving = "still-driving";

/// A run that could not go on (solver, device, limit) or left a device driving. `reason` is one of the words that
/// [expect_stop] accepts, or one that no scenario can expect.
class RunFailure : public std::runtime_error {
 public:
  RunFailure(std::string why, const std::string& what, std::string cure, std::int64_t at_step = -1)
      : std::runtime_error(what), reason(std::move(why)), remedy(std::move(cure)), step(at_step) {}
  std::string
      reason;  ///< "unstable-step", "diverged", "bad-input", "device", "interrupted"; "solver", "limit", kStillDriving
  std::string remedy;
  std::int64_t step;  ///< the step in which the run stopped, counted from 0; -1: before the first one
  std::shared_ptr<StrategyRecord> so_far = nullptr;  ///< what was recorded until then, if anything
};

}  // namespace evenstep
