#include "progress.h"

#include <fmt/format.h>

#include <cstdio>

#include "evenstep/clock/wall_clock.h"

namespace evenstep::app {
namespace {
constexpr double kRedrawSeconds = 0.1;
}

void Progress::update(const std::string& strategy, double fraction) {
  const std::lock_guard lock(mutex_);
  double& known = fractions_[strategy];
  const bool finished = fraction >= 1.0 && known < 1.0;
  known = fraction;
  if (!terminal_) {
    if (finished) fmt::print(stderr, "  {} done\n", strategy);
    return;
  }
  const double now_s = monotonic_seconds();
  if (!finished && now_s - last_drawn_s_ < kRedrawSeconds) return;
  last_drawn_s_ = now_s;
  std::string line = "\r\033[K";
  for (const auto& [name, done] : fractions_) line += fmt::format("  {} {:3.0f} %", name, 100 * done);
  std::fputs(line.c_str(), stderr);
  std::fflush(stderr);
  drawn_ = true;
}

Progress::~Progress() {
  if (drawn_) std::fputs("\r\033[K", stderr);
}

}  // namespace evenstep::app
