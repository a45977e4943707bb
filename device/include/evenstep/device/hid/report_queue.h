#pragma once
/// The queue between a device and its driver. It behaves like the real ones when nobody reads
/// (docs/devices/reference-device.md):
///
///   hidraw policy: 63 reports, the newest is dropped when full.   libusb policy: 32 reports, the oldest is dropped.

#include <algorithm>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>

namespace evenstep {

enum class QueuePolicy { hidraw, libusb };

template <class Report>
class ReportQueue {
 public:
  explicit ReportQueue(QueuePolicy policy) : policy_(policy) {}

  /// Makes room for reports that arrive one after the other while nobody reads, and says which of them will be kept: the
  /// first ones that fit (hidraw), or the last ones (libusb). Only these need to be appended, so a stall of any length costs
  /// no more work than filling the queue once.
  struct Kept {
    std::int64_t first, count;  ///< first: how many before the first kept one are dropped
  };
  Kept make_room(std::int64_t arriving) {
    const auto queued = static_cast<std::int64_t>(reports_.size());
    if (policy_ == QueuePolicy::hidraw) {
      const std::int64_t count = std::min(arriving, kHidrawDepth - queued);
      dropped_ += arriving - count;
      return {0, count};
    }
    const std::int64_t count = std::min(arriving, kLibusbDepth);
    const std::int64_t pushed_out = std::max<std::int64_t>(0, queued + count - kLibusbDepth);
    reports_.erase(reports_.begin(), reports_.begin() + pushed_out);
    dropped_ += pushed_out + arriving - count;
    return {arriving - count, count};
  }
  void append(Report report) { reports_.push_back(std::move(report)); }
  void push(Report report) {
    if (make_room(1).count == 1) append(std::move(report));
  }
  /// Takes out the oldest report.
  std::optional<Report> pop() {
    if (reports_.empty()) return std::nullopt;
    std::optional<Report> oldest(std::move(reports_.front()));
    reports_.pop_front();
    return oldest;
  }
  /// Reports that found the queue full, or were pushed out of it.
  std::int64_t dropped() const { return dropped_; }

 private:
  static constexpr std::int64_t kHidrawDepth = 63;
  static constexpr std::int64_t kLibusbDepth = 32;
  QueuePolicy policy_;
  std::deque<Report> reports_;
  std::int64_t dropped_ = 0;
};

}  // namespace evenstep
