#pragma once
/// `evenstep size --fits`: whether the latency, lead and rings that a program has are enough for a timing.

#include <optional>
#include <string>
#include <string_view>

#include "evenstep/format/scenario.h"
#include "evenstep/harness/run.h"
#include "evenstep/reports/size_record.h"
#include "evenstep/text/quantity.h"
#include "evenstep/time/time.h"

namespace evenstep {

/// What a program has: at least one of latency, lead and rings. And for what it has to be enough, if not for the recording.
struct SizeFits {
  std::optional<std::string> map;         ///< default: the one that strategy_to_use names
  std::optional<Duration> latency, lead;  ///< the lead may be negative
  std::optional<RingSizes> rings;         ///< entries
  std::string rate, per, confidence;      ///< as written, for the options of these names; may be empty
};

/// "latency 20 ms, lead 2 ms, rings 64 32, map clocked, per 1 h, confidence 95 %", in any order. The error says what is
/// wrong.
Result<SizeFits> parse_fits(std::string_view text);

/// The verdict as that of a run, for the places where runs are compared and listed: what is needed as metrics of
/// `sizing.buffers.<map>`, and what the program has as limits of it. It has no strategy.
RunOutcome fit_outcome(const SizeRecord& record);

}  // namespace evenstep
