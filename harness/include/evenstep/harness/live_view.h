#pragma once
/// An observer of a run on the wall clock while it runs (RunControl::view).

#include "evenstep/clock/wall_clock.h"
#include "evenstep/loop/loop_watch.h"

namespace evenstep {

class LiveView {
 public:
  virtual ~LiveView() = default;
  /// The loop begins at RealTime{0} of `epoch`, which is soon. Called on the thread of the run; another thread must read
  /// `loop`, until end().
  virtual void begin(LoopWatch& loop, WallEpoch epoch) = 0;
  /// The loop has ended, with or without a failure, and nothing more comes into `loop`. Returns when `loop` is no longer
  /// used.
  virtual void end() = 0;
};

}  // namespace evenstep
