// A program's own pacer, judged on recorded frames: `pacer run pacer.toml` is evenstep with this pacer as a map.
#include <memory>
#include <optional>

#include "evenstep/apps/command_line.h"
using namespace evenstep;

/// The pacer as the program has it: before each frame it says when that frame will be shown, and it is told when the frame
/// was done. It keeps a straight line through the frames so far, and corrects it by a share of each error.
class Pacer {
 public:
  RealTime predict_next(RealTime now) {
    if (frames_++ == 0) shown_ = now;
    if (frames_ < 3) return shown_ = now;
    shown_ = shown_ + period_;
    const Duration error = now - shown_;
    shown_ = shown_ + Duration{error.ns / 8};
    period_ += Duration{error.ns / 128};
    return shown_;
  }
  void done(RealTime begin, RealTime end) {
    if (frames_ < 3) period_ = end - begin;
  }

 private:
  std::int64_t frames_ = 0;
  RealTime shown_;
  Duration period_{};
};

/// The same pacer under evenstep's scenarios: each frame is a step, and its slot is when it will be shown.
class PacerMap final : public ForeignMap {
 public:
  void boundary(std::int64_t, RealTime) override {}
  void began(std::int64_t, RealTime at) override { begin_ = at; }
  std::optional<RealTime> slot(std::int64_t) override { return pacer_.predict_next(begin_); }
  void ended(std::int64_t, RealTime at) override { pacer_.done(begin_, at); }

 private:
  Pacer pacer_;
  RealTime begin_;
};

int main(int argc, char** argv) {
  Registry registry = builtin();
  registry.add_map("my-pacer", [](const MapRequest&) { return std::make_unique<PacerMap>(); });
  return command_line(argc, argv, registry);
}
