#pragma once
/// "What if its hitches came together?" (evenstep size --worst-order): searches the orders of a recording's own segments for
/// the one with the largest least latency.
///
/// A segment is moved as a whole, with the time up to the next one. The first segments (an eighth of all, at most 60) stay
/// where they are, because a map that has just begun is another matter; so does the last one, which may have been cut short.
/// A segment counts as a hitch if it has a hitch (src/size/hitches.h), or is longer than the median by more than a tenth. In
/// no window of the given span may more hitches begin than in the worst such window of the recording.
///
/// The search is over a stretch of at most 180 segments after those that stay: the maps forget the past within a second or
/// two, so a longer one would find the same. What comes before and in the stretch is what the map sees, so no need found
/// there is an estimate. It starts from a few orders (as recorded; the longest pauses together; after many short segments;
/// short and long in turn), and goes on from each by random exchanges, with segments from outside the stretch, too, that
/// keep the rule about hitches in the whole; none that lowers the latency is kept. The seed is fixed, and so is the number
/// of orders tried, so the result is the same everywhere. It is found, not proved: a worse order may exist.

#include <span>
#include <vector>

#include "evenstep/campaigns/size.h"
#include "evenstep/harness/sizing.h"

namespace evenstep::internal {

/// The order found for one map, over the whole recording, and the segments in it.
struct FoundOrder {
  SizeWorstOrder::Map row;
  std::vector<SegmentTiming> segments;
};

class OrderSearch {
 public:
  /// `segments` must outlive this object.
  OrderSearch(const MapSetup& setup, std::span<const SegmentTiming> segments, Duration span);

  /// Why these segments cannot change places; empty if they can.
  const std::string& refused() const { return refused_; }
  std::int64_t hitches() const;
  /// Of the recording, in the worst window.
  std::int64_t most_together() const { return most_together_; }
  FoundOrder search(StrategyKind map) const;

 private:
  using Order = std::vector<std::uint32_t>;
  Duration length(std::uint32_t segment) const { return lengths_[segment]; }
  std::int64_t together(const Order& order) const;
  Order allowed(const Order& wanted) const;
  std::vector<Order> starts() const;
  bool change(std::uint64_t draw, Order& order) const;
  std::vector<SegmentTiming> in_order(const Order& order, std::size_t count) const;
  LatencyBudget needs(StrategyKind map, const Order& order, std::size_t count) const;

  MapSetup setup_;
  std::span<const SegmentTiming> segments_;
  Duration span_;
  std::string refused_;
  std::vector<Duration> lengths_;  // to the next segment's begin; of the last one to its end
  std::vector<Duration> pauses_;   // the longest time in it, and up to the next one, in which no step begins
  std::vector<bool> hitch_;
  Order by_length_, by_pause_;  // those that may move, the largest first
  std::int64_t most_together_ = 0;
  std::size_t kept_ = 1, stretch_ = 0;  // segments that stay at the start, and those after them that are searched
  std::int64_t orders_ = 0;             // so many are tried
};

/// `worst` gets the segments in the order found for the map asked for or, without one, for the one to use.
SizeWorstOrder worst_orders(const MapSetup& setup, std::span<const SegmentTiming> segments,
                            std::span<const StrategyKind> maps, const WorstOrderAsked& asked, const SizeRecord& record,
                            std::vector<SegmentTiming>& worst);

}  // namespace evenstep::internal
