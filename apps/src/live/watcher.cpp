#include "watcher.h"

#include <spdlog/spdlog.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace evenstep::app {
namespace {

constexpr Duration kLook{20'000'000};
constexpr Duration kRows{100'000'000};
constexpr Duration kSecond{1'000'000'000};
/// Rows are sent once they are this old: a lane shows a step or tick right after it ran, but may be held up in between.
constexpr Duration kSettled{50'000'000};
/// Where stderr is no terminal, a line is written every so many seconds.
constexpr int kPlainSeconds = 10;

}  // namespace

Screen screen_of_stderr() {
  const char* const kind = std::getenv("TERM");
  Screen screen;
  screen.terminal = ::isatty(STDERR_FILENO) != 0 && !(kind && std::strcmp(kind, "dumb") == 0);
  const char* const no_colour = std::getenv("NO_COLOR");
  screen.colour = screen.terminal && !(no_colour && *no_colour);
  winsize size{};
  // The last column stays free: some terminals begin a new line when it is written.
  if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1) screen.columns = size.ws_col - 1U;
  return screen;
}

LiveWatcher::LiveWatcher(const Scenario& scenario, const LiveDeviceOptions& options)
    : scenario_(scenario), run_(watched_run(scenario, options)) {}

LiveWatcher::~LiveWatcher() = default;

Result<std::string> LiveWatcher::open_scope(std::uint16_t port) {
  const Page page = scope_page(ScopeFeed(scenario_, run_).page_text());
  auto server = open_scope_server({port, html_of(page), policy_of(page)});
  if (!server) return Failure{server.error()};
  server_ = std::move(server).value();
  return server_->url();
}

void LiveWatcher::begin(LoopWatch& loop, WallEpoch epoch) {
  loop_ = &loop;
  clock_ = std::make_unique<WallClock>(epoch, Duration{0});
  ending_ = false;
  figures_.emplace(run_);
  feed_ = server_ ? std::make_unique<ScopeFeed>(scenario_, run_) : nullptr;
  thread_.emplace([this] { watch(); });
}

void LiveWatcher::end() {
  ending_ = true;
  clock_->notify();
  try {
    thread_->join();
  } catch (const std::exception& error) {  // the run goes on without being watched
    spdlog::warn("the run was not shown to its end: {}", error.what());
  }
  thread_.reset();
}

void LiveWatcher::watch() {
  leave_real_time();
  RealTime next_line = RealTime{0} + kSecond, next_rows{0};
  for (int lines = 0; !ending_;) {
    clock_->wait_until(clock_->now() + kLook);
    look();
    const RealTime now = clock_->now();
    if (server_ && now >= next_rows) {
      server_->publish("rows", feed_->rows(now - kSettled));
      next_rows = now + kRows;
    }
    if (now < next_line) continue;
    next_line = now + kSecond;
    show(++lines, false);
  }
  look();
  if (server_) server_->publish("rows", feed_->rows(kNever));
  show(0, true);
  if (server_) server_->publish("end", "");
}

void LiveWatcher::show(int number, bool last) {
  const std::uint64_t dropped = loop_->ticks.dropped() + loop_->steps.dropped();
  LiveSnapshot snapshot = figures_->take(clock_->now(), dropped);
  snapshot.ended = last;
  if (server_) server_->publish("figures", ScopeFeed::figures(snapshot));
  const Screen screen = screen_of_stderr();
  if (!screen.terminal && number % kPlainSeconds != 0) return;
  std::fputs(drawn(screen, run_, snapshot).c_str(), stderr);
  std::fflush(stderr);
}

void LiveWatcher::look() {
  const auto take = [this](const auto& seen) {
    figures_->add(seen);
    if (feed_) feed_->add(seen);
  };
  loop_->ticks.take(take);
  loop_->steps.take(take);
}

}  // namespace evenstep::app
