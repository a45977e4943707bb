#include "evenstep/reports/recovery.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>

#include "src/fits/straight.h"
#include "src/judged.h"
#include "src/vec3.h"

namespace evenstep {
namespace {

using State = Recovery::State;
using Over = ProgrammedFault::Over;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr Duration kLeastWindow{250'000'000};
constexpr std::int64_t kWindowSegments = 8;
// Cannot be felt, and far below what a map changes: matters only for signals that did not change before the first fault.
constexpr double kLeastJump_m = 1e-9, kLeastJump_N = 1e-6;

/// The samples of a signal before the first fault, and how large a jump may be after the last one.
class Jumps {
 public:
  Jumps(RealTime calm_end, double share, double least) : calm_end_(calm_end), share_(share), least_(least) {}

  /// Three samples in a row, the last of them at `at`. In order of time.
  void add(const Vec3& a, const Vec3& b, const Vec3& c, RealTime at) {
    const double jump = internal::norm(internal::minus(internal::minus(c, b), internal::minus(b, a)));
    if (at < calm_end_) {
      greatest_ = std::max(greatest_, jump);
      changes_ += internal::norm(internal::minus(c, b));
      ++count_;
    } else if (!(jump <= limit())) {  // true for a NaN too
      last_bad_ = std::max(last_bad_, at);
    }
  }
  bool calm() const { return count_ > 0; }
  RealTime last_bad() const { return last_bad_; }

 private:
  double limit() const { return greatest_ + std::max(share_ * changes_ / static_cast<double>(count_), least_); }

  RealTime calm_end_, last_bad_;
  double share_, least_, greatest_ = 0, changes_ = 0;
  std::int64_t count_ = 0;
};

/// The last instants at which a condition did not hold; 0: it always held after the first fault.
struct LastBad {
  std::array<RealTime, 3> of;
  bool calm = false;  ///< enough was judged before the first fault
};

RealTime last_underrun(const StrategyRecord& strategy, const DeviceRecord& device, RealTime from) {
  RealTime last;
  for (std::size_t n = 0; n < strategy.steps.size(); ++n) {
    const StepRow& step = strategy.steps[n];
    if (step.acquiring || device.steps[n].read == StepRead::underrun) last = std::max(last, step.begin);
    if (is_late(step, device)) last = std::max(last, step.end);
  }
  return last < from ? RealTime{} : last;
}

/// The latency is compared with that of the last `window` of the calm before the first fault; empty: with all of the calm.
RealTime last_late_tick(const RunRecord& run, const StrategyRecord& strategy, const DeviceRecord& device,
                        const Rows<std::size_t>& ticks, RealTime calm_end, std::optional<Duration> window) {
  const Rows<std::int64_t> sent = internal::sent_steps(strategy, device);
  Duration greatest;
  RealTime last;
  for (const std::size_t k : ticks) {
    if (sent[k] < 0) continue;
    const RealTime at = internal::sent_at(device.ticks[k]);
    const Duration age = at - strategy.steps[static_cast<std::size_t>(sent[k])].read;
    if (at >= calm_end) {
      if (age > greatest + run.nominal.recovery_latency) last = at;
    } else if (!window || at >= calm_end - *window) {
      greatest = std::max(greatest, age);
    }
  }
  return last;
}

/// The time of the last tick whose force met a limit that no force met before the first fault.
RealTime last_limited(const DeviceRecord& device, const Rows<std::size_t>& ticks, RealTime calm_end) {
  SaturationCauses usual;
  RealTime last;
  for (const std::size_t k : ticks) {
    const TickRow& tick = device.ticks[k];
    const unsigned met = tick.saturated.bits;
    if (internal::sent_at(tick) < calm_end)
      usual.bits = static_cast<std::uint8_t>(usual.bits | met);
    else if ((met & ~static_cast<unsigned>(usual.bits)) != 0)
      last = internal::sent_at(tick);
  }
  return last;
}

LastBad last_bad(const RunRecord& run, const StrategyRecord& strategy, const DeviceRecord& device, RealTime calm_end) {
  const Nominal& nominal = run.nominal;
  const Nominal::Device* named = internal::nominal_device(nominal, device.name);
  const Rows<std::size_t> steps = internal::judged_steps(strategy, nominal);
  const Rows<std::size_t> ticks = internal::judged_ticks(device, nominal);
  Jumps of_steps(calm_end, nominal.recovery_jump, kLeastJump_m), of_ticks(calm_end, nominal.recovery_jump, kLeastJump_N);
  for (const internal::Window& piece : internal::straight_steps(strategy, named, steps)) {
    for (std::size_t i = piece.begin + 2; i < piece.end; ++i)
      of_steps.add(device.steps[steps[i - 2]].position_m, device.steps[steps[i - 1]].position_m,
                   device.steps[steps[i]].position_m, strategy.steps[steps[i]].begin);
  }
  for (const internal::Window& piece : internal::straight_ticks(strategy, device, named, ticks)) {
    for (std::size_t i = piece.begin + 2; i < piece.end; ++i)
      of_ticks.add(device.ticks[ticks[i - 2]].force_N, device.ticks[ticks[i - 1]].force_N, device.ticks[ticks[i]].force_N,
                   internal::sent_at(device.ticks[ticks[i]]));
  }
  std::optional<Duration> window;
  if (strategy.latency.adapts) window = recovery_window(nominal);
  return {{last_underrun(strategy, device, calm_end), last_late_tick(run, strategy, device, ticks, calm_end, window),
           std::max({of_steps.last_bad(), of_ticks.last_bad(), last_limited(device, ticks, calm_end)})},
          of_steps.calm() && of_ticks.calm()};
}

Recovery without(State state, std::string why) {
  Recovery recovery;
  recovery.state = state;
  recovery.why = std::move(why);
  return recovery;
}

std::string at(RealTime time) { return fmt::format("{:.6g} s", seconds(time)); }

/// When the first fault begins and the last one ends; or a fault that is not over at the end.
struct Span {
  RealTime from, to;
  const ProgrammedFault* open = nullptr;
};
Span span_of(const Nominal& nominal, const StrategyRecord& strategy) {
  Span span{nominal.faults.front().from, {}, nullptr};
  for (const ProgrammedFault& fault : nominal.faults) {
    span.from = std::min(span.from, fault.from);
    const std::optional<RealTime> end = fault_end(fault, strategy.segments);
    if (end)
      span.to = std::max(span.to, *end);
    else if (!span.open || fault.over == Over::never)
      span.open = &fault;
  }
  return span;
}

/// Which conditions do not hold at the end of a run that never recovers.
std::string unhealed(const Recovery& recovery) {
  constexpr std::array kWhat{"a sample is missing or a force late",
                             "the latency is above what it was before the first fault",
                             "a signal jumps, or is limited, more than before the first fault"};
  std::string text;
  for (std::size_t part = 0; part < kWhat.size(); ++part) {
    if (recovery.part_s[part] == kInfinity) text += (text.empty() ? "" : "; ") + std::string(kWhat[part]);
  }
  return text;
}

}  // namespace

std::optional<RealTime> fault_end(const ProgrammedFault& fault, const Rows<SegmentRow>& segments) {
  if (fault.over == Over::at_time) return fault.to;
  if (fault.over == Over::never) return std::nullopt;
  for (const SegmentRow& segment : segments) {
    if (segment.begin >= fault.to) return fault.over == Over::with_segment ? segment.begin : segment.end;
  }
  return std::nullopt;
}

Duration recovery_window(const Nominal& nominal) { return std::max(kLeastWindow, nominal.segment * kWindowSegments); }

double Recovery::time_s() const { return *std::max_element(part_s.begin(), part_s.end()); }

Recovery recovery_of(const RunRecord& run, const StrategyRecord& strategy, std::size_t device) {
  const Nominal& nominal = run.nominal;
  if (nominal.faults.empty()) return without(State::no_fault, "no fault is programmed, so there is nothing to recover from");
  const Span span = span_of(nominal, strategy);
  if (span.open && span.open->over != Over::never)
    return without(State::too_short, fmt::format("the run must last longer: {} is not over when it ends", span.open->name));
  if (span.open) {
    Recovery recovery = without(State::never, fmt::format("never: {} lasts until the end of the run", span.open->name));
    recovery.part_s.fill(kInfinity);
    return recovery;
  }
  const Duration window = recovery_window(nominal);
  const auto too_short = [&](Duration after) {
    return without(State::too_short, fmt::format("the run must last at least {}: its last fault is over at {}",
                                                 at(span.to + after), at(span.to)));
  };
  if (nominal.end - span.to < window) return too_short(window);
  const LastBad last = last_bad(run, strategy, strategy.devices[device], span.from);
  if (!last.calm || span.from - nominal.judged_from < window)
    return without(
        State::no_calm,
        fmt::format("nothing to compare with: the first fault begins at {}, and must not before {}, which is {:.6g} "
                    "s after the warm-up",
                    at(span.from), at(nominal.judged_from + window), seconds(window)));
  Recovery recovery;
  recovery.state = State::recovered;
  recovery.faults_end = span.to;
  recovery.watched = nominal.end - window - span.to;
  for (std::size_t part = 0; part < last.of.size(); ++part) {
    const bool unhealed_at_end = last.of[part] > nominal.end - window;
    recovery.part_s[part] = unhealed_at_end ? kInfinity : std::max(0.0, seconds(last.of[part] - span.to));
  }
  if (recovery.time_s() < kInfinity) return recovery;
  if (nominal.end - span.to < window * 2) return too_short(window * 2);
  recovery.state = State::never;
  recovery.why = fmt::format("never, within {:.6g} s: {}", seconds(recovery.watched), unhealed(recovery));
  return recovery;
}

}  // namespace evenstep
