#include <algorithm>

#include "evenstep/scheduler/blocking_clock.h"
#include "evenstep/scheduler/live_lanes.h"
#include "src/loop_thread.h"

namespace evenstep {

void WallBlockingClock::sleep_until(RealTime at) {
  const bool is_last = std::max(at, now()) >= end_;
  while (!stopped_.load(std::memory_order_acquire)) {
    if (clock_.wait_until(is_last ? end_ : at) == Wake::notified) continue;
    if (!is_last) return;
    break;
  }
  internal::leave_loop();
}

void WallBlockingClock::request_stop() noexcept {
  stopped_.store(true, std::memory_order_release);
  clock_.notify();
}

struct WallThread::State {
  State(WallEpoch epoch, RealTime end, BlockingLoop l) : clock(epoch, end), loop(std::move(l)) {}
  WallBlockingClock clock;
  const BlockingLoop loop;
  LaneThread thread{[this] { internal::run_until_stopped(loop, clock); }};  // last, because it begins here
};

WallThread::WallThread(WallEpoch epoch, RealTime end, BlockingLoop loop)
    : state_(std::make_unique<State>(epoch, end, std::move(loop))) {}
WallThread::~WallThread() { request_stop(); }
void WallThread::request_stop() noexcept { state_->clock.request_stop(); }
void WallThread::join() { state_->thread.join(); }

}  // namespace evenstep
