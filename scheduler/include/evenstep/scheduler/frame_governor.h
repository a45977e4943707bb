#pragma once
/// A frame governor: shortens the pauses that drawings and waiting make between steps, as a simulator can do it itself. It
/// is a StepTiming over another one, so that the sizing pass, a virtual run and a run on a wall clock see the same governed
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
///
/// With `spread` the steps of a segment do not follow each other in a burst, after which the simulator waits: step i begins
/// no earlier than its slot, the segment's turn + i T/N, rounded down. A step that is late follows at once, so what a long
/// drawing or step has delayed is caught up with as soon as without `spread`. No step is dropped, and the order stays.
///   T   `pace`, or else the source's period P. A source that runs freely does not wait, and its steps stay as they are
///   N   the number of the segment's steps
/// Opportunity j of a segment, too, then has its turn at the slot of its first step, so that steps keep one pace.
///
/// Split and spread together, with even slots i T/N and T and N known beforehand; a step's lead is its slot minus its begin,
/// its lateness its end minus its slot. All three schedules do the same work in nearly the same order, and a busy time
/// begins at a slot or a turn. So, however long steps and drawings are, a step ends
///   - no later than with `split` alone plus the most that `split` leads by, because no step of it begins earlier before its
///     slot: lead and lateness, which a latency has to bridge, together are never more than those of `split` alone;
///   - no later than with `spread` alone plus K - 1 parts, the rest of the drawing that it still has before it. If no step
///     is longer than T/N, the largest lateness was never more than a slot above that of `spread` alone (100,000 schedules).
/// Where steps may be longer, no governor that does not know them keeps within a slot of both: let K = 2, short steps, idle
/// time I per segment, 2 T/N < I < V - 2 T/N, and one step of length V. If the second part comes in the first half of the
/// segment, the last step of that half begins (V - I)/2 late or more, and with `split` alone on time; if it comes later, the
/// step after it begins V/2 late, and with `spread` alone at most (V - I)/2. Either may be the long one.
///
/// Of a recording nobody has programmed T, P and N, so they are what was usual in its last 8 segments: T = P is the lower
/// median of their lengths, if at least half of them ended with idle time (more than 1 % of their length); N is the most
/// steps that one of them had. Before its first segment is over nothing was usual yet:
///   spread alone      the first steps follow each other at once. With a `pace` T is known, but not how many steps come
///   with split        who shares steps and idle time out between parts knows how many steps a segment has, and the period,
///                     as `split` alone does: T = P is `pace` or grid_period() of the recording, N the first segment's own
/// Steps beyond N have the last slot, and when the recording's next segment begins no step waits any more. So with `spread`
/// alone what the governor does up to an instant is the same whatever comes after; with split, too, whatever comes after
/// with the same grid_period(), up to the begin of a segment. A step begins later than without `spread` by at most the
/// length of one segment of the source; if T and N are programmed and no step is longer than its slot, no later than its
/// slot or its begin without `spread` (gaps of the source that are no idle time come on top).

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "evenstep/scheduler/step_timing.h"

namespace evenstep {

enum class OverBudget { skip, hold, merge };

struct FrameGovernor {
  int split = 1;                               ///< K, 1 to 1000
  std::optional<Duration> budget;              ///< b, of a pause; > 0
  OverBudget over_budget = OverBudget::merge;  ///< what becomes of a drawing that would take longer
  int forecast = 2;                            ///< m, of skip and hold; 0 to 1000
  std::optional<Duration> pace;                ///< period of the source's segments; > 0
  bool spread = false;                         ///< steps wait for their slots
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
/// The same over a recording. Its grid is grid_period() of the whole recording; with `spread` it is learned, see above.
std::unique_ptr<StepTiming> make_governed_replay(std::vector<SegmentTiming> recording, const FrameGovernor& governor);

}  // namespace evenstep
