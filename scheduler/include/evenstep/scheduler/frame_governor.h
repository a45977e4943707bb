#pragma once
/// A frame governor: shortens the pauses that drawings make between steps, as a simulator can do it itself. It is a
/// StepTiming over another one, so that the sizing pass, a virtual run and a run on a wall clock see the same governed
/// schedule.
///
/// Every segment of the source becomes `split` = K opportunities to draw, with its N steps shared out between them:
/// opportunity j has steps N j/K to N (j + 1)/K, rounded down. Each opportunity is a segment of its own in the governed
/// schedule, because a map has to bridge each pause. A drawing that takes V is made in parts of V/K, rounded up to ns; the
/// last part is what is left. What one opportunity may draw:
///
///   no budget         a part
///   budget b, merge   at most b of a part; the rest is drawn in the next opportunities, at most b in each. A drawing that
///                     should begin before the rest is done is left out: one picture serves both segments. The pause in
///                     its place lasts at least as long as with `hold`
///   budget b, skip    parts, or nothing at all if a part is expected to take longer than b: the steps then follow at once,
///                     and simulated time gets ahead
///   budget b, hold    the same, but the pause is kept, as long as the mean of the last 8 parts drawn (at most b; b before
///                     the first), so that the steps keep their place
///
/// `merge` can cut a drawing off anywhere, so no pause is ever longer than b. `skip` and `hold` must know how long a drawing
/// will take before it begins. With `forecast` = m they expect the longest part of the last m drawings, where one that was
/// left out counts as 0; the first drawing is always made. So after at most m drawings that were left out the next one is
/// drawn, however long it takes. With `forecast` = 0 they know the length: a bound on what any forecast could do, for
/// what-ifs.
///
/// When the next opportunity begins. If the source runs freely: after the work before it and the same gap as in the source.
/// If the source keeps to a grid of period P: not before its turn, either. The turn of a segment is its begin in the source
/// if it waited there (the gap before it is longer than P / 100); otherwise it is the turn of the segment before plus P, or
/// its begin if that is earlier. Opportunity j of a segment has its turn j P/K later, so idle time is shared out, too. With
/// `pace` opportunity n has its turn at n pace / K after the first begin, whatever the source did.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "evenstep/scheduler/step_timing.h"

namespace evenstep {

enum class OverBudget { skip, hold, merge };

struct FrameGovernor {
  int split = 1;                               ///< K, 1 to 1000
  std::optional<Duration> budget;              ///< b, of a pause; > 0
  OverBudget over_budget = OverBudget::merge;  ///< what becomes of a drawing that would take longer
  int forecast = 2;                            ///< m, of skip and hold; 0 to 1000
  std::optional<Duration> pace;                ///< period of the source's segments; > 0
};

/// The period of the grid that these segments keep to: their median length, if half of them are within 1 % of it and at
/// least half of them end with idle time (more than 1 % of it). Empty: they run freely.
std::optional<Duration> grid_period(std::span<const SegmentTiming> segments);
/// The same for programmed segments.
std::optional<Duration> grid_period(const ProgrammedTiming& timing);

/// `grid`: the source's period, see above. A segment of the source whose visualization overlaps its steps has no pause: it
/// passes unchanged. If a segment has steps on both sides of its visualization, the steps before it become a segment without
/// a drawing.
std::unique_ptr<StepTiming> make_governed_timing(std::unique_ptr<StepTiming> source, const FrameGovernor& governor,
                                                 std::optional<Duration> grid);

}  // namespace evenstep
