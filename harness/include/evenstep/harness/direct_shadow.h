#pragma once
/// What strategy `direct` would make of the same hand, beside a live run of another strategy.
///
///   hand     what step n would have read: the newest sample that was there for it, instead of the one at R(n)
///   force    what the scene answers to these hands, from the end of the step on, and through a guard like the device's
///
/// The hand is exact. The force is there only if a step of the scene costs next to nothing (a tissue would need a second
/// solver beside the one that has to be in time), and if the device plays the scheduled force itself. Nobody feels it: where
/// the hand gives way to the force, the hand still moves as the force of the live strategy has made it move.

#include <array>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/device/force_guard.h"
#include "evenstep/format/scenario.h"
#include "evenstep/loop/loop_watch.h"
#include "evenstep/sim/solver.h"

namespace evenstep {

struct ShadowedTick {
  SeenTick tick;
  std::optional<glm::dvec3> direct_N;
};
struct ShadowedStep {
  SeenStep step;
  std::array<glm::dvec3, kMaxTools> direct_m{};
};

class DirectShadow {
 public:
  /// `scenario` with the guards of real devices.
  explicit DirectShadow(const Scenario& scenario);
  /// Why there is no force of device `tool`, for people; empty: there is one.
  std::string no_force(std::size_t tool) const;
  void add(const SeenTick& tick);
  void add(const SeenStep& step);
  /// Takes what ran before `until` and was not taken yet, in the order in which it ran. Choose `until` far enough back that
  /// both lanes have shown all that they did up to then; whatever is shown later than that is taken late.
  template <class UseTick, class UseStep>
  void take(RealTime until, const UseTick& use_tick, const UseStep& use_step) {
    while (const auto next = earliest(until)) {
      if (*next == Row::step) {
        use_step(shadow(steps_.front()));
        steps_.pop_front();
      } else {
        use_tick(shadow(ticks_.front()));
        ticks_.pop_front();
      }
    }
  }

 private:
  enum class Row { tick, step };
  struct Tool {
    ForceGuard guard;
    bool plays_scheduled = false;
    std::deque<DeviceSample> samples;  // the newest last
  };
  std::optional<Row> earliest(RealTime until) const;
  ShadowedTick shadow(const SeenTick& tick);
  ShadowedStep shadow(const SeenStep& step);

  std::vector<Tool> tools_;
  bool live_is_direct_;
  std::unique_ptr<Solver> solver_;  // null: it costs too much
  std::array<glm::dvec3, kMaxTools> force_N_{};
  std::optional<RealTime> due_;
  std::deque<SeenTick> ticks_;
  std::deque<SeenStep> steps_;
};

}  // namespace evenstep
