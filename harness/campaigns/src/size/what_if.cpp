#include "evenstep/campaigns/what_if.h"

#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

#include <algorithm>
#include <charconv>
#include <cmath>

#include "clauses.h"
#include "evenstep/text/quantity.h"

namespace evenstep {
namespace {

constexpr Duration kFirstLook{2'000'000'000};  // what a simulator has seen of itself when it chooses its pace
constexpr int kLookBack = 2;
constexpr std::int64_t kMostParts = 1000;

using internal::trimmed;

Result<int> parse_count(std::string_view text, int least, const char* what) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || value < least || value > kMostParts)
    return Failure(fmt::format("\"{} {}\": a whole number from {} to {} must follow", what, text, least, kMostParts));
  return value;
}

constexpr const char* kOvers[] = {"skip", "hold", "merge"};

/// "" or why not.
std::string read_budget(std::string_view text, WhatIf& out) {
  std::string_view length = text;
  if (const std::size_t last = text.find_last_of(' '); last != std::string_view::npos) {
    const auto over = std::find(std::begin(kOvers), std::end(kOvers), text.substr(last + 1));
    if (over != std::end(kOvers)) {
      out.over_budget = static_cast<OverBudget>(over - std::begin(kOvers));
      length = trimmed(text.substr(0, last));
    }
  }
  const Result<Duration> budget = parse_duration(length);
  if (!budget) return fmt::format("\"budget {}\": {}; after it may come skip, hold or merge", text, budget.error());
  if (budget->ns <= 0) return fmt::format("\"budget {}\": must be above 0 s", text);
  out.budget = *budget;
  return {};
}

std::string read_pace(std::string_view text, WhatIf& out) {
  if (const Result<double> share = parse_si(text, Dimension::ratio); share && text.find('%') != std::string_view::npos) {
    if (*share <= 0 || *share > 1) return fmt::format("\"pace {}\": must be above 0 % and at most 100 %", text);
    out.pace_percentile = *share;
    return {};
  }
  if (const Result<Rate> rate = parse_rate(text)) {
    out.pace = Duration{instant_ns(*rate, 1)};
  } else if (const Result<Duration> period = parse_duration(text)) {
    out.pace = *period;
  } else {
    return fmt::format("\"pace {}\": a percentile such as \"90 %\", a period such as \"33 ms\" or a rate must follow", text);
  }
  return out.pace->ns > 0 ? "" : fmt::format("\"pace {}\": the period must be above 0 s", text);
}

std::string read_own_lane(std::string_view text, WhatIf& out) {
  out.own_lane = 1;
  if (text.empty()) return {};
  const Result<double> factor = parse_si(text, Dimension::none);
  if (!factor || *factor < 1 || *factor > 1000)
    return fmt::format("\"own-lane {}\": a factor from 1 to 1000 must follow, by which steps beside a drawing are slower",
                       text);
  out.own_lane = *factor;
  return {};
}

std::string read_clause(std::string_view clause, std::string_view name, std::string_view rest, WhatIf& out) {
  const auto count = [&](int least, const char* what, int& into) -> std::string {
    const Result<int> value = parse_count(rest, least, what);
    if (!value) return value.error();
    into = *value;
    return {};
  };
  if (name == "split") return count(2, "split", out.split);
  if (name == "forecast") return count(0, "forecast", out.forecast);
  if (name == "budget") return read_budget(rest, out);
  if (name == "pace") return read_pace(rest, out);
  if (name == "own-lane") return read_own_lane(rest, out);
  if (clause == "spread") {
    out.spread = true;
    return {};
  }
  return fmt::format("\"{}\" is none of spread, split, budget, forecast, pace and own-lane", clause);
}

/// Which clauses do not go together; empty if all do.
std::string objection(const WhatIf& what_if) {
  if (what_if.own_lane && (what_if.split > 1 || what_if.budget || what_if.pace || what_if.pace_percentile))
    return "own-lane goes with none of the others but spread: with a lane of their own, drawings make no pause";
  if (what_if.forecast > 0 && (!what_if.budget || what_if.over_budget == OverBudget::merge))
    return "forecast is for a budget with skip or hold; merge cuts a drawing off and needs none";
  return {};
}

double length_s(std::span<const SegmentTiming> segments) {
  RealTime end;
  for (const SegmentTiming& segment : segments)
    if (!segment.steps.empty()) end = std::max(end, segment.steps.back().end);
  return segments.empty() ? 0 : seconds(end - segments.front().begin);
}

bool any_drawing(std::span<const SegmentTiming> segments) {
  return std::any_of(segments.begin(), segments.end(), [](const SegmentTiming& s) { return s.visualization.has_value(); });
}

/// By how much a drawing begins later than the same one before; 0 if there are more or fewer.
Duration most_later(std::span<const SegmentTiming> segments, std::span<const SegmentTiming> before) {
  const auto begins = [](std::span<const SegmentTiming> timing) {
    std::vector<RealTime> out;
    for (const SegmentTiming& segment : timing)
      if (segment.visualization) out.push_back(segment.visualization->begin);
    return out;
  };
  const std::vector<RealTime> now = begins(segments), then = begins(before);
  Duration most;
  for (std::size_t i = 0; now.size() == then.size() && i < now.size(); ++i) most = std::max(most, now[i] - then[i]);
  return most;
}

bool any_overlap(std::span<const SegmentTiming> segments) {
  return std::any_of(segments.begin(), segments.end(), [](const SegmentTiming& segment) { return segment.overlaps(); });
}

std::vector<SegmentTiming> governed(std::span<const SegmentTiming> segments, const FrameGovernor& governor) {
  const auto timing = make_governed_replay({segments.begin(), segments.end()}, governor);
  std::vector<SegmentTiming> out;
  for (SegmentTiming segment; timing->next(segment);) out.push_back(segment);
  return out;
}

/// A run has no governor that knows the future, and refuses budgets that no pause needs.
bool is_for_a_run(const FrameGovernor& governor) {
  if (!governor.budget) return true;
  return *governor.budget <= kMostGovernedBudget && (governor.over_budget == OverBudget::merge || governor.forecast > 0);
}

/// The percentile of the times that the work of these segments takes, nearest rank.
Duration percentile_of_work(std::span<const SegmentTiming> segments, double share, std::optional<Duration> first) {
  std::vector<std::int64_t> work;
  for (const SegmentTiming& segment : segments) {
    if (first && !work.empty() && segment.begin > segments.front().begin + *first) break;
    if (!segment.steps.empty()) work.push_back((segment.end - segment.begin).ns);
  }
  const double rank = std::ceil(share * static_cast<double>(work.size()));
  const auto at = work.begin() + std::max<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(rank) - 1, 0);
  std::nth_element(work.begin(), at, work.end());
  return {*at};
}

/// Drawings in a lane of their own, see the header.
class OwnLane {
 public:
  OwnLane(std::span<const SegmentTiming> segments, double slowdown, bool spread)
      : given_(segments), slowdown_(slowdown), spread_(spread) {
    for (const SegmentTiming& segment : segments) {
      for (const Interval& step : segment.steps) {
        steps_.push_back(step);
        turns_.push_back(segment.begin);
      }
    }
  }

  std::vector<SegmentTiming> timing() {
    place_drawings();
    if (spread_) spread_turns();
    RealTime end = given_.front().begin;
    std::size_t k = 0;
    for (std::size_t n = 0; n < steps_.size(); ++n) {
      const RealTime begin = std::max(end, turns_[n]);
      while (k + 1 < out_.size() && out_[k + 1].begin <= begin) ++k;
      const Interval& given = steps_[n];
      const double length = static_cast<double>((given.end - given.begin).ns) * (beside(k, begin) ? slowdown_ : 1);
      end = begin + Duration{std::llround(length)};
      out_[k].steps.push_back({begin, end});
    }
    for (SegmentTiming& segment : out_) {
      segment.end = segment.visualization ? segment.visualization->end : segment.begin;
      if (!segment.steps.empty()) segment.end = std::max(segment.end, segment.steps.back().end);
    }
    while (!out_.empty() && out_.back().begin >= end) out_.pop_back();  // the steps have ended
    return std::move(out_);
  }

 private:
  void spread_turns() {
    const std::int64_t span = (steps_.back().begin - steps_.front().begin).ns, slots = std::ssize(steps_) - 1;
    for (std::int64_t n = 0; n <= slots; ++n)
      turns_[static_cast<std::size_t>(n)] = given_.front().begin + Duration{slots > 0 ? floor_mul_div(span, n, slots) : 0};
  }
  void place_drawings() {
    RealTime drawn = given_.front().begin;
    for (const SegmentTiming& given : given_) {
      SegmentTiming segment;
      segment.index = std::ssize(out_);
      segment.concurrent = true;
      segment.begin = out_.empty() ? given.begin : std::max(given.begin, drawn);
      if (!out_.empty() && segment.begin <= out_.back().begin) continue;
      drawn = segment.begin;
      if (given.visualization) {
        drawn = segment.begin + (given.visualization->end - given.visualization->begin);
        segment.visualization = Interval{segment.begin, drawn};
      }
      out_.push_back(std::move(segment));
    }
  }
  bool beside(std::size_t k, RealTime at) const {
    return out_[k].visualization && out_[k].visualization->begin <= at && at < out_[k].visualization->end;
  }

  std::span<const SegmentTiming> given_;
  double slowdown_;
  bool spread_;
  std::vector<Interval> steps_;
  std::vector<RealTime> turns_;  // of the steps
  std::vector<SegmentTiming> out_;
};

}  // namespace

Result<WhatIf> parse_what_if(std::string_view text) {
  WhatIf out;
  const std::string error =
      internal::each_clause(text, [&](std::string_view clause, std::string_view name, std::string_view rest) {
        return read_clause(clause, name, rest, out);
      });
  if (!error.empty()) return Failure(error);
  if (const std::string why = objection(out); !why.empty()) return Failure(why);
  return out;
}

std::string text_of(const WhatIf& what_if) {
  std::vector<std::string> clauses;
  if (what_if.spread) clauses.emplace_back("spread");
  const auto in_ms = [](Duration duration) { return fmt::format("{} ms", static_cast<double>(duration.ns) / 1e6); };
  if (what_if.split > 1) clauses.push_back(fmt::format("split {}", what_if.split));
  if (what_if.budget)
    clauses.push_back(fmt::format("budget {} {}", in_ms(*what_if.budget), kOvers[static_cast<int>(what_if.over_budget)]));
  if (what_if.forecast > 0) clauses.push_back(fmt::format("forecast {}", what_if.forecast));
  if (what_if.pace_percentile) clauses.push_back(fmt::format("pace {} %", 100 * *what_if.pace_percentile));
  if (what_if.pace) clauses.push_back(fmt::format("pace {}", in_ms(*what_if.pace)));
  if (what_if.own_lane) clauses.push_back(fmt::format("own-lane {}", *what_if.own_lane));
  return clauses.empty() ? "as it is" : fmt::format("{}", fmt::join(clauses, ", "));
}

std::optional<WhatIf> causal(const WhatIf& what_if) {
  WhatIf out = what_if;
  if (out.budget && out.over_budget != OverBudget::merge && out.forecast == 0) out.forecast = kLookBack;
  if (out == what_if && !what_if.pace_percentile) return std::nullopt;
  return out;
}

DrawingPrice price_of(std::span<const SegmentTiming> segments, std::span<const SegmentTiming> before,
                      std::optional<Duration> budget) {
  DrawingPrice price;
  if (segments.empty()) return price;
  RealTime drawn = segments.front().begin, end = drawn;
  const auto without_until = [&](RealTime at) {
    price.longest_without_drawing = std::max(price.longest_without_drawing, at - drawn);
    drawn = at;
  };
  for (const SegmentTiming& segment : segments) {
    price.left_out += segment.drawing.left_out ? 1 : 0;
    if (!segment.steps.empty()) end = std::max(end, segment.steps.back().end);
    if (!segment.visualization) continue;
    const Duration length = segment.visualization->end - segment.visualization->begin;
    if (!segment.overlaps()) price.longest_drawing_pause = std::max(price.longest_drawing_pause, length);
    price.over_budget += budget && length > *budget ? 1 : 0;
    if (!segment.drawing.finishes) continue;
    ++price.drawings;
    without_until(segment.visualization->end);
  }
  if (end > drawn) without_until(end);
  price.drawings_later = most_later(segments, before);
  const double now_s = length_s(segments), before_s = length_s(before);
  if (now_s <= 0) return price;
  price.drawings_per_s = static_cast<double>(price.drawings) / now_s;
  price.simulated_against_real = before_s / now_s;
  price.segments_lost = std::max(0.0, 1 - price.simulated_against_real);
  return price;
}

Result<WhatIfTiming> apply(const WhatIf& what_if, std::span<const SegmentTiming> segments, bool causally) {
  const auto has_steps = [](const SegmentTiming& segment) { return !segment.steps.empty(); };
  if (std::none_of(segments.begin(), segments.end(), has_steps)) return Failure(std::string("there is no step in it"));
  WhatIfTiming out;
  if (what_if == WhatIf{}) {
    out.segments.assign(segments.begin(), segments.end());
  } else if (any_overlap(segments)) {
    return Failure(std::string("drawings have a lane of their own already, and make no pause"));
  } else if (!any_drawing(segments) && (what_if.own_lane || what_if.budget)) {
    return Failure(std::string("it has no visualizations, so nobody knows which pauses are drawings"));
  } else if (what_if.own_lane) {
    out.segments = OwnLane(segments, *what_if.own_lane, what_if.spread).timing();
  } else {
    FrameGovernor governor{what_if.split,    what_if.budget, what_if.over_budget,
                           what_if.forecast, what_if.pace,   what_if.spread};
    out.segments = governed(segments, governor);
    if (what_if.pace_percentile) {
      const std::optional<Duration> first = causally ? std::optional(kFirstLook) : std::nullopt;
      out.pace = percentile_of_work(out.segments, *what_if.pace_percentile, first) * what_if.split;
      if (const auto grid = grid_period(segments)) out.pace = std::max(*out.pace, *grid);
      governor.pace = out.pace;
      out.segments = governed(segments, governor);
    }
    if (is_for_a_run(governor)) out.governor = governor;
  }
  out.price = price_of(out.segments, segments, what_if.budget);
  return out;
}

}  // namespace evenstep
