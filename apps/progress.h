#pragma once
/// Progress of a run on stderr: one rewritten line on a terminal, a plain line per finished strategy elsewhere.

#include <map>
#include <mutex>
#include <string>

namespace evenstep::app {

class Progress {
 public:
  explicit Progress(bool terminal) : terminal_(terminal) {}
  ~Progress();
  void update(const std::string& strategy, double fraction);  ///< any thread

 private:
  std::mutex mutex_;
  std::map<std::string, double> fractions_;
  double last_drawn_s_ = 0;
  bool drawn_ = false;
  bool terminal_;
};

}  // namespace evenstep::app
