#pragma once
/// What if the pauses were shorter? A timing as it would have been with drawings in parts, with a budget for each, with
/// paced segments, or with a lane for the drawings; and what that costs. Pure: the same timing gives the same answer.
/// Text form, as `evenstep size --what-if` and `evenstep advise` take it, clauses in any order:
///
///   spread                      steps wait for their slots instead of following each other in a burst
///   split 2                     each drawing in 2 parts with steps between them
///   budget 20 ms [merge]        a pause of at most that: what is left of a drawing is drawn in the next pauses
///   budget 20 ms skip|hold      a drawing that would take longer is not made; its steps follow at once, or as usual
///   forecast 2                  of skip and hold: how many drawings back the governor looks (0: it knows the future)
///   pace 90 % | 33 ms | 30 Hz   segments keep to a grid: a percentile of the times that their work takes (not shorter than
///                               the grid that they keep to already), or a period
///   own-lane [1.3]              drawings in a lane of their own; steps that begin beside one take so many times as long
///
/// They are applied in the order split, budget, pace, spread. All but own-lane are what a frame governor does
/// (scheduler/frame_governor.h).
///
/// own-lane: no step waits for a drawing any more. Each drawing begins when it did, or when the drawing before it ends, and
/// takes as long as it did. The steps of a segment begin with it, in a burst; with spread, step n begins n mean slots of the
/// recording after the first segment. Either way a step begins no earlier than the one before it ends. So simulated time
/// does not get ahead of real time, and own-lane alone removes the drawing from a pause, not the waiting. It goes with no
/// other clause, because there is no pause for a drawing left.

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "evenstep/scheduler/frame_governor.h"
#include "evenstep/time/result.h"
#include "evenstep/time/time.h"

namespace evenstep {

struct WhatIf {
  int split = 1;
  std::optional<Duration> budget;
  OverBudget over_budget = OverBudget::merge;
  int forecast = 0;                       ///< drawings to look back; 0: a bound, as if the future were known
  std::optional<double> pace_percentile;  ///< in (0, 1]
  std::optional<Duration> pace;
  std::optional<double> own_lane;  ///< slow-down of steps, >= 1
  bool spread = false;

  friend bool operator==(const WhatIf&, const WhatIf&) = default;
};

/// "split 2, budget 20 ms hold". The error says what was expected.
Result<WhatIf> parse_what_if(std::string_view text);
/// The text that gives it again; "as it is" for one that changes nothing.
std::string text_of(const WhatIf& what_if);

/// The same change as a simulator can make it while it runs, without knowing what comes: forecasts look back (2 drawings if
/// nothing else was asked for), and a percentile is that of the segments that begin within the first 2 s. Empty if there is
/// no difference, or no simulator can do it (own-lane).
std::optional<WhatIf> causal(const WhatIf& what_if);

/// What the drawings and the simulated time cost. The length of a timing is from its first begin to the end of its last
/// step.
struct DrawingPrice {
  std::int64_t drawings = 0;          ///< finished ones
  std::int64_t left_out = 0;          ///< never begun
  std::int64_t over_budget = 0;       ///< pauses longer than the budget
  double drawings_per_s = 0;          ///< finished ones
  Duration longest_without_drawing;   ///< from one drawing's end to the next one's; the timing's two ends count, too
  Duration longest_drawing_pause;     ///< of steps, for a drawing or a part of one; 0 with a lane of their own
  double simulated_against_real = 1;  ///< steps per real time, as a multiple of that of the timing before
  Duration drawings_later;            ///< most by which a drawing begins later than it did; 0 unless there are as many
  double segments_lost = 0;           ///< by what share steps, and so segments, per real time are fewer than before; >= 0
};

struct WhatIfTiming {
  std::vector<SegmentTiming> segments;
  DrawingPrice price;
  std::optional<Duration> pace;  ///< the period that a percentile gave
  /// What gives these segments in a run, as [timing] governor. Empty: nothing changes, or no governor does it (own-lane, a
  /// forecast that knows the future, a budget above kMostGovernedBudget).
  std::optional<FrameGovernor> governor;
};
inline constexpr Duration kMostGovernedBudget{9'000'000'000};  ///< of [timing] governor

/// (Call it as evenstep::apply where the arguments may bring std::apply along.) `segments` with this change; the error says
/// why it has no meaning there. `causally`: a percentile of what begins within the first 2 s, see above.
Result<WhatIfTiming> apply(const WhatIf& what_if, std::span<const SegmentTiming> segments, bool causally = false);
/// The price of a timing that was `before` without the change.
DrawingPrice price_of(std::span<const SegmentTiming> segments, std::span<const SegmentTiming> before,
                      std::optional<Duration> budget = {});

}  // namespace evenstep
