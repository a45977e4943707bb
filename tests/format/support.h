#pragma once
#include <string>

#include "evenstep/format/scenario.h"
#include "temporary_folder.h"

namespace evenstep::test {

using testing::TemporaryFolder;

/// Reads `text` as scenario.toml in a temporary folder.
ReadResult read_text(const std::string& text, const ReadOptions& options = {});
/// All errors, one per line, with file names cut to their last part.
std::string errors_of(const ReadResult& result);
/// Every value of a scenario except its file name and places, one per line. Two scenarios are equal if these texts are
/// equal.
std::string describe(const Scenario& scenario);

/// kSpring with [timing] replaced, and no warm-up.
std::string with_timing(const std::string& timing);

extern const char* const kSpring;  ///< this and the following are valid scenarios, one of each kind
extern const char* const kTissue;
extern const char* const kPid;

}  // namespace evenstep::test
