#pragma once
/// What the page of a live run (reports/pages/web/scope.js) is sent, as lines of JSON. Times in s, positions in mm, forces
/// in N, margins in ms; a number that does not exist is null.

#include <string>

#include "evenstep/harness/direct_shadow.h"
#include "evenstep/harness/live_figures.h"
#include "evenstep/pages/scope_page.h"

namespace evenstep::app {

class ScopeFeed {
 public:
  /// `scenario` with the guards of real devices.
  ScopeFeed(const Scenario& scenario, const WatchedRun& run);
  ScopeText page_text() const;
  void add(const SeenTick& tick);
  void add(const SeenStep& step);
  /// "rows": what ran before `until` and was not sent yet, and the worst state of each device since the last time. Of a
  /// device faster than 2 kHz, only every n-th tick is sent.
  std::string rows(RealTime until);
  /// "figures"
  static std::string figures(const LiveSnapshot& snapshot);

 private:
  struct Device {
    std::int64_t every = 1;  // which ticks are sent
    LiveSnapshot::Device worst;
  };
  const WatchedRun& run_;
  DirectShadow shadow_;
  std::vector<Device> devices_;
};

}  // namespace evenstep::app
