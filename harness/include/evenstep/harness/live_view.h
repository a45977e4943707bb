#pragma once
/// Who watches a run on the wall clock while it runs (RunControl::view).

#include "evenstep/clock/wall_clock.h"
#include "evenstep/loop/loop_watch.h"

namespace evenstep {

class LiveView {
 public:
  virtual ~LiveView() = default;
  /// The loop begins at RealTime{0} of `epoch`, which is near. Called on the thread of the run; another thread is to read
  /// `loop`, until end().
  virtual void begin(LoopWatch& loop, WallEpoch epoch) = 0;
  /// The loop has ended, well or badly; what is still in `loop` is its last. Returns when `loop` is no longer used.
  virtual void end() = 0;
};

}  // namespace evenstep
