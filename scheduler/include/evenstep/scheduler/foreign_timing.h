#pragma once
/// A timing source of your own: where the segments and steps of a run come from, such as a model of your GPU or a file that
/// evenstep cannot read. It is asked for the whole run when a scenario is read; from then on it is a recording, so every
/// strategy, replay, sweep and shrink sees the same times.
///
///   class Even final : public evenstep::StepTiming {
///     bool next(evenstep::SegmentTiming& segment) override { ... fill in, see step_timing.h ...; return true; }
///   };
///   registry.add_timing("my-gpu", [](const evenstep::TimingRequest&) { return std::make_unique<Even>(); });

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "evenstep/scheduler/step_timing.h"
#include "evenstep/time/result.h"

namespace evenstep {

/// What a timing source is made for.
struct TimingRequest {
  std::string name;            ///< the name it is registered under
  std::string options = "{}";  ///< of [timing] foreign, as a JSON object, keys in alphabetical order; unread by evenstep
  std::uint64_t seed = 1;      ///< [run] seed: all that may be drawn at random follows from it
};

/// Makes a source; called twice for each scenario that is read, to check that both sources give the same times. Throws
/// std::exception if it cannot.
using TimingFactory = std::function<std::unique_ptr<StepTiming>(const TimingRequest& request)>;

/// The most segments and steps together that a source may give; a recording has the same limit.
inline constexpr std::size_t kMostDrawnPieces = 10'000'000;

/// The segments that begin before `end`, or all if the source ends earlier: at least one, with at least one step in all.
/// Segments are numbered from 0 whatever the source says. An error names the first segment that breaks what step_timing.h
/// asks for: the first begins at 0, and each later one after the one before; nothing ends before it begins; no step begins
/// before its segment or before the step before it has ended; a segment ends when the last thing in it does.
Result<std::vector<SegmentTiming>, std::string> draw_timing(StepTiming& source, RealTime end);
/// The first segment in which they differ, or -1.
std::int64_t first_unequal(const std::vector<SegmentTiming>& a, const std::vector<SegmentTiming>& b);

}  // namespace evenstep
