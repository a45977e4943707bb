#pragma once
/// The latency for a span of time that may be longer than the recording: with it, one segment in the span is late on average
/// (or the given rate of them, if that is more), at most, with the given confidence.
///
/// If the recording is long enough, this is the promise about a rate (trust.h). Otherwise a tail is fitted (tail.h). It
/// takes one number per segment: how far its lead and its delay are on the way from their median, 0, to the largest seen, 1,
/// whichever is farther. At the number x the lead is med a + x (max a - med a), and the delay likewise, so x = 1 is the size
/// of the recording, and a segment is late if its number is above x.

#include <span>

#include "evenstep/reports/size_record.h"
#include "rate.h"

namespace evenstep::internal {

/// Refused with a reason if the recording is not one process, if it has fewer than kLeastForTail independent segments, if no
/// tail fits, or if its shape is not bounded below kHeaviest.
inline constexpr std::int64_t kLeastForTail = 300;
SizePer size_per(std::span<const SegmentNeed> needs, const SizeTrust& trust, Duration span, double rate, double confidence);

}  // namespace evenstep::internal
