#include "progress.h"

#include <fmt/format.h>

#include <cstdio>

#include "evenstep/clock/wall_clock.h"

namespace evenstep::app {
namespace {
constexpr double kRedrawSeconds = 0.1;
constexpr double kLineSeconds = 10;
}  // namespace

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

std::string rough_time(double seconds) {
  const auto whole = static_cast<std::int64_t>(seconds + 0.5);
  if (whole >= 3600) return fmt::format("{} h {} min", whole / 3600, whole / 60 % 60);
  if (whole >= 60) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} s", whole);
}

std::string count_words(std::int64_t done, std::int64_t of, const std::string& more) {
  const std::string count = of > 0 ? fmt::format("  {} of {}", done, of) : fmt::format("  {} runs", done);
  return more.empty() ? count : count + ", " + more;
}

void CountProgress::update(std::int64_t done, std::int64_t of, const std::string& more) {
  const double now_s = monotonic_seconds();
  if (first_ < 0) {
    first_ = done;
    began_s_ = last_shown_s_ = now_s;
  }
  if (now_s - last_shown_s_ < (terminal_ ? kRedrawSeconds : kLineSeconds)) return;
  last_shown_s_ = now_s;
  std::string line = count_words(done, of, more);
  if (of > 0 && done > first_) {
    const double each_s = (now_s - began_s_) / static_cast<double>(done - first_);
    line += ", " + rough_time(each_s * static_cast<double>(of - done)) + " left";
  }
  fmt::print(stderr, "{}{}{}", terminal_ ? "\r\033[K" : "", line, terminal_ ? "" : "\n");
  std::fflush(stderr);
  drawn_ = terminal_;
}

CountProgress::~CountProgress() {
  if (drawn_) std::fputs("\r\033[K", stderr);
}

}  // namespace evenstep::app
