// The library as an embedder uses it: the few calls of this room, without any other room.

#include "evenstep/remap/remapper.h"

#include <cstdlib>
#include <new>

#include "catch.h"
#include "evenstep/time/chrono.h"
#include "schedules.h"

namespace {
std::size_t allocations = 0;
}
#ifndef EVENSTEP_SANITIZE_THREAD  // clang's thread sanitizer has an operator new that nothing replaces
void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {  // called by a sort in the test framework
  ++allocations;
  return std::malloc(size);
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
#endif

using namespace evenstep;
using namespace evenstep::testing;
using Vector = std::array<double, 3>;

namespace {

constexpr Vector kVelocity_m_per_s{0.1, -0.04, 0.02};
Vector position_m(RealTime at) {
  return {kVelocity_m_per_s[0] * seconds(at), kVelocity_m_per_s[1] * seconds(at), kVelocity_m_per_s[2] * seconds(at)};
}
double norm(const Vector& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }
Vector minus(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

/// Events in the order of time. At the same instant: step ends, then device ticks, then step begins.
template <class OnTick, class OnStep, class OnResponse, class OnSegment>
void play(const Schedule& schedule, OnTick tick, OnStep step, OnResponse response, OnSegment segment) {
  std::int64_t k = 0;
  const auto ticks_until = [&](RealTime at, bool including) {
    for (; tick_time({1000, 1}, k) < at || (including && tick_time({1000, 1}, k) == at); ++k) tick(tick_time({1000, 1}, k));
  };
  for (const Segment& s : schedule) {
    ticks_until(s.begin, true);
    segment(s.begin);
    for (const StepTimes& times : s.steps) {
      ticks_until(times.begin, true);
      step(times.begin);
      ticks_until(times.end, false);
      response(times.end);
    }
  }
}

}  // namespace

TEST_CASE("constant velocity in, straight line out, both directions, 12.842 ms held or 15.064 ms interpolated") {
  constexpr double slot_s = 1.0 / 450;
  const double step_m = norm(kVelocity_m_per_s) * slot_s;
  // The paper's timing: 30 Hz, V = 11.1 ms, N = 15; L from latency_budget_test.cpp, with 3 ns for the map's rounding.
  Remapper<Vector> remap({.lead = {260'002}, .latency = {15'064'450}});
  std::vector<Vector> in;
  std::vector<std::pair<RealTime, Vector>> out;
  Vector hand{};
  bool inside = true;
  play(
      Periodic{}.schedule(90),
      [&](RealTime now) {
        remap.sample(now, position_m(now));
        const Reading<Vector> force = remap.force(now);
        if (now.ns > 150'000'000) {
          inside = inside && force.status == ReadStatus::inside;
          out.emplace_back(now, force.value);
        }
      },
      [&](RealTime now) {
        const Reading<Vector> reading = remap.begin_step(now).hand;
        hand = reading.value;
        in.push_back(hand);
        if (in.size() > 30) inside = inside && reading.status == ReadStatus::inside;
      },
      [&](RealTime now) { remap.end_step(now, hand); },  // a spring of 1 N/m
      [&](RealTime now) { remap.segment(now); });
  CHECK(inside);
  const RemapCounts counts = remap.counts();
  CHECK(counts.steps == 90 * 15);
  CHECK(counts.acquiring == 15);  // the first segment
  CHECK(counts.hand.inside == 89 * 15);
  CHECK(counts.late_forces == 0);
  CHECK(counts.latest_force == Duration{});
  CHECK(counts.force.inside + counts.force.empty + counts.force.held == 3000);
  CHECK(counts.force.held <= 33);  // before the first slot
  REQUIRE(in.size() == 90 * 15);
  REQUIRE(out.size() > 2000);
  for (std::size_t n = 30; n < in.size(); ++n) {
    const RealTime slot{tick_time({450, 1}, static_cast<std::int64_t>(n)).ns - 260'002};
    REQUIRE(norm(minus(in[n], position_m(slot))) <= 1e-6 * step_m);  // 1 ns is 4.5e-7 step
    if (n > 30) REQUIRE(norm(minus(minus(in[n], in[n - 1]), minus(in[n - 1], in[n - 2]))) <= 1e-6 * step_m);
  }
  for (const auto& [now, force] : out) REQUIRE(norm(minus(force, position_m(now - Duration{15'064'450}))) <= 1e-6 * step_m);
}

TEST_CASE("without the remap the same timing jumps by more than four steps") {
  std::vector<double> in;
  double newest = 0;
  play(
      Periodic{}.schedule(30), [&](RealTime now) { newest = 0.1 * seconds(now); }, [&](RealTime) { in.push_back(newest); },
      [](RealTime) {}, [](RealTime) {});
  double jump = 0;
  for (std::size_t n = 32; n < in.size(); ++n) jump = std::max(jump, std::abs(in[n] - 2 * in[n - 1] + in[n - 2]));
  CHECK(jump / (0.1 / 450) > 4);
}

TEST_CASE("a remapper that adapts finds the least latency by itself, held and interpolated, in one segment") {
  const bool held = GENERATE(true, false);
  const double latency_s = held ? 12.842e-3 + 0.5 / 450 : 15.064e-3;  // a held force is half a slot older on average
  Remapper<double> remap({.lead = {260'002},
                          .adapt = AdaptiveLatencyOptions{.start = {}, .least = {}, .most = {50'000'000}, .margin = {}},
                          .emission = held ? Emission::hold : Emission::linear});
  double hand = 0, off = 0;
  play(
      Periodic{}.schedule(30),
      [&](RealTime now) {
        remap.sample(now, seconds(now));
        if (now < RealTime{150'000'000}) return;
        const double age = seconds(now) - remap.force(now).value;
        off = std::max(off, std::abs(age - latency_s));
      },
      [&](RealTime now) { hand = remap.begin_step(now).hand.value; }, [&](RealTime now) { remap.end_step(now, hand); },
      [&](RealTime now) { remap.segment(now); });
  CHECK(off <= (held ? 0.5 / 450 : 0) + 1e-6);  // a held force is as old as the latency and up to one slot more
}

#ifndef EVENSTEP_SANITIZE_THREAD
TEST_CASE("a remapper allocates nothing after construction") {
  const bool adapts = GENERATE(false, true);
  RemapperOptions options{.lead = {260'002}, .latency = {15'064'450}};
  if (adapts) options.adapt = AdaptiveLatencyOptions{.start = {}, .least = {}, .most = {50'000'000}};
  Remapper<Vector> remap(options);
  const Schedule schedule = Periodic{}.schedule(30);
  double sum = 0;
  const std::size_t before = allocations;
  play(
      schedule,
      [&](RealTime now) {
        remap.sample(now, position_m(now));
        sum += remap.force(now).value[0];
      },
      [&](RealTime now) { sum += remap.begin_step(now).hand.value[0]; }, [&](RealTime now) { remap.end_step(now, {}); },
      [&](RealTime now) { remap.segment(now); });
  const std::size_t after = allocations;
  CHECK(after == before);
  CHECK(before > 0);  // allocations are really counted
  CHECK(sum > 0);
}
#endif

TEST_CASE("a remapper counts the forces that come late, and says of each by how much") {
  // With hold emission the paper's timing needs 12.842 ms, with linear emission 15.064 ms. With 1 ms less, forces around
  // each visualization come too late: after F(n), or after F(n - 1), from which on ticks are on the line to F(n).
  const auto missing = GENERATE(Duration{0}, Duration{1'000'000}, Duration{5'000'000});
  const bool held = GENERATE(true, false);
  Remapper<double> remap({.lead = {260'002},
                          .latency = Duration{held ? 12'842'230 : 15'064'452} - missing,
                          .emission = held ? Emission::hold : Emission::linear});
  std::uint64_t late = 0;
  Duration latest;
  std::optional<RealTime> before;
  play(
      Periodic{}.schedule(30), [&](RealTime now) { remap.sample(now, 1); }, [&](RealTime now) { remap.begin_step(now); },
      [&](RealTime now) {
        const StepEmission emission = remap.end_step(now, 1);
        const RealTime deadline = held || !before ? emission.at : *before;
        if (emission.slot.kind != SlotKind::mapped) return;
        before = emission.at;
        const Duration by = std::max(now - deadline, Duration{});
        CHECK(emission.late(held ? Emission::hold : Emission::linear) == by);
        late += by.ns > 0;
        latest = std::max(latest, by);
      },
      [&](RealTime now) { remap.segment(now); });
  const RemapCounts counts = remap.counts();
  CHECK(counts.late_forces == late);
  CHECK(counts.latest_force == latest);
  CHECK((latest > missing - Duration{10} && latest <= missing));  // the latency above has up to 10 ns to spare
  CHECK((late > 0) == (missing.ns > 0));
}

TEST_CASE("a remapper tells reads past the newest sample apart: on the policy's line, held, lost, and nothing there yet") {
  // After a segment of four steps there is a slot every millisecond. The hand is sampled once or not at all.
  const auto ms = [](std::int64_t count) { return RealTime{count * 1'000'000}; };
  const bool line = GENERATE(false, true);
  Remapper<double> remap(
      {.past_newest_sample = line ? Extrapolation{{1'000'000}, {3'000'000}} : kHoldNewest, .interaction_capacity = 4});
  const auto step = [&](RealTime at) {
    const StepInput<double> input = remap.begin_step(at);
    remap.end_step(at, 0);
    return input.hand.status;
  };
  for (int n = 0; n < 4; ++n) {
    if (n == 0) remap.segment(ms(0));
    CHECK(step(ms(n)) == ReadStatus::empty);
  }
  remap.segment(ms(4));
  CHECK(step(ms(4)) == ReadStatus::empty);
  for (const int at : {3, 4}) remap.sample(ms(at), at);
  for (int n = 5; n < 12; ++n) CHECK(step(ms(n)) == ReadStatus::underrun);  // 1 to 7 ms past the newest
  for (int at = 5; at < 40; ++at) remap.sample(ms(at), at);
  CHECK(step(ms(12)) == ReadStatus::overrun);  // four samples are kept, 36 to 39
  const RemapCounts counts = remap.counts();
  CHECK(counts.acquiring == 4);
  CHECK(counts.hand.empty == 1);
  CHECK(counts.hand.extrapolated == (line ? 3 : 0));
  CHECK(counts.hand.held == (line ? 4 : 7));
  CHECK(counts.hand.overruns == 1);
  CHECK(counts.hand.inside == 0);
}

TEST_CASE("a remapper counts what its ticks played: before the first force, between forces, past the last one") {
  const auto ms = [](std::int64_t count) { return RealTime{count * 1'000'000}; };
  const bool held = GENERATE(true, false);
  Remapper<double> remap({.emission = held ? Emission::hold : Emission::linear});
  for (int n = 0; n < 3; ++n) {  // acquiring: each force is emitted as soon as it is there, at 1, 2 and 3 ms
    remap.begin_step(ms(n));
    remap.end_step(ms(n + 1), n);
  }
  for (int tick = 0; tick < 6; ++tick) remap.force(ms(tick));
  const ReadCounts force = remap.counts().force;
  CHECK(force.empty == 1);
  CHECK(force.inside == (held ? 5 : 3));
  CHECK(force.held == (held ? 0 : 2));  // with hold emission no force is missing: late_forces counts instead
  CHECK(force.extrapolated == 0);
}

TEST_CASE("a step without a slot reads the newest sample itself, under every policy, and its force is never late") {
  const Extrapolation policy = GENERATE(kHoldNewest, kContinueLine);
  Remapper<double> remap({.past_newest_sample = policy});
  for (int at = 0; at < 10; ++at) remap.sample({at * 1'000'000}, at);
  const auto [slot, hand] = remap.begin_step({15'000'000});
  CHECK(slot.kind == SlotKind::acquiring);
  CHECK(slot.read == RealTime{15'000'000});
  CHECK(hand.status == ReadStatus::inside);
  CHECK(hand.value == 9);
  CHECK(hand.newest == RealTime{9'000'000});
  const StepEmission emission = remap.end_step({17'000'000}, 1);
  CHECK(emission.at == RealTime{17'000'000});
  for (const Emission played : {Emission::hold, Emission::linear}) CHECK(emission.late(played) == Duration{});
}

TEST_CASE("the times of std::chrono become evenstep's exactly") {
  using namespace std::chrono_literals;
  static_assert(duration(15ms + 65us) == Duration{15'065'000});
  static_assert(duration(-1h) == Duration{-3'600'000'000'000});
  static_assert(real_time(2s) == RealTime{2'000'000'000});
  const std::chrono::steady_clock::time_point start{1'000'000'001ns}, later{1'000'000'003ns};
  CHECK(real_time(later - start) == RealTime{2});
  static_assert(!std::is_invocable_v<decltype(duration), std::chrono::duration<double>>);
}

TEST_CASE("a remapper of a loop that knows its own time reads at its steps' times, and its slots are even") {
  Remapper<double> remap({.lead = {30'000'000}, .latency = {50'000'000}, .clocked = Clocked{.step_rate = {90, 1}}});
  for (std::int64_t k = 0; k <= 2'000; ++k) remap.sample(tick_time({1'000, 1}, k), static_cast<double>(k));
  const std::size_t before = allocations;
  std::int64_t n = 0;
  for (std::int64_t frame = 1; frame < 120; ++frame) {  // 60 Hz: one and two steps by turns
    const RealTime now = tick_time({60, 1}, frame);
    remap.segment(now);
    for (; sim_time({90, 1}, n + 1).ns <= now.ns; ++n) {
      const StepInput<double> step = remap.begin_step(now, sim_time({90, 1}, n));
      REQUIRE(step.slot.kind == SlotKind::mapped);
      REQUIRE(step.slot.read == tick_time({90, 1}, n, tick_time({60, 1}, 1)) - Duration{30'000'000});
      REQUIRE(remap.end_step(now + Duration{100'000}, 0).at == step.slot.read + Duration{50'000'000});
    }
  }
  CHECK(allocations == before);
  CHECK(remap.counts().late_forces == 0);
  CHECK(remap.counts().acquiring == 0);
}
