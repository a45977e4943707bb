#include "worst_order.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <numeric>

#include "evenstep/scheduler/random.h"
#include "evenstep/text/quantity.h"
#include "src/size/clauses.h"
#include "src/size/hitches.h"

namespace evenstep {
namespace internal {
namespace {

constexpr std::size_t kMostKept = 60, kMostStretch = 180, kLeastStretch = 16;
constexpr std::size_t kLeastToOrder = 4;           // segments
constexpr std::int64_t kMostSearchedSteps = 6000;  // in the stretch, unless it would be shorter than the least one
constexpr std::int64_t kStepsWalked = 20'000'000, kSegmentsCounted = 200'000'000, kMostOrders = 4000, kLeastOrders = 100;
constexpr std::int64_t kLongPart = 10;  // a segment longer than the median by more than this part is a hitch

/// The longest time from the segment's begin, or from a step's begin, to the next step's begin or the next segment's.
Duration pause_in(const SegmentTiming& segment, Duration length) {
  RealTime from = segment.begin;
  Duration longest;
  for (const Interval& step : segment.steps) {
    longest = std::max(longest, step.begin - from);
    from = step.begin;
  }
  return std::max(longest, segment.begin + length - from);
}

std::vector<bool> with_hitches(const std::vector<SegmentTiming>& segments, const std::vector<Duration>& lengths) {
  const Hitches found(segments);
  std::vector<bool> out(segments.size());
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] = (lengths[k] - found.usual_segment()).ns > found.usual_segment().ns / kLongPart;
  for (const HitchKind& kind : found.kinds()) {
    for (const SeenHitch& hitch : kind) {
      const auto after = std::upper_bound(segments.begin(), segments.end(), hitch.begin,
                                          [](RealTime at, const SegmentTiming& one) { return at < one.begin; });
      if (after != segments.begin()) out[static_cast<std::size_t>(after - segments.begin()) - 1] = true;
    }
  }
  return out;
}

/// How many hitches begin in a window that ends now, if they are told of in order.
class Window {
 public:
  explicit Window(Duration span) : span_(span) {}
  std::int64_t with(RealTime begin) {
    while (!begins_.empty() && begins_.front() <= begin - span_) begins_.pop_front();
    return std::ssize(begins_) + 1;
  }
  void add(RealTime begin) { begins_.push_back(begin); }

 private:
  Duration span_;
  std::deque<RealTime> begins_;
};

}  // namespace

OrderSearch::OrderSearch(const MapSetup& setup, std::span<const SegmentTiming> segments, Duration span)
    : setup_(setup), segments_(segments), span_(span) {
  if (segments.size() < kLeastToOrder) {
    refused_ = fmt::format("it has {} segments, and another order takes at least {}", segments.size(), kLeastToOrder);
    return;
  }
  for (std::size_t k = 0; k < segments.size(); ++k) {
    const bool last = k + 1 == segments.size();
    lengths_.push_back((last ? segments[k].end : segments[k + 1].begin) - segments[k].begin);
    pauses_.push_back(pause_in(segments[k], lengths_.back()));
    if (segments[k].overlaps() || segments[k].begin + lengths_.back() < segments[k].end) {
      refused_ = "its drawings have a lane of their own, so a segment is not a whole that could come elsewhere";
      return;
    }
  }
  const std::vector<SegmentTiming> all(segments.begin(), segments.end());
  hitch_ = with_hitches(all, lengths_);
  kept_ = std::clamp<std::size_t>(segments.size() / 8, 1, kMostKept);
  const std::size_t may_move = segments.size() - kept_ - 1;
  std::int64_t steps = 0;
  while (stretch_ < std::min(kMostStretch, may_move) && (stretch_ < kLeastStretch || steps < kMostSearchedSteps))
    steps += std::ssize(segments[kept_ + stretch_++].steps);
  for (std::size_t k = 0; k < kept_; ++k) steps += std::ssize(segments[k].steps);
  orders_ = std::clamp(std::min(kStepsWalked / std::max<std::int64_t>(steps, 1), kSegmentsCounted / std::ssize(segments)),
                       kLeastOrders, kMostOrders);

  by_length_.resize(may_move);
  std::iota(by_length_.begin(), by_length_.end(), static_cast<std::uint32_t>(kept_));
  by_pause_ = by_length_;
  const auto sort = [](Order& order, const std::vector<Duration>& by) {
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return by[a] > by[b]; });
  };
  sort(by_length_, lengths_);
  sort(by_pause_, pauses_);
  Order recorded(segments.size());
  std::iota(recorded.begin(), recorded.end(), 0u);
  most_together_ = together(recorded);
}

std::int64_t OrderSearch::hitches() const { return std::count(hitch_.begin(), hitch_.end(), true); }

/// In the worst window of the whole recording, in this order.
std::int64_t OrderSearch::together(const Order& order) const {
  Window window(span_);
  std::int64_t most = 0;
  RealTime at;
  for (const std::uint32_t k : order) {
    if (hitch_[k]) {
      most = std::max(most, window.with(at));
      window.add(at);
    }
    at = at + length(k);
  }
  return most;
}

/// The wanted order, except that a hitch waits, behind as many others as it must, until its window has room for it. Where
/// only hitches are left, nothing can wait: the order then breaks the rule.
OrderSearch::Order OrderSearch::allowed(const Order& wanted) const {
  Order out;
  out.reserve(wanted.size());
  Window window(span_);
  RealTime at;
  std::deque<std::uint32_t> waiting;
  std::size_t next = 0;
  const auto put = [&](std::uint32_t k) {
    if (hitch_[k]) window.add(at);
    at = at + length(k);
    out.push_back(k);
  };
  while (next < wanted.size() || !waiting.empty()) {
    const bool room = window.with(at) <= most_together_;
    if (!waiting.empty() && (room || next == wanted.size())) {
      put(waiting.front());
      waiting.pop_front();
    } else if (const std::uint32_t k = wanted[next++]; hitch_[k] && !room && out.size() >= kept_) {
      waiting.push_back(k);
    } else {
      put(k);
    }
  }
  // The last segment stays the last.
  const auto last = static_cast<std::uint32_t>(segments_.size() - 1);
  out.erase(std::find(out.begin(), out.end(), last));
  out.push_back(last);
  return out;
}

std::vector<OrderSearch::Order> OrderSearch::starts() const {
  Order recorded(segments_.size());
  std::iota(recorded.begin(), recorded.end(), 0u);
  std::vector<Order> out{recorded};
  const std::size_t part = std::max<std::size_t>(stretch_ / 3, 1);
  /// Those of `first` come directly after the ones that stay, and then the rest as recorded.
  const auto with = [&](const Order& first) {
    std::vector<bool> taken(segments_.size());
    Order order(recorded.begin(), recorded.begin() + static_cast<std::ptrdiff_t>(kept_));
    for (const std::uint32_t k : first) {
      if (!taken[k]) order.push_back(k);
      taken[k] = true;
    }
    for (std::size_t k = kept_; k < segments_.size(); ++k)
      if (!taken[k]) order.push_back(static_cast<std::uint32_t>(k));
    order = allowed(order);
    if (together(order) <= most_together_) out.push_back(std::move(order));
  };
  const Order longest_pauses(by_pause_.begin(), by_pause_.begin() + static_cast<std::ptrdiff_t>(part));
  Order after_short(by_length_.rbegin(), by_length_.rbegin() + static_cast<std::ptrdiff_t>(part));
  after_short.insert(after_short.end(), longest_pauses.begin(), longest_pauses.end());
  Order in_turn;
  for (std::size_t i = 0; i < part; ++i) {
    in_turn.push_back(by_length_[by_length_.size() - 1 - i]);
    in_turn.push_back(by_length_[i]);
  }
  for (const Order& first : {longest_pauses, after_short, in_turn}) with(first);
  return out;
}

/// Changes the order a little; false if the change breaks the rule about hitches or changes nothing.
bool OrderSearch::change(std::uint64_t draw, Order& order) const {
  const RandomStream random(0, "size.worst_order");
  const auto pick = [&](std::uint64_t which, std::size_t count) {
    return static_cast<std::size_t>(random.below(8 * draw + which, count));
  };
  const std::size_t a = kept_ + pick(0, stretch_), kind = pick(1, 4);
  const auto at = [&](std::size_t i) { return order.begin() + static_cast<std::ptrdiff_t>(i); };
  if (kind == 0 && segments_.size() - kept_ - 1 > stretch_) {
    // One from outside the stretch, often one of the longest or shortest.
    const Order& from = pick(2, 2) == 0 ? by_length_ : by_pause_;
    const std::size_t few = std::min(from.size(), stretch_);
    const std::size_t which = pick(3, 3), place = pick(4, which == 0 ? from.size() : few);
    const std::uint32_t wanted = from[which == 2 ? from.size() - 1 - place : place];
    const auto found = std::find(order.begin(), order.end(), wanted);
    if (found == at(a)) return false;
    std::iter_swap(at(a), found);
  } else {
    const std::size_t b = kept_ + pick(2, stretch_);
    if (a == b) return false;
    const std::size_t first = std::min(a, b), last = std::max(a, b);
    if (kind == 1)
      std::rotate(at(first), at(first + 1 + pick(3, last - first)), at(last + 1));
    else if (kind == 2)
      std::reverse(at(first), at(last + 1));
    else
      std::iter_swap(at(a), at(b));
  }
  return together(order) <= most_together_;
}

/// The first `count` segments of the order, each directly after the one before.
std::vector<SegmentTiming> OrderSearch::in_order(const Order& order, std::size_t count) const {
  std::vector<SegmentTiming> out(count);
  RealTime at = segments_.front().begin;
  for (std::size_t i = 0; i < count; ++i) {
    const SegmentTiming& from = segments_[order[i]];
    SegmentTiming& to = out[i];
    const Duration by = at - from.begin;
    to = from;
    to.index = static_cast<std::int64_t>(i);
    to.begin = at;
    to.end = from.end + by;
    if (to.visualization) to.visualization = Interval{from.visualization->begin + by, from.visualization->end + by};
    for (Interval& step : to.steps) step = {step.begin + by, step.end + by};
    to.simulated.clear();  // a loop's own time would go back
    at = at + length(order[i]);
  }
  return out;
}

LatencyBudget OrderSearch::needs(StrategyKind map, const Order& order, std::size_t count) const {
  const std::vector<SegmentTiming> segments = in_order(order, count);
  RunningNeeds running(setup_.grids, setup_.emission, RunningNeeds::Phase::any);
  each_mapped_step(setup_, map, segments, [&](std::span<const MappedStep> steps) { running.add(steps); });
  LatencyBudget least = running.budget();
  if (least.latency_culprit >= 0) least.latency = least.latency + needed_ahead(setup_, map, setup_.emission);
  return least;
}

FoundOrder OrderSearch::search(StrategyKind map) const {
  // What only the last segment follows is judged with it.
  const std::size_t seen = kept_ + stretch_ + (kept_ + stretch_ + 1 == segments_.size() ? 1 : 0);
  const std::vector<Order> starts = this->starts();
  const LatencyBudget recorded = needs(map, starts.front(), segments_.size());
  Order worst = starts.front();
  LatencyBudget needed = recorded;
  std::int64_t tried = 0;
  const auto judge_whole = [&](const Order& order) {
    const LatencyBudget whole = needs(map, order, segments_.size());
    if (whole.latency <= needed.latency) return;
    worst = order;
    needed = whole;
  };
  std::uint64_t draw = 0;
  for (const Order& start : starts) {
    judge_whole(start);
    Order now = start;
    Duration most = needs(map, now, seen).latency;
    for (std::int64_t i = 0; i < orders_ / std::ssize(starts); ++i) {
      Order next = now;
      ++tried;
      if (!change(draw++, next)) continue;
      const Duration latency = needs(map, next, seen).latency;
      if (latency < most) continue;
      most = latency;
      now = std::move(next);
    }
    judge_whole(now);
  }
  FoundOrder out;
  out.row = {.name = name_of(map),
             .latency = recorded.latency,
             .lead = recorded.lead,
             .worst_latency = needed.latency,
             .worst_lead = needed.lead,
             .tried = tried};
  out.segments = in_order(worst, segments_.size());
  return out;
}

SizeWorstOrder worst_orders(const MapSetup& setup, std::span<const SegmentTiming> segments,
                            std::span<const StrategyKind> maps, const WorstOrderAsked& asked, const SizeRecord& record,
                            std::vector<SegmentTiming>& worst) {
  SizeWorstOrder out{.span = asked.span};
  const OrderSearch search(setup, segments, asked.span);
  out.refused = search.refused();
  if (!out.refused.empty()) return out;
  out.hitches = search.hitches();
  out.together = search.most_together();
  const SizeStrategy* use = strategy_to_use(record);
  out.map = asked.map.value_or(use == nullptr || use->name == "clocked" ? "phase_locked" : use->name);
  for (const StrategyKind map : maps) {
    const std::string name = name_of(map);
    if (map == StrategyKind::clocked || (asked.map && name != *asked.map)) continue;
    FoundOrder found = search.search(map);
    if (name == out.map) worst = std::move(found.segments);
    out.maps.push_back(std::move(found.row));
  }
  if (!out.maps.empty()) return out;
  std::string known;
  for (const StrategyKind map : maps)
    if (map != StrategyKind::clocked) known += (known.empty() ? "" : ", ") + std::string(name_of(map));
  out.refused = out.map == "clocked"
                    ? "in another order the steps of a loop that follows a clock would not be due when they ran; "
                      "name one of " +
                          known
                    : fmt::format("\"map {}\" is none of {}", out.map, known);
  return out;
}

}  // namespace internal

Result<WorstOrderAsked> parse_worst_order(std::string_view text) {
  WorstOrderAsked asked;
  bool first = true;
  const std::string error =
      internal::each_clause(text, [&](std::string_view clause, std::string_view word, std::string_view rest) -> std::string {
        if (word == "map" && !rest.empty()) return asked.map = std::string(rest), "";
        const Result<Duration> span = parse_duration(clause);
        if (!first || !span)
          return fmt::format("\"{}\": a span must stand there, and after it may come a map, such as \"1 s, map paper\"",
                             clause);
        first = false;
        if (span->ns <= 0) return fmt::format("\"{}\": the span must be above 0 s", clause);
        asked.span = *span;
        return "";
      });
  if (!error.empty()) return Failure(error);
  return asked;
}

}  // namespace evenstep
