#pragma once
/// `evenstep check` as a function: what is known of a scenario before it runs.

#include <string>
#include <vector>

#include "evenstep/format/scenario.h"
#include "evenstep/harness/run.h"

namespace evenstep {

struct Explained {
  ExitCode exit = ExitCode::pass;
  std::string json;                ///< the document of `evenstep check --json` (docs/reference/json.md)
  std::string damage;              ///< of the recording: what was merged, clipped or left out; usually empty
  std::vector<Diagnostic> errors;  ///< what is wrong with the scenario; they are in `json`, too
};
/// Reads and explains the scenario; runs nothing.
Explained explain_scenario(const std::string& file, const ReadOptions& options);

}  // namespace evenstep
