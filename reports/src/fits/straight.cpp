#include "src/fits/straight.h"

#include <algorithm>

#include "src/judged.h"

namespace evenstep::internal {
namespace {

constexpr std::int64_t kNoPiece = -1;

/// The number of the straight piece that contains all of [from, to].
std::int64_t piece_of(const Nominal::Turns& turns, RealTime from, RealTime to) {
  const Duration since = from - turns.first;
  if (since.ns < 0) return kNoPiece;
  const Duration period = turns.straight + turns.turn;
  const std::int64_t piece = since.ns / period.ns;
  return to <= turns.first + period * piece + turns.straight ? piece : kNoPiece;
}

/// A read is made from the samples around it. The older sample may have been taken up to two periods before the read: it
/// came up to one period before the read, and was taken up to one period before it came.
std::int64_t piece_of_step(const StrategyRecord& strategy, const Nominal::Device& device, const StepRow& step) {
  const Duration period = period_ceil(device.rate);
  const RealTime oldest = std::min(step.read, step.begin) - period - period - strategy.interaction_memory;
  return piece_of(*device.turns, oldest, step.read + period);
}

Rows<std::int64_t> pieces_of_steps(const StrategyRecord& strategy, const Nominal::Device& device) {
  Rows<std::int64_t> pieces(strategy.steps.get_allocator());
  pieces.reserve(strategy.steps.size());
  for (const StepRow& step : strategy.steps) pieces.push_back(piece_of_step(strategy, device, step));
  return pieces;
}

/// Windows of neighbours i < count with the same `number(i)`; those without a number are in no window.
template <class Number>
std::vector<Window> runs_of(std::size_t count, Number number) {
  std::vector<Window> runs;
  std::int64_t last = kNoPiece;
  for (std::size_t i = 0; i < count; ++i) {
    const std::int64_t piece = number(i);
    if (piece != kNoPiece && piece == last)
      runs.back().end = i + 1;
    else if (piece != kNoPiece)
      runs.push_back({i, i + 1});
    last = piece;
  }
  return runs;
}

std::vector<Window> all_of(std::size_t count) { return count == 0 ? std::vector<Window>{} : std::vector{Window{0, count}}; }

/// The last step whose force is there at each of these instants, which must not decrease.
template <class At>
Rows<std::int64_t> last_steps(const StrategyRecord& strategy, std::size_t count, At at) {
  Rows<std::int64_t> last(count, kNoPiece, strategy.steps.get_allocator());
  std::int64_t next = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const auto there = [&](const StepRow& step) { return std::max(step.emission, step.end) <= at(i); };
    while (next < std::ssize(strategy.steps) && there(strategy.steps[static_cast<std::size_t>(next)])) ++next;
    last[i] = next - 1;
  }
  return last;
}

}  // namespace

Rows<std::int64_t> sent_steps(const StrategyRecord& strategy, const DeviceRecord& device) {
  return last_steps(strategy, device.ticks.size(), [&](std::size_t k) { return sent_at(device.ticks[k]); });
}

std::vector<Window> straight_steps(const StrategyRecord& strategy, const Nominal::Device* nominal,
                                   std::span<const std::size_t> steps) {
  if (!nominal || !nominal->turns) return all_of(steps.size());
  return runs_of(steps.size(), [&](std::size_t i) { return piece_of_step(strategy, *nominal, strategy.steps[steps[i]]); });
}

/// The force of a tick may be made from the step that it sends, the step before (while the sent one's force is late) and the
/// next step (the other end of the line between two forces). The hand itself must be on their piece too, because a force may
/// be corrected for where the hand is by now.
std::vector<Window> straight_ticks(const StrategyRecord& strategy, const DeviceRecord& device,
                                   const Nominal::Device* nominal, std::span<const std::size_t> ticks) {
  if (!nominal || !nominal->turns) return all_of(ticks.size());
  const Rows<std::int64_t> pieces = pieces_of_steps(strategy, *nominal);
  const auto at = [&](std::size_t i) { return sent_at(device.ticks[ticks[i]]); };
  const Rows<std::int64_t> newest = last_steps(strategy, ticks.size(), at);
  const Rows<std::int64_t> oldest =
      last_steps(strategy, ticks.size(), [&](std::size_t i) { return at(i) - strategy.force_memory; });
  const Duration period = period_ceil(nominal->rate);
  return runs_of(ticks.size(), [&](std::size_t i) {
    if (oldest[i] < 1) return kNoPiece;
    const auto first = static_cast<std::size_t>(oldest[i] - 1);
    const auto last = std::min(static_cast<std::size_t>(newest[i] + 1), pieces.size() - 1);
    const std::int64_t piece = piece_of(*nominal->turns, at(i) - period - period, at(i));
    return pieces[first] == piece && pieces[last] == piece ? piece : kNoPiece;
  });
}

}  // namespace evenstep::internal
