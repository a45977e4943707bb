#pragma once
/// One line about a live run, as text. "The last" second means the time since the previous line, and "run" means the whole
/// run so far. Numbers have their units; names have nothing that a terminal takes for a command.

#include <optional>
#include <string>

#include "evenstep/harness/live_figures.h"

namespace evenstep::app {

/// In words: "ARMED", "CUT (hand too fast)", "READ ONLY" for a device whose forces are not sent, "WAITING" before its first
/// tick and its first force.
std::string state_text(const WatchedRun::Device& device, const LiveSnapshot::Device& seen);
/// Whether a force is cut off that would be sent.
bool any_cut(const WatchedRun& run, const LiveSnapshot& snapshot);

/// The line, at most this many columns long: first its parts become shorter, then the least important are left out. What
/// stays longest: whether forces are let through, the time left, and how to stop.
std::string status_line(const WatchedRun& run, const LiveSnapshot& snapshot, std::optional<std::size_t> columns = {});

/// Where lines go.
struct Screen {
  bool terminal = false;  ///< one line that is rewritten; otherwise plain lines
  bool colour = false;    ///< red while a force is cut off; needs a terminal
  std::size_t columns = 80;
};
/// What is written there for a line. The last line of a loop that has ended stays.
std::string drawn(const Screen& screen, const WatchedRun& run, const LiveSnapshot& snapshot);

}  // namespace evenstep::app
