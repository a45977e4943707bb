#pragma once
/// The program evenstep in a process of its own, with limits: a test sees how it ended, whatever it did.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/format/registry.h"

namespace evenstep::testing {

struct ProgramLimits {
  int interrupt_after_s = 20;                     ///< then it is interrupted as Ctrl-C does it,
  int end_after_s = 10;                           ///< and so much later killed
  std::size_t most_bytes = std::size_t{3} << 30;  ///< of memory; not in a sanitized build, whose shadow needs more
};

struct Ended {
  int exit_code = -1;  ///< -1: ended by a signal
  int signal = 0;
  std::string output;  ///< of stdout and stderr
  /// "exit code 2", "signal 6 (Aborted)", and the output.
  std::string text() const;
};

/// Runs `evenstep ARGUMENTS` in `folder`.
Ended run_program(const std::vector<std::string>& arguments, const std::string& folder, const Registry& registry = {},
                  const ProgramLimits& limits = {});

/// What `work` returns, 0 to 254, computed in a process of its own: a library that has made threads, such as PoCL, does not
/// survive that run_program forks later. Empty if it threw or ended in another way.
std::optional<int> in_own_process(const std::function<int()>& work);

}  // namespace evenstep::testing
