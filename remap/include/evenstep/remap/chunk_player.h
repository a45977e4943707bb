#pragma once
/// What a device plays if samples come in chunks: each inference gives N future samples, and the next chunk arrives before
/// all of them are played. Entry i of a chunk with the stamp s is for the time s + i d. Chunks are joined by these rules:
///
///   replace   from its arrival on the newest chunk counts; what is left of the chunk before is dropped ("latest only" of
///             LeRobot's asynchronous inference, https://huggingface.co/docs/lerobot/async)
///   append    a chunk counts from the end of the chunk before it, or from its arrival if that is later: the queue of
///             synchronous inference. Entries for times that were played already are dropped
///   blend     temporal ensembling: T. Z. Zhao et al., "Learning fine-grained bimanual manipulation with low-cost hardware"
///             (RSS 2023, section IV-B): the mean of all chunks that have an entry for t, with weights exp(-m i), i = 0 for
///             the oldest
///
/// Between entries the value is on the line to the next one, or held. The end of a chunk is the time of its last entry, or d
/// after that if entries are held. A time that no chunk covers gets the last entry of the newest chunk, with the status
/// `underrun`: the queue has run dry. Outside the formulas: a chunk that comes after one with the same or a later stamp is
/// dropped. Only the newest `most` chunks are kept.

#include <algorithm>
#include <cstddef>
#include <vector>

#include "evenstep/remap/force_schedule.h"
#include "evenstep/remap/sample.h"
#include "evenstep/time/reproducible_math.h"

namespace evenstep {

enum class ChunkRule : std::uint8_t { replace, append, blend };

struct ChunkSpec {
  ChunkRule rule = ChunkRule::replace;
  int entries = 50;            ///< N >= 1
  Duration every{20'000'000};  ///< d > 0
  double decay = 0.01;         ///< m >= 0
  Emission between = Emission::linear;
  std::size_t most = 64;

  Duration length() const { return every * entries; }
};

/// A chunk whose entry i is first + i per_entry: the output of a policy that continues a line.
template <class Value>
struct Chunk {
  RealTime stamp;
  Value first{}, per_entry{};
};

template <class Value>
class ChunkPlayer {
 public:
  explicit ChunkPlayer(const ChunkSpec& spec) : spec_(spec) { queue_.reserve(spec.most + 1); }

  void arrive(RealTime now, const Chunk<Value>& chunk) {
    if (!queue_.empty() && chunk.stamp <= queue_.back().chunk.stamp) {
      ++overtaken_;
      return;
    }
    RealTime from = now;
    if (spec_.rule == ChunkRule::append && !queue_.empty()) from = std::max(now, handover(queue_.back().chunk));
    queue_.push_back({chunk, from});
    if (queue_.size() > spec_.most) queue_.erase(queue_.begin());
  }

  Reading<Value> at(RealTime at) const {
    if (queue_.empty()) return {};
    const RealTime newest = queue_.back().chunk.stamp;
    if (spec_.rule == ChunkRule::blend) return blended(at, newest);
    auto playing = queue_.end() - 1;
    while (playing->from > at && playing != queue_.begin()) --playing;
    return played(playing->chunk, at, newest);
  }
  std::int64_t overtaken() const { return overtaken_; }

 private:
  struct Queued {
    Chunk<Value> chunk;
    RealTime from;  ///< it counts from then on
  };

  RealTime end_of(const Chunk<Value>& chunk) const { return chunk.stamp + spec_.length(); }
  /// When the next chunk may take over: interpolated entries need not hold the last one.
  RealTime handover(const Chunk<Value>& chunk) const {
    return spec_.between == Emission::linear ? end_of(chunk) - spec_.every : end_of(chunk);
  }
  bool covers(const Chunk<Value>& chunk, RealTime at) const { return chunk.stamp <= at && at < end_of(chunk); }
  Value value_of(const Chunk<Value>& chunk, RealTime at) const {
    const double last = spec_.entries - 1;
    double i = std::clamp(ratio(at - chunk.stamp, spec_.every), 0.0, last);
    if (spec_.between == Emission::hold) i = static_cast<double>(static_cast<int>(i));
    return chunk.first + chunk.per_entry * i;
  }

  Reading<Value> played(const Chunk<Value>& chunk, RealTime at, RealTime newest) const {
    return {value_of(chunk, at), covers(chunk, at) ? ReadStatus::inside : ReadStatus::underrun, newest};
  }

  Reading<Value> blended(RealTime at, RealTime newest) const {
    Value sum{};
    double weights = 0, i = 0;
    for (const Queued& queued : queue_) {
      if (at < queued.chunk.stamp || at >= handover(queued.chunk)) continue;
      const double w = reproducible::exp(-spec_.decay * i);
      sum = sum + value_of(queued.chunk, at) * w;
      weights += w;
      i += 1;
    }
    if (weights == 0) return played(queue_.back().chunk, at, newest);
    return {sum * (1 / weights), ReadStatus::inside, newest};
  }

  ChunkSpec spec_;
  std::vector<Queued> queue_;  // by stamp
  std::int64_t overtaken_ = 0;
};

}  // namespace evenstep
