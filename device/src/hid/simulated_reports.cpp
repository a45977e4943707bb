#include "evenstep/device/hid/simulated_reports.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <utility>

#include "evenstep/device/looked_for.h"

namespace evenstep {
namespace {

constexpr std::byte kUnknownId{0xFF};
constexpr std::byte kFiller{0xEE};

/// The newest tick at or before `at`; -1 or less if there is none.
std::int64_t newest_tick(const SimulatedDeviceOptions& options, RealTime at) {
  return first_tick_at_or_after(options.rate, at + Duration{1}, options.first_tick) - 1;
}

}  // namespace

HidRead deliver(const SimulatedReport& report, std::span<const std::byte> whole, std::span<std::byte> buffer) {
  using Shape = SimulatedReport::Shape;
  std::size_t size = whole.size();
  if (report.shape == Shape::cut) size = std::min(size, static_cast<std::size_t>(report.bytes));
  const std::size_t copied = std::min(size, buffer.size());
  std::copy_n(whole.begin(), copied, buffer.begin());
  if (report.shape == Shape::longer) {
    size += static_cast<std::size_t>(report.bytes);
    std::fill(buffer.begin() + static_cast<std::ptrdiff_t>(copied),
              buffer.begin() + static_cast<std::ptrdiff_t>(std::min(size, buffer.size())), kFiller);
  }
  if (report.shape == Shape::unknown_id && copied > 0) buffer[0] = kUnknownId;
  return {HidRead::Status::report, size};
}

SimulatedReports::SimulatedReports(HeldBy by, SimulatedDeviceOptions options)
    : options_(std::move(options)), queue_(options_.queue) {
  if (auto* const hand = std::get_if<Hand>(&by)) {
    assert(options_.force_delay.ns >= 0);
    hand_ = std::move(*hand);
  } else {
    motion_ = std::get<ProgrammedMotion>(std::move(by));
  }
  // At most one report per ns; otherwise two ticks would fall on the same instant.
  assert(options_.rate.num > 0 && options_.rate.den > 0 && options_.rate.num / options_.rate.den <= 1'000'000'000);
  std::stable_sort(options_.faults.begin(), options_.faults.end(),
                   [](const ReportFault& a, const ReportFault& b) { return a.tick < b.tick; });
  for (const ReportFault& fault : options_.faults) {
    assert(fault.tick >= 0 && fault.amount >= (fault.kind == ReportFault::Kind::late ? 1 : 0));
  }
}

glm::dvec3 SimulatedReports::position_m(RealTime at) {
  if (!hand_) return evenstep::position_m(motion_, at);
  if (has_let_go_) return hand_m_;
  try {
    return hand_m_ = hand_->position_m(at);
  } catch (const HandDiverged& diverged) {
    has_let_go_ = true;
    throw HandDiverged(options_.name + ": " + diverged.what(), diverged.at);
  }
}

glm::dvec3 SimulatedReports::position_at(std::int64_t tick) {
  return position_m(tick_time(options_.rate, tick, options_.first_tick));
}

void SimulatedReports::feel(RealTime now, const glm::dvec3& force_N) {
  if (hand_ && !has_let_go_) hand_->feel(now + options_.force_delay, force_N);
}

void SimulatedReports::advance(RealTime now) {
  const std::int64_t newest = newest_tick(options_, now);
  if (options_.unplug_at_tick >= 0 && newest >= options_.unplug_at_tick && !was_lost_) lose();
  if (is_away()) return look_for_device(now);
  if (is_gone()) return;
  while (next_tick_ <= newest) {
    const std::int64_t event = next_event();
    if (event == next_tick_)
      make_faulty_tick(next_tick_++);
    else if (options_.age)
      make_aged_tick(next_tick_++);
    else
      make_ticks(std::min(newest, event - 1));
  }
  deliver_until(now);
}

void SimulatedReports::lose() {
  was_lost_ = true;
  lost_at_ = tick_time(options_.rate, options_.unplug_at_tick, options_.first_tick);
  presence_ = Presence::gone;
  if (options_.return_at_tick < 0) return;
  presence_ = Presence::away;
  plugged_at_ = tick_time(options_.rate, options_.return_at_tick, options_.first_tick);
  found_at_ = found_again(lost_at_, plugged_at_);
  feel(lost_at_, glm::dvec3(0));
}

/// Reports and faults of the time in which the device was away are dropped: nobody was there to see them.
void SimulatedReports::look_for_device(RealTime now) {
  if (!found_at_ && now > lost_at_ + kPatience) presence_ = Presence::gone;
  if (!found_at_ || now < *found_at_) return;
  presence_ = Presence::here;
  returned_ = true;
  while (queue_.pop()) {
  }
  late_.clear();
  under_way_.clear();
  interruptions_ = writes_to_lose_ = writes_to_reject_ = writes_to_refuse_ = 0;
  next_tick_ = first_tick_at_or_after(options_.rate, *found_at_, options_.first_tick);
  while (next_fault_ < options_.faults.size() && options_.faults[next_fault_].tick < next_tick_) ++next_fault_;
}

void SimulatedReports::make_aged_tick(std::int64_t tick) { send({tick, position_at(tick)}, tick); }

void SimulatedReports::send(const SimulatedReport& report, std::int64_t tick) {
  if (!options_.age) return queue_.push(report);
  const RealTime due = tick_time(options_.rate, tick, options_.first_tick) + options_.age(report.tick);
  under_way_.push_back({under_way_.empty() ? due : std::max(due, under_way_.back().due), report});
}

void SimulatedReports::deliver_until(RealTime now) {
  for (; !under_way_.empty() && under_way_.front().due <= now; under_way_.pop_front())
    queue_.push(under_way_.front().report);
}

std::int64_t SimulatedReports::next_event() const {
  std::int64_t event = std::numeric_limits<std::int64_t>::max();
  if (next_fault_ < options_.faults.size()) event = options_.faults[next_fault_].tick;
  return late_.empty() ? event : std::min(event, late_.front().due);
}

/// Nothing is read between two calls, so which ticks the queue keeps can be computed. However long a stall is, it takes no
/// more work than filling the queue once; but a hand must be moved through all that time.
void SimulatedReports::make_ticks(std::int64_t last) {
  const auto kept = queue_.make_room(last - next_tick_ + 1);
  const std::int64_t first = next_tick_ + kept.first;
  for (std::int64_t tick = first; tick < first + kept.count; ++tick) queue_.append({tick, position_at(tick)});
  if (hand_) position_at(last);  // the hand moves on even if the report is dropped
  next_tick_ = last + 1;
}

void SimulatedReports::make_faulty_tick(std::int64_t tick) {
  using Kind = ReportFault::Kind;
  SimulatedReport report{tick, position_at(tick)};
  std::int64_t copies = 1, delay = 0;
  bool lost = false;
  for (; next_fault_ < options_.faults.size() && options_.faults[next_fault_].tick == tick; ++next_fault_) {
    const ReportFault& fault = options_.faults[next_fault_];
    switch (fault.kind) {
      case Kind::lost:
        lost = true;
        break;
      case Kind::duplicated:
        copies += fault.amount;
        break;
      case Kind::late:
        delay = fault.amount;
        break;
      case Kind::cut:
        report.shape = SimulatedReport::Shape::cut, report.bytes = fault.amount;
        break;
      case Kind::longer:
        report.shape = SimulatedReport::Shape::longer, report.bytes = fault.amount;
        break;
      case Kind::unknown_id:
        report.shape = SimulatedReport::Shape::unknown_id;
        break;
      case Kind::interrupted:
        interruptions_ += fault.amount;
        break;
      case Kind::unread:
        unread_tick_ = tick;
        break;
      case Kind::write_lost:
        writes_to_lose_ += fault.amount;
        break;
      case Kind::write_rejected:
        writes_to_reject_ += fault.amount;
        break;
      case Kind::write_refused:
        writes_to_refuse_ += fault.amount;
        break;
    }
  }
  for (std::int64_t copy = 0; copy < copies && !lost; ++copy) {
    if (delay == 0) {
      send(report, tick);
      continue;
    }
    const auto after = std::upper_bound(late_.begin(), late_.end(), tick + delay,
                                        [](std::int64_t due, const Late& late) { return due < late.due; });
    late_.insert(after, {tick + delay, report});
  }
  while (!late_.empty() && late_.front().due == tick) {
    send(late_.front().report, tick);
    late_.erase(late_.begin());
  }
}

HidWrite SimulatedReports::write_fault(bool& lost) {
  lost = false;
  if (writes_to_reject_ > 0) return --writes_to_reject_, HidWrite::rejected;
  if (writes_to_refuse_ > 0) return --writes_to_refuse_, ++refused_later_, lost = true, HidWrite::ok;
  if (writes_to_lose_ > 0) --writes_to_lose_, lost = true;
  return HidWrite::ok;
}

}  // namespace evenstep
