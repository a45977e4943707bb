#include "evenstep/device/device_clock.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace evenstep {
namespace {

constexpr std::int64_t kBlock_ns = 500'000'000;
constexpr std::size_t kBlocks = 128;
constexpr std::int64_t kMostSlope = 100;  // 1 / 100
constexpr Duration kSetForward{50'000'000}, kSetBack{100'000'000};
constexpr Duration kOldestReport{1'000'000'000};

/// Whether a, b, c turn left: b lies below the line from a to c.
template <class Point>
bool is_below(const Point& a, const Point& b, const Point& c) {
  const auto dx1 = static_cast<__int128>(b.device_ns - a.device_ns), dx2 = static_cast<__int128>(c.device_ns - a.device_ns);
  return dx1 * (c.offset_ns - a.offset_ns) > dx2 * (b.offset_ns - a.offset_ns);
}

/// The edge of the lower hull of the points, which are sorted, that spans their mean device time.
template <class Points, class Point = typename Points::value_type>
std::pair<Point, Point> edge_over_mean(const Points& points) {
  std::vector<Point> hull;
  hull.reserve(points.size());
  std::int64_t sum_ns = 0;
  for (const Point& point : points) {
    sum_ns += point.device_ns - points.front().device_ns;  // at most 256 * 64 s, or a gap in the reports: years
    while (hull.size() >= 2 && !is_below(hull[hull.size() - 2], hull.back(), point)) hull.pop_back();
    hull.push_back(point);
  }
  const std::int64_t mean_ns = points.front().device_ns + sum_ns / static_cast<std::int64_t>(points.size());
  std::size_t end = 1;
  while (end + 1 < hull.size() && hull[end].device_ns < mean_ns) ++end;
  return {hull[end - 1], hull[end]};
}

}  // namespace

RealTime DeviceClock::taken(std::uint32_t stamp_us, RealTime read) {
  // Modulo 2^32, so that it may wrap around; a stamp that is more than 35 minutes ahead looks like one that is behind.
  const auto ahead_us = static_cast<std::int32_t>(stamp_us - std::exchange(last_stamp_us_, stamp_us));
  if (ahead_us < 0) restart();
  if (running_) {
    device_ns_ += std::int64_t{ahead_us} * 1000;
    if (device_ns_ - block_begin_ns_ >= kBlock_ns) fit();
  }
  if (running_ && device_ns_ + followed() - read.ns > kSetForward.ns) restart();
  if (!running_) begin(read);
  note({device_ns_, read.ns - device_ns_});
  return in_order(RealTime{device_ns_ + followed()}, read) - least_age_;
}

void DeviceClock::restart() {
  if (running_) ++ages_.restarts;
  running_ = false;
}

void DeviceClock::begin(RealTime read) {
  running_ = true;
  device_ns_ = 0;
  line_ = {{0, read.ns}};
  gap_ns_ = 0;
  blocks_.clear();
  begin_block();
}

void DeviceClock::begin_block() {
  block_begin_ns_ = device_ns_;
  block_.reset();
}

std::int64_t DeviceClock::followed() const {
  const std::int64_t left_ns = kBlock_ns - (device_ns_ - gap_from_ns_);
  return line_.at(device_ns_) + (left_ns > 0 ? floor_mul_div(gap_ns_, left_ns, kBlock_ns) : 0);
}

void DeviceClock::note(Point point) {
  if (!block_) block_ = {point, point};
  if (point.offset_ns < block_->first.offset_ns) block_->first = point;
  if (point.offset_ns <= block_->first.offset_ns) block_->last = point;

  const std::int64_t ahead_ns = followed() - point.offset_ns;
  if (ahead_ns <= 0) return;
  ++ages_.ahead;
  ages_.ahead_max = std::max(ages_.ahead_max, Duration{ahead_ns});
  const std::int64_t above_line_ns = point.offset_ns - line_.at(device_ns_);
  line_.through.offset_ns += std::min<std::int64_t>(above_line_ns, 0);
  gap_ns_ = std::max<std::int64_t>(above_line_ns, 0);
  gap_from_ns_ = device_ns_;
}

/// At the end of a block: fits the line below the lowest points of the last blocks.
void DeviceClock::fit() {
  if (!block_) return;
  if (block_->first.offset_ns - line_.at(block_->first.device_ns) > kSetBack.ns) return restart();
  const std::int64_t before_ns = followed();
  blocks_.push_back(*block_);
  if (blocks_.size() > kBlocks) blocks_.pop_front();
  std::vector<Point> lowest;
  for (const auto& [first, last] : blocks_) {
    lowest.push_back(first);
    if (last.device_ns > first.device_ns) lowest.push_back(last);
  }
  line_ = line_below(lowest);
  gap_ns_ = before_ns - line_.at(device_ns_);
  gap_from_ns_ = device_ns_;
  ages_.clock_rate_error = static_cast<double>(-line_.rise_ns) / static_cast<double>(line_.run_ns);
  std::int64_t most_ns = 0;
  for (const Point& point : lowest) most_ns = std::max(most_ns, point.offset_ns - line_.at(point.device_ns));
  ages_.residual = Duration{most_ns};
  begin_block();
}

DeviceClock::Line DeviceClock::line_below(const std::vector<Point>& points) {
  if (points.size() == 1) return {points.front()};
  const auto [a, b] = edge_over_mean(points);
  Line line{a, b.offset_ns - a.offset_ns, b.device_ns - a.device_ns};
  const std::int64_t most_ns = line.run_ns / kMostSlope;
  if (line.rise_ns >= -most_ns && line.rise_ns <= most_ns) return line;
  line.rise_ns = std::clamp(line.rise_ns, -most_ns, most_ns);
  for (const Point& point : points)
    line.through.offset_ns += std::min<std::int64_t>(0, point.offset_ns - line.at(point.device_ns));
  return line;
}

/// Its times are those before the least age is subtracted.
RealTime DeviceClock::in_order(RealTime taken, RealTime read) {
  RealTime least = read - kOldestReport;
  if (last_taken_) least = std::max(least, std::min(*last_taken_ + Duration{1}, read));
  if (taken < least) {
    ++ages_.capped;
    taken = least;
  }
  last_taken_ = taken;
  return taken;
}

}  // namespace evenstep
