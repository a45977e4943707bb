#include "evenstep/remap/jump_bound.h"

#include <algorithm>
#include <cassert>
#include <vector>

#include "evenstep/remap/buffer_oracle.h"

namespace evenstep {
namespace {

/// Where the path can be, and how far it came with its last step; both in fractions of a ns.
struct State {
  std::int64_t read = 0;
  std::int64_t velocity = 0;
  friend bool operator==(State a, State b) { return a.read == b.read && a.velocity == b.velocity; }
};

enum class Round { down, up };

/// a + (b - a) (at - from) / (to - from), for at between from and to.
std::int64_t between(std::int64_t a, std::int64_t b, std::int64_t at, std::int64_t from, std::int64_t to, Round round) {
  __int128 rise = static_cast<__int128>(b - a) * (at - from);
  __int128 run = to - from;
  if (run < 0) {
    rise = -rise;
    run = -run;
  }
  __int128 whole = rise / run;
  const __int128 rest = rise % run;
  if (round == Round::up && rest > 0) ++whole;
  if (round == Round::down && rest < 0) --whole;
  return a + static_cast<std::int64_t>(whole);
}

/// The states that a path can be in, as the corners of a convex polygon, counter-clockwise.
class Reachable {
 public:
  Reachable(State low, State high) : corners_{low, {high.read, low.velocity}, high, {low.read, high.velocity}} {}

  bool empty() const { return corners_.empty(); }
  void step(std::int64_t jump);
  void read_from(std::int64_t least) {
    cut([=](State s) { return s.read - least; }, {least, 0}, &State::velocity, Round::down);
  }
  void read_to(std::int64_t most) {
    cut([=](State s) { return most - s.read; }, {most, 0}, &State::velocity, Round::up);
  }
  void never_step_back() {
    cut([](State s) { return s.velocity; }, {}, &State::read, Round::up);
  }

 private:
  template <class Inside>
  void cut(Inside inside, State on_cut, std::int64_t State::*along, Round leaving);
  void add(State corner) {
    if (next_.empty() || !(next_.back() == corner)) next_.push_back(corner);
  }

  std::vector<State> corners_, next_;
};

/// All states one step on, for every change of the velocity from -jump to jump.
void Reachable::step(std::int64_t jump) {
  for (State& one : corners_) one.read += one.velocity;
  // The polygon is swept along (1, 1): corners on the side of larger read and velocity move by +jump, the others by -jump,
  // and the two that lie furthest to either side of that direction do both.
  const auto across = [](State a, State b) { return a.velocity - a.read < b.velocity - b.read; };
  const auto [right, left] = std::minmax_element(corners_.begin(), corners_.end(), across);
  const auto moved = [&](State corner, std::int64_t by) { return State{corner.read + by, corner.velocity + by}; };
  next_.clear();
  const auto sweep = [&](auto from, auto to, std::int64_t by) {
    add(moved(*from, by));
    while (from != to) {
      if (++from == corners_.end()) from = corners_.begin();
      add(moved(*from, by));
    }
  };
  sweep(right, left, jump);
  sweep(left, right, -jump);
  std::swap(corners_, next_);
}

/// Keeps the part in which `inside`, a linear function, is not negative. The two new corners are rounded `along` the cut
/// towards each other. Where they would pass each other, the polygon is thinner than a fraction, and its last corners are
/// kept instead.
template <class Inside>
void Reachable::cut(Inside inside, State on_cut, std::int64_t State::*along, Round leaving) {
  const auto count = corners_.size();
  const auto before = [&](std::size_t i) { return corners_[i == 0 ? count - 1 : i - 1]; };
  std::size_t first = count;  // inside, and the corner before it is not
  bool some_inside = false;
  for (std::size_t i = 0; i < count; ++i) {
    if (inside(corners_[i]) < 0) continue;
    some_inside = true;
    if (inside(before(i)) < 0) first = i;
  }
  if (first == count) {
    if (!some_inside) corners_.clear();
    return;
  }
  const auto crossing = [&](State a, State b, Round round) {
    State at = on_cut;
    at.*along = between(a.*along, b.*along, 0, inside(a), inside(b), round);
    return at;
  };
  std::rotate(corners_.begin(), corners_.begin() + static_cast<std::ptrdiff_t>(first), corners_.end());
  std::size_t inner = 1;
  while (inner < count && inside(corners_[inner]) >= 0) ++inner;
  const State leaves = crossing(corners_[inner - 1], corners_[inner], leaving);
  const State enters = crossing(corners_[0], corners_[count - 1], leaving == Round::up ? Round::down : Round::up);
  corners_.resize(inner);
  const bool passed = leaving == Round::up ? leaves.*along > enters.*along : leaves.*along < enters.*along;
  if (passed) return;
  for (const State corner : {leaves, enters})
    if (!(corners_.back() == corner) && !(corners_.front() == corner)) corners_.push_back(corner);
}

/// The tube in fractions of a ns, and whether a path goes through it.
class Tube {
 public:
  Tube(std::span<const StepTimes> steps, Duration jump) : steps_(steps) {
    const std::int64_t span_ns = (steps.back().end - steps.front().begin).ns + jump.ns;
    while (bits_ > 0 && span_ns > (std::int64_t{1} << (60 - bits_))) --bits_;
    jump_ = fractions(jump);
    fastest_ = fractions(Duration{span_ns});
  }

  bool has_path(Duration latency) const {
    for (const StepTimes& step : steps_)
      if (step.end - latency > step.begin) return false;
    Reachable states({low(0, latency), 0}, {high(0), fastest_});
    for (std::size_t n = 1; n < steps_.size() && !states.empty(); ++n) {
      states.step(jump_);
      states.read_from(low(n, latency));
      states.read_to(high(n));
      states.never_step_back();
    }
    return !states.empty();
  }

 private:
  std::int64_t fractions(Duration time) const { return time.ns * (std::int64_t{1} << bits_); }
  std::int64_t low(std::size_t n, Duration latency) const {
    return fractions(steps_[n].end - latency - steps_.front().begin);
  }
  std::int64_t high(std::size_t n) const { return fractions(steps_[n].begin - steps_.front().begin); }

  std::span<const StepTimes> steps_;
  int bits_ = 24;
  std::int64_t jump_ = 0;
  std::int64_t fastest_ = 0;
};

}  // namespace

Duration least_latency_with_jump(std::span<const StepTimes> steps, Duration jump) {
  if (steps.empty()) return {};
  const Tube tube(steps, jump);
  // The rounded best line has jumps of up to 2 ns, so if a smaller jump is allowed it may just miss its own tube.
  Duration enough = best_line(steps).latency;
  Duration too_little = least_path(steps).latency - Duration{1};
  while (enough - too_little > Duration{1}) {
    const Duration middle = too_little + Duration{(enough - too_little).ns / 2};
    (tube.has_path(middle) ? enough : too_little) = middle;
  }
  return enough;
}

Duration pause_bound(std::span<const StepTimes> steps, Duration slot) {
  PauseBound bound(slot);
  for (const StepTimes& step : steps) bound.add(step.begin, step.end);
  return bound.latency();
}

Duration pauses_bound(std::span<const StepTimes> steps, Duration slot, Duration jump) {
  // How far the end of a step is behind even slots that go on from the first begin; and the most that any from it on is.
  std::vector<std::int64_t> behind_ns;
  for (const StepTimes& step : steps)
    behind_ns.push_back((step.end - steps.front().begin).ns - std::ssize(behind_ns) * slot.ns);
  std::vector<std::int64_t> most_behind_ns = behind_ns;
  for (std::size_t n = steps.size(); n-- > 1;) most_behind_ns[n - 1] = std::max(most_behind_ns[n - 1], most_behind_ns[n]);
  Duration most;
  for (std::size_t n = 0; n < steps.size(); ++n) {
    const std::int64_t read_ns = behind_ns[n] - (steps[n].end - steps[n].begin).ns;
    std::int64_t caught_up_ns = 0, faster_ns = 0;
    for (std::size_t m = n; m < steps.size() && most_behind_ns[m] - read_ns - caught_up_ns > most.ns; ++m) {
      most.ns = std::max(most.ns, behind_ns[m] - read_ns - caught_up_ns);
      faster_ns += 2 * jump.ns;
      caught_up_ns += faster_ns;
    }
  }
  return most;
}

}  // namespace evenstep
