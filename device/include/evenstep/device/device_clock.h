#pragma once
/// Follows the clock of a device: from the time stamp of each report and the time at which the report was read it finds when
/// the report's position was taken, in the host's clock.
///
/// With d the device's time of a report and r the time at which it was read, y = r - d is the offset of the two clocks plus
/// the report's age. An age is never negative, but may be of any size (a busy bus, a late tick, a wait for the next tick).
/// So the offset is the line below all points (d, y): of all such lines the one that lies nearest to them (S. Moon, P.
/// Skelly, D. Towsley, "Estimation and removal of clock skew from network delay measurements", INFOCOM 1999). It is the edge
/// of their lower hull over their mean d. A delay-locked loop would take the mean age for the least, and follow a report
/// that is late; this line does neither.
///
/// The line is fitted anew for each block of 0.5 s, over the lowest points of the last 128 blocks (64 s). A change by a fit
/// is followed over the next block, so a time never jumps. A point below the line moves the line down to it at once, because
/// no report is from the future; this is counted.
///
/// What it cannot know: the least age itself. Reports that are all 1 ms old look like reports of age 0 by a clock that is
/// 1 ms late. `least_age` is subtracted for it. And where a report is seen only at the ticks of a reader, whose period is
/// about that of the device, the clocks' difference does not show until it has added up to a period: until then a time may
/// be off by up to a period (docs/devices/ages.md).
///
/// A time is never after its read, never more than 1 s before it, and after the previous time (by 1 ns, where stamps or that
/// cap would have it otherwise; two reports of one read may have the same). Times that had to be moved for that are counted.
/// The clock is followed anew after restart(), and where it must have been set: if it goes back, if a report is more than 50
/// ms from the future, or if no report of a block was younger than 100 ms. A rate error of more than 1 % is followed as 1 %.
///
/// Times are integers only, so a run is reproducible. A fit allocates, twice a second.

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "evenstep/time/duration_histogram.h"
#include "evenstep/time/time.h"

namespace evenstep {

/// What a device's time stamps said in a run.
struct SampleAges {
  DurationHistogram ages;     ///< from when a fresh sample was taken until it was read
  std::int64_t ahead = 0;     ///< reports below the line: they moved it down
  Duration ahead_max;         ///< the most that one of them moved it
  std::int64_t capped = 0;    ///< times that were moved: older than 1 s, or not after the previous one
  std::int64_t restarts = 0;  ///< the clock was followed anew
  /// By the last fit: 1e-6 is a clock that gains 1 us a second. Empty before the first, or if no clock is followed.
  std::optional<double> clock_rate_error;
  Duration residual;  ///< how far the highest of the blocks' lowest points lies above that line
};

class DeviceClock {
 public:
  explicit DeviceClock(Duration least_age = {}) : least_age_(least_age) {}
  /// When the position of a report was taken that says `stamp_us` (modulo 2^32) and was read at `read`. Reports in order;
  /// reads do not decrease.
  RealTime taken(std::uint32_t stamp_us, RealTime read);
  /// The device has begun to count anew.
  void restart();
  /// A sample that was taken and read at these times was passed on.
  void passed_on(RealTime taken, RealTime read) { ages_.ages.add(read - taken); }
  /// Only `ages` counts samples, which are fewer than the reports.
  const SampleAges& ages() const { return ages_; }

 private:
  struct Point {
    std::int64_t device_ns = 0, offset_ns = 0;
  };
  /// Through a point, with a slope of rise / run.
  struct Line {
    Point through;
    std::int64_t rise_ns = 0, run_ns = 1;
    std::int64_t at(std::int64_t device_ns) const {
      return through.offset_ns + floor_mul_div(device_ns - through.device_ns, rise_ns, run_ns);
    }
  };

  /// The points of a block with the lowest offset: the first one and the last one.
  struct Block {
    Point first, last;
  };

  static Line line_below(const std::vector<Point>& points);
  void begin(RealTime read);
  void begin_block();
  std::int64_t followed() const;  ///< the offset at the device's time
  void note(Point point);
  void fit();
  RealTime in_order(RealTime taken, RealTime read);

  Duration least_age_;
  SampleAges ages_;
  bool running_ = false;
  std::uint32_t last_stamp_us_ = 0;
  std::int64_t device_ns_ = 0;  // the device's time since it is followed, without wrap-around
  Line line_;
  std::int64_t gap_ns_ = 0, gap_from_ns_ = 0;  // what is followed is off the line by the gap, which closes over a block
  std::int64_t block_begin_ns_ = 0;
  std::optional<Block> block_;
  std::deque<Block> blocks_;  // those before, in order
  std::optional<RealTime> last_taken_;
};

}  // namespace evenstep
