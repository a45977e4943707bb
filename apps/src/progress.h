#pragma once
/// Progress of a run on stderr: one rewritten line on a terminal, a plain line per finished strategy elsewhere.

#include <cstdint>
#include <map>
#include <mutex>
#include <string>

namespace evenstep::app {

class Progress {
 public:
  explicit Progress(bool terminal) : terminal_(terminal) {}
  ~Progress();
  void update(const std::string& strategy, double fraction);  ///< callable from any thread

 private:
  std::mutex mutex_;
  std::map<std::string, double> fractions_;
  double last_drawn_s_ = 0;
  bool drawn_ = false;
  bool terminal_;
};

/// "  23 of 108, 4 failed", or "  23 of 108" without `more`; "runs" if the total is not known (0).
std::string count_words(std::int64_t done, std::int64_t of, const std::string& more);

/// Progress of work that can be counted, with the time that is left: one rewritten line on a terminal, a plain line every
/// ten seconds elsewhere.
class CountProgress {
 public:
  explicit CountProgress(bool terminal) : terminal_(terminal) {}
  ~CountProgress();
  /// Call it from one thread at a time. `of` is 0 if the total is not known. The first call gives the count with which this
  /// process began.
  void update(std::int64_t done, std::int64_t of, const std::string& more);

 private:
  std::int64_t first_ = -1;
  double began_s_ = 0, last_shown_s_ = 0;
  bool drawn_ = false;
  bool terminal_;
};

/// "3 h 5 min", "2 min 10 s", "8 s"
std::string rough_time(double seconds);

}  // namespace evenstep::app
