#pragma once
/// Shows a live run while it runs: a line on stderr (once a second on a terminal, elsewhere every ten seconds; at the end),
/// and with --scope a page. A thread of ordinary priority looks fifty times a second at what the loop has put into its
/// rings; the loop does not notice.

#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "evenstep/harness/live_figures.h"
#include "evenstep/harness/live_view.h"
#include "evenstep/scheduler/live_lanes.h"
#include "scope_feed.h"
#include "scope_server.h"
#include "status.h"

namespace evenstep::app {

/// stderr as it is now: a terminal (that is not "dumb"), its width, and colour unless NO_COLOR is set.
Screen screen_of_stderr();

class LiveWatcher final : public LiveView {
 public:
  /// `scenario` with the guards of real devices; it must live as long as this.
  LiveWatcher(const Scenario& scenario, const LiveDeviceOptions& options);
  ~LiveWatcher() override;
  /// Opens the page; returns its address, or why there is none.
  Result<std::string> open_scope(std::uint16_t port);
  void begin(LoopWatch& loop, WallEpoch epoch) override;
  void end() override;

 private:
  void watch();
  void look();
  void show(int number, bool last);

  const Scenario& scenario_;
  WatchedRun run_;
  std::unique_ptr<ScopeServer> server_;

  // For one run of the loop. Only the thread uses these, except for the first three.
  LoopWatch* loop_ = nullptr;
  std::unique_ptr<WallClock> clock_;
  std::atomic<bool> ending_{false};
  std::optional<LiveFigures> figures_;
  std::unique_ptr<ScopeFeed> feed_;
  std::optional<LaneThread> thread_;
};

}  // namespace evenstep::app
