
#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "catch.h"
#include "evenstep/device/force_guard.h"
#include "units.h"
#include "vectors.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Uniform in [-1, 1), from the generator's bits alone.
double uniform(std::mt19937_64& random) { return static_cast<double>(static_cast<std::int64_t>(random())) * 0x1p-63; }

/// A force of any size from 1e-20 to 1e308, sometimes along an axis, sometimes not finite.
glm::dvec3 any_force(std::mt19937_64& random) {
  const double size =
      std::pow(10, random() % 4 ? static_cast<double>(random() % 5) - 1 : static_cast<double>(random() % 328) - 20);
  glm::dvec3 force{size * uniform(random), size * uniform(random), size * uniform(random)};
  if (random() % 8 == 0) force = glm::dvec3(0, 0, force.z);
  if (random() % 16 == 0) force[static_cast<int>(random() % 3)] = random() % 2 ? kNaN : -kInfinity;
  return force;
}

}  // namespace

namespace {
/// A tick whose schedule has a force; where the hand is does not matter.
const GuardedTick kWithForce{{}, RealTime{0}};
}  // namespace

TEST_CASE("a force within the limits passes bit for bit, 100,000 random ones") {
  std::mt19937_64 random(1);
  ForceGuard guard({100, 1e6});  // 1000 N per tick: any change within the ball
  guard.pass(RealTime{0}, glm::dvec3(0), kWithForce);
  for (std::int64_t tick = 1; tick <= 100'000; ++tick) {
    glm::dvec3 wanted{uniform(random), uniform(random), uniform(random)};
    wanted *= std::pow(10, static_cast<double>(random() % 40) - 38) * 5;  // up to 50 sqrt(3) N, and tiny ones
    if (tick % 100 == 0) wanted = glm::dvec3(-0.0, 0.0, -0.0);
    REQUIRE(same_bits(guard.pass(RealTime{tick * kMs}, wanted, kWithForce), wanted));
  }
  CHECK((guard.counters().clamped == 0 && guard.counters().slewed == 0 && guard.counters().non_finite == 0));
}

TEST_CASE("whatever is wanted, length and change stay within the limits, 100,000 random calls of 100 guards") {
  std::mt19937_64 random(2);
  for (int run = 0; run < 100; ++run) {
    const ForceLimits limits{std::pow(10, 3 * uniform(random)), std::pow(10, 3 + 3 * uniform(random))};
    ForceGuard guard(limits);
    RealTime now{static_cast<std::int64_t>(random() % 1000)};
    glm::dvec3 last(0);
    RealTime last_at = now;
    for (int call = 0; call < 1000; ++call) {
      const glm::dvec3 wanted = any_force(random);
      const glm::dvec3 sent = guard.pass(now, wanted, kWithForce);
      // The direction, its length and the scaling round at most 8 times, by 2^-53 each, and so does hypot here: 8 epsilon.
      REQUIRE(length(sent) <= limits.max_N * (1 + 8 * kEpsilon));
      // The sum of `last` and the change rounds once more per component, with numbers up to max_N.
      const double allowed_N = limits.max_slew_N_per_s * seconds(now - last_at);
      REQUIRE(length(sent - last) <= allowed_N * (1 + 8 * kEpsilon) + 2 * kEpsilon * limits.max_N);
      // A second call at the same instant changes nothing, neither with the same wish nor with the force that was sent.
      REQUIRE(guard.pass(now, wanted, kWithForce) == sent);
      REQUIRE(guard.pass(now, sent, kWithForce) == sent);
      last = sent;
      last_at = now;
      now = now + Duration{static_cast<std::int64_t>(random() % (2 * kMs)) * static_cast<std::int64_t>(random() % 4)};
    }
  }
}

TEST_CASE("a clamped force keeps its direction and has the largest length, not zero") {
  std::mt19937_64 random(3);
  for (int i = 0; i < 10'000; ++i) {
    ForceGuard guard({3, 1e9});
    guard.pass(RealTime{0}, glm::dvec3(0), kWithForce);
    const double size = std::pow(10, 1 + static_cast<double>(random() % 308));
    const glm::dvec3 unit{uniform(random), uniform(random), uniform(random)};
    const glm::dvec3 wanted = unit * size;
    if (length(unit) < 0.5) continue;
    const glm::dvec3 sent = guard.pass(RealTime{kMs}, wanted, kWithForce);
    for (int axis = 0; axis < 3; ++axis)
      REQUIRE(sent[axis] == Approx(3 * unit[axis] / length(unit)).epsilon(1e-14).margin(1e-14));
    REQUIRE(guard.counters().clamped == 1);
  }
}

TEST_CASE("on an axis the clamp gives the limit exactly, and one ulp below it passes") {
  for (const double limit : {1.0, 3.3, 100.0, 1e12}) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sign : {-1.0, 1.0}) {
        ForceGuard guard({limit, 1e300});
        guard.pass(RealTime{0}, glm::dvec3(0), kWithForce);
        glm::dvec3 wanted(0);
        wanted[axis] = sign * std::nextafter(limit, 0);
        CHECK(guard.pass(RealTime{kMs}, wanted, kWithForce) == wanted);
        wanted[axis] = sign * limit;
        CHECK(guard.pass(RealTime{kMs * 2}, wanted, kWithForce) == wanted);
        CHECK(guard.counters().clamped == 0);
        const glm::dvec3 at_limit = wanted;
        wanted[axis] = sign * std::nextafter(limit, kInfinity);
        CHECK(guard.pass(RealTime{kMs * 3}, wanted, kWithForce) == at_limit);
        CHECK(guard.counters().clamped == 1);
      }
    }
  }
}

TEST_CASE("the first call sends zero, and from it on the slew has the time that passed") {
  for (const std::int64_t start_ns : {0 * kMs, 17 * kMs, 1000 * kMs}) {
    ForceGuard guard({100, 1000});
    CHECK(guard.pass(RealTime{start_ns}, {50, 0, 0}, kWithForce) == glm::dvec3(0));
    for (int tick = 1; tick <= 60; ++tick) {
      // 1 N per tick up to 50; 50 sums of rounded numbers below 64 stray by at most 50 * 2^-48.
      const double sent_N = guard.pass(RealTime{start_ns + tick * kMs}, {50, 0, 0}, kWithForce).x;
      CHECK(sent_N == Approx(std::min(tick, 50)).epsilon(0).margin(50 * 0x1p-48));
    }
  }
}

TEST_CASE("a schedule that starts with zero force is not touched by the first call") {
  ForceGuard guard({100, 1e6});
  CHECK(guard.pass(RealTime{0}, glm::dvec3(0), kWithForce) == glm::dvec3(0));
  CHECK(guard.pass(RealTime{kMs}, {0, 0, 99}, kWithForce) == glm::dvec3(0, 0, 99));
  CHECK(guard.counters().slewed == 0);
}

TEST_CASE("a non-finite force ramps to zero by the slew limit and is counted") {
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    for (int axis = 0; axis < 3; ++axis) {
      ForceGuard guard({100, 1024});  // 1.024 N per tick
      for (int tick = 0; tick <= 10; ++tick) guard.pass(RealTime{tick * kMs}, {0, 8, 0}, kWithForce);
      glm::dvec3 wanted(0, 8, 0);
      wanted[axis] = bad;
      for (int tick = 11; tick <= 20; ++tick) {
        const glm::dvec3 sent = guard.pass(RealTime{tick * kMs}, wanted, kWithForce);
        CHECK(sent.y == Approx(std::max(0.0, 8 - 1.024 * (tick - 10))).margin(1e-14));
        CHECK((sent.x == 0 && sent.z == 0));
      }
      CHECK(guard.counters().non_finite == 10);
      CHECK(guard.counters().clamped == 0);
      CHECK(guard.counters().slewed == 15);  // 8 ticks up (the first sends zero), then 7 whole ones down; the 8th arrives
    }
  }
}

namespace {

/// A tick at `ms`, with a hand at rest and a force that is due right now.
GuardedTick calm(std::int64_t ms) {
  GuardedTick tick;
  tick.sample.read_at = RealTime{ms * kMs};
  tick.sample.fresh = true;
  tick.force_due = RealTime{ms * kMs};
  return tick;
}

ForceLimits with_ramps() {
  ForceLimits limits;
  limits.cut.ramp_up = Duration{100 * kMs};
  limits.cut.ramp_down = Duration{20 * kMs};
  return limits;
}

}  // namespace

TEST_CASE("the authority rises in a straight line and then passes the force bit for bit") {
  ForceGuard guard(with_ramps());
  for (int ms = 0; ms <= 100; ++ms)
    CHECK(guard.pass(RealTime{ms * kMs}, {0, 2, 0}, calm(ms)).y == Approx(2.0 * ms / 100).margin(1e-12));
  for (int ms = 101; ms < 110; ++ms) CHECK(guard.pass(RealTime{ms * kMs}, {0, 2, 0}, calm(ms)) == glm::dvec3(0, 2, 0));
}

TEST_CASE("the authority waits for the first force of the schedule and counts no cut meanwhile") {
  ForceGuard guard(with_ramps());
  GuardedTick waiting = calm(0);
  waiting.force_due.reset();
  for (int ms = 0; ms < 500; ++ms) guard.pass(RealTime{ms * kMs}, glm::dvec3(0), waiting);
  CHECK(guard.authority() == 0);
  CHECK(guard.counters().cuts_stale_force == 0);
  guard.pass(RealTime{500 * kMs}, {1, 0, 0}, calm(500));
  CHECK(guard.authority() == Approx(0.01));
}

TEST_CASE("the gain scales the force before the clamp") {
  for (const double gain : {0.25, 0.5, 1.0}) {
    ForceLimits limits;
    limits.max_N = 3;
    limits.cut.gain = gain;
    ForceGuard guard(limits);
    guard.pass(RealTime{0}, glm::dvec3(0), calm(0));
    for (const double wanted : {0.5, 2.0, 4.0, 20.0}) {
      ForceGuard each = guard;
      CHECK(each.pass(RealTime{kMs}, {wanted, 0, 0}, calm(1)).x == std::min(3.0, gain * wanted));
    }
  }
}

TEST_CASE("a device's own springs get the share of gain and authority and together no more than the limit") {
  ForceLimits limits = with_ramps();
  limits.max_N = 6;
  limits.cut.gain = 0.5;
  ForceGuard guard(limits);
  const DeviceSpring wanted{{0.01, -0.02, 0.03}, {100, 0, 300}, {0, 200, 300}, {kInfinity, kInfinity, 2}};
  CHECK(guard.share(wanted).below_N_per_m == glm::dvec3(0));  // before the first call
  for (int ms = 0; ms <= 40; ++ms) guard.pass(RealTime{ms * kMs}, glm::dvec3(0), calm(ms));
  const double authority = guard.authority();
  CHECK(authority == Approx(0.4));
  const DeviceSpring shared = guard.share(wanted);
  CHECK(shared.center_m == wanted.center_m);
  for (int axis = 0; axis < 3; ++axis) {
    CHECK(shared.below_N_per_m[axis] == Approx(0.5 * authority * wanted.below_N_per_m[axis]));
    CHECK(shared.above_N_per_m[axis] == Approx(0.5 * authority * wanted.above_N_per_m[axis]));
    CHECK(shared.limit_N[axis] == Approx(authority * (axis == 2 ? 2 : 6) / std::sqrt(3)));
  }
  CHECK(length(shared.limit_N) <= 6 * authority);
}

TEST_CASE("an axis without a spring takes no part of the limit and one that is not finite gets none") {
  ForceGuard guard({6, 1e6});
  guard.pass(RealTime{0}, glm::dvec3(0), kWithForce);
  guard.pass(RealTime{kMs}, glm::dvec3(0), kWithForce);
  const DeviceSpring alone = guard.share({{0.01, 0, 0}, {100, 0, 0}, {0, 0, 0}, {kInfinity, 5, 5}});
  CHECK(alone.limit_N == glm::dvec3(6, 0, 0));
  CHECK(alone.below_N_per_m == glm::dvec3(100, 0, 0));
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    for (int part = 0; part < 3; ++part) {
      DeviceSpring wanted{{0.01, 0.02, 0}, {100, 50, 0}, {100, 50, 0}, {1, 1, 1}};
      (part == 0 ? wanted.center_m : part == 1 ? wanted.below_N_per_m : wanted.above_N_per_m).x = bad;
      const DeviceSpring shared = guard.share(wanted);
      CHECK((shared.center_m.x == 0 && shared.below_N_per_m.x == 0 && shared.above_N_per_m.x == 0 && shared.limit_N.x == 0));
      CHECK((shared.below_N_per_m.y == 50 && shared.limit_N.y == 1));
    }
  }
}

TEST_CASE("each reason to cut ramps to zero and back in the ramps' own time and is counted once") {
  // Something is wrong between 200 ms and 300 ms. So the force is down to nothing at 220 ms and rises again from 300 ms on.
  enum class Fault { device, hand, force, speed };
  for (const Fault fault : {Fault::device, Fault::hand, Fault::force, Fault::speed}) {
    ForceLimits limits = with_ramps();
    limits.cut.max_speed_m_per_s = 1;
    limits.cut.stale_force = limits.cut.stale_hand = Duration{0};
    ForceGuard guard(limits);
    glm::dvec3 hand(0);
    for (int ms = 0; ms < 500; ++ms) {
      const bool faulty = ms >= 200 && ms < 300;
      GuardedTick tick = calm(ms);
      if (faulty && fault == Fault::device) tick.sample.drivable = false;
      if (faulty && fault == Fault::hand) tick.sample.fresh = false;
      if (faulty && fault == Fault::force) tick.force_due = RealTime{199 * kMs};
      if (faulty && fault == Fault::speed) hand.x += 0.002;  // 2 m/s
      tick.sample.position_m = hand;
      // The speed is a mean over 5 ms. It has risen above the limit with the third of these milliseconds. The cut ends at
      // half the limit, which is when the hand has been at rest for 2.5 of them.
      const int late = fault == Fault::speed ? 2 : 0;
      const double sent = guard.pass(RealTime{ms * kMs}, {1, 0, 0}, tick).x;
      if (ms >= 100 && ms < 200) CHECK(sent == 1);
      if (ms >= 200 && ms < 220 + late) CHECK(sent == Approx(std::min(1.0, 1 - (ms - 199 - late) / 20.0)).margin(1e-12));
      if (ms >= 220 + late && ms < 300) CHECK(sent < 1e-12);
      if (ms >= 310 && ms < 395) CHECK(sent == Approx((ms - 299 - (fault == Fault::speed ? 3 : 0)) / 100.0).margin(1e-12));
      if (ms >= 405) CHECK(sent == 1);
    }
    const ForceGuardCounters& counters = guard.counters();
    CHECK(counters.cuts_device == (fault == Fault::device));
    CHECK(counters.cuts_stale_hand == (fault == Fault::hand));
    CHECK(counters.cuts_stale_force == (fault == Fault::force));
    CHECK(counters.cuts_speed == (fault == Fault::speed));
  }
}

TEST_CASE("after the shortest absence of a device the force rises from zero, however slowly it would have been cut") {
  ForceLimits limits;
  limits.cut.ramp_up = Duration{100 * kMs};
  limits.cut.ramp_down = Duration{60'000 * kMs};
  limits.max_slew_N_per_s = 1000;
  ForceGuard guard(limits);
  std::int64_t ms = 0;
  const auto pass = [&](bool away) {
    GuardedTick tick{{}, RealTime{ms * kMs}};
    tick.sample.away = away;
    tick.sample.drivable = !away;
    return guard.pass(RealTime{ms++ * kMs}, {2, 0, 0}, tick).x;
  };
  while (ms < 200) pass(false);
  CHECK(pass(false) == 2);
  CHECK(pass(true) == 0);
  CHECK(guard.share({.above_N_per_m = {100, 0, 0}, .limit_N = {1, 1, 1}}).above_N_per_m.x == 0);
  CHECK(guard.counters().cuts_device == 1);
  double last_N = 0;
  for (int tick = 1; tick < 100; ++tick) {
    const double force_N = pass(false);
    CHECK(force_N - last_N == Approx(0.02).epsilon(1e-9));
    last_N = force_N;
  }
}

TEST_CASE("a hand just below the speed limit is never cut off and one just above always is") {
  for (const double rate_Hz : {500.0, 1000.0, 4000.0}) {
    for (const double speed : {0.5, 0.99, 1.01, 3.0}) {
      ForceLimits limits;
      limits.cut.max_speed_m_per_s = 1;
      ForceGuard guard(limits);
      for (int i = 0; i < 200; ++i) {
        GuardedTick tick;
        tick.force_due = RealTime{0};
        tick.sample.fresh = true;
        tick.sample.read_at = RealTime{static_cast<std::int64_t>(i * 1e9 / rate_Hz)};
        tick.sample.position_m = {0, 0, speed * i / rate_Hz};
        guard.pass(tick.sample.read_at, {1, 0, 0}, tick);
      }
      CHECK(guard.authority() == (speed < 1 ? 1 : 0));
    }
  }
}

TEST_CASE("with the default limits nothing is ever cut off") {
  ForceGuard guard{ForceLimits{}};
  for (int i = 0; i < 1000; ++i) {
    GuardedTick tick;
    tick.force_due = RealTime{0};
    tick.sample.fresh = i % 3 == 0;
    tick.sample.read_at = RealTime{i * 1'000'000'000LL};
    tick.sample.position_m = glm::dvec3(i * 1e6);
    guard.pass(tick.sample.read_at, {1, 0, 0}, tick);
    CHECK(guard.authority() == 1);
  }
}

TEST_CASE("the guard says which limits made a force another one, 100,000 random ones") {
  std::mt19937_64 random(3);
  ForceLimits limits{10, 5000};
  limits.cut.ramp_up = limits.cut.ramp_down = Duration{5 * kMs};
  ForceGuard guard(limits);
  std::array<int, 5> seen{};
  for (int i = 0; i < 100'000; ++i) {
    GuardedTick tick = kWithForce;
    tick.sample.drivable = random() % 16 != 0;
    const ForceGuardCounters before = guard.counters();
    const glm::dvec3 wanted = any_force(random);
    const glm::dvec3 sent = guard.pass(RealTime{i * kMs}, wanted, tick);
    const GuardLimited& limited = guard.limited();
    REQUIRE(limited.clamped == (guard.counters().clamped > before.clamped));
    REQUIRE(limited.slewed == (guard.counters().slewed > before.slewed));
    REQUIRE(limited.non_finite == (guard.counters().non_finite > before.non_finite));
    REQUIRE(limited.cut == (guard.authority() < 1));
    const bool any = limited.clamped || limited.slewed || limited.non_finite || limited.cut;
    if (!any) REQUIRE(sent == wanted);
    seen[0] += limited.clamped, seen[1] += limited.slewed, seen[2] += limited.non_finite, seen[3] += limited.cut;
    seen[4] += !any;
  }
  for (const int count : seen) CHECK(count > 100);
}

TEST_CASE("the guard says whether it lets the force through, and if not, why") {
  ForceLimits limits;
  limits.cut = {1, Duration{10 * kMs}, Duration{4 * kMs}, 1.0, Duration{50 * kMs}, Duration{20 * kMs}};
  ForceGuard guard(limits);
  CHECK(guard.state() == GuardState::waiting);
  double x_m = 0;
  RealTime due;
  const auto pass = [&](std::int64_t ms, double moves_m, bool drivable, bool fresh, bool force_comes) {
    const RealTime now{ms * kMs};
    if (force_comes) due = now;
    x_m += moves_m;
    DeviceSample sample{.read_at = now, .position_m = {x_m, 0, 0}};
    sample.fresh = fresh;
    sample.drivable = drivable;
    guard.pass(now, {1, 0, 0}, {sample, ms < 2 ? std::nullopt : std::optional(due)});
    return guard.state();
  };
  CHECK(pass(0, 0, false, true, false) == GuardState::cut_device);  // a reason to cut even without a force
  CHECK(pass(1, 0, true, true, false) == GuardState::waiting);      // no force has come yet: nothing is cut off
  CHECK(pass(2, 0, true, true, true) == GuardState::ramping);
  for (std::int64_t ms = 3; ms < 10; ++ms) CHECK(pass(ms, 0, true, true, true) == GuardState::ramping);
  CHECK(pass(12, 0, true, true, true) == GuardState::armed);
  CHECK(pass(13, 0.1, true, true, true) == GuardState::cut_speed);
  CHECK(pass(14, 0, false, true, true) == GuardState::cut_device);
  for (std::int64_t ms = 15; ms < 45; ++ms) pass(ms, 0, true, true, true);
  CHECK(guard.state() == GuardState::armed);
  CHECK(pass(66, 0, true, false, true) == GuardState::cut_stale_hand);
  CHECK(pass(67, 0, true, true, true) == GuardState::ramping);
  CHECK(pass(118, 0, true, true, false) == GuardState::cut_stale_force);
}
