#pragma once
/// Makes the table of a scenario independent of its [timing], so that the rest of it means the same with any recording.

#include <cstddef>
#include <string>
#include <vector>

#include "evenstep/format/document.h"

namespace evenstep::internal {

/// The document with only these strategies and this expectation, and without [timing], [sweep] and [study]. Times in nominal
/// units ("8 segments") become nanoseconds, and the step size a rate, because both would otherwise change with the
/// recording. A rate of underruns over many seeds becomes that of the recording. `scenario` is what `document` reads as.
Value fixed_document(Value document, const Scenario& scenario, const std::vector<StrategyKind>& strategies,
                     std::size_t expectation);

/// Sets the timing to a replay of this file, and the duration of the run; faults that this no longer reaches are left out.
void set_timing(Value& document, const std::string& trace, Duration duration);

}  // namespace evenstep::internal
