#pragma once
/// A scenario's table made independent of its own [timing]: whatever recording is put in, the rest of it means the same.

#include <cstddef>
#include <string>
#include <vector>

#include "evenstep/format/document.h"

namespace evenstep::internal {

/// Only these strategies and this expectation; no [sweep] and [study]; times in nominal units ("8 segments") in nanoseconds,
/// and the step size as a rate, for both would follow the recording. A rate of underruns over many seeds becomes that of the
/// recording. `scenario`: what `document` reads as.
Value fixed_document(Value document, const Scenario& scenario, const std::vector<StrategyKind>& strategies,
                     std::size_t expectation);

/// Replays this file for so long.
void set_timing(Value& document, const std::string& trace, Duration duration);

}  // namespace evenstep::internal
