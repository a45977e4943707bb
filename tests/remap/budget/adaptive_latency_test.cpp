// A latency that grows at once and shrinks slowly, compared with an oracle that remembers everything: on 100,000 random
// traces and on maps of 100,000 random schedules. [million] takes 1,000,000 others.
#include "evenstep/remap/adaptive_latency.h"

#include <limits>
#include <optional>

#include "../for_all.h"

using namespace evenstep;
using namespace evenstep::testing;

namespace {

constexpr Duration kLead{700'000};
constexpr std::int64_t kMillion = 1'000'000;

/// Any options; half of the time the emission is linear.
AdaptiveLatencyOptions random_options(Draw& draw) {
  AdaptiveLatencyOptions options;
  options.least = {draw.between(0, 20'000'000)};
  options.most = options.least + Duration{draw.between(0, 3) == 0 ? 0 : draw.between(0, 100'000'000)};
  options.start = {draw.between(options.least.ns, options.most.ns)};
  options.window = {draw.between(1, 200'000'000)};
  options.margin = {draw.between(0, 2'000'000)};
  options.slew_ppm = draw.between(0, 2) == 0 ? draw.between(0, kMostSlew_ppm) : draw.between(0, 20'000);
  options.emission = draw.between(0, 1) == 0 ? Emission::hold : Emission::linear;
  return options;
}

struct Timed {
  RealTime read, ended;
};

/// Reads mostly advance, and now and then jump far or step back. Needs have a long tail.
std::vector<Timed> random_trace(Draw& draw) {
  std::vector<Timed> trace;
  RealTime read{draw.between(-1'000'000'000, 1'000'000'000)};
  const std::int64_t steps = draw.between(1, 60), usual_need = draw.between(0, 30'000'000);
  for (std::int64_t n = 0; n < steps; ++n) {
    const std::int64_t kind = draw.between(0, 19);
    read = read + Duration{kind == 0   ? draw.between(-3'000'000, 3)
                           : kind == 1 ? draw.between(0, 400'000'000)
                           : kind <= 4 ? draw.between(1, 2)
                                       : draw.between(1, 5'000'000)};
    const std::int64_t more = draw.between(0, 9) == 0 ? draw.between(0, 90'000'000) : draw.between(0, 3'000'000);
    trace.push_back({read, read + Duration{usual_need + more}});
  }
  return trace;
}

std::int64_t floor_div(std::int64_t a, std::int64_t b) { return floor_mul_div(a, 1, b); }

/// The equations of the header, computed from a list that forgets nothing.
class Oracle {
 public:
  explicit Oracle(const AdaptiveLatencyOptions& options) : o_(options), latency_(options.start.ns), target_(latency_) {}

  RealTime emission(RealTime read, RealTime ended) {
    if (last_read_) slew(read.ns - *last_read_);
    std::int64_t due = read.ns + latency_;
    if (last_emission_) due = std::max(due, *last_emission_ + 1);
    last_emission_ = due;
    const std::int64_t own_read = last_read_ ? due - latency_ : read.ns;
    const std::int64_t from = o_.emission == Emission::linear && last_read_ ? *last_read_ : own_read;
    last_read_ = own_read;
    if (o_.least < o_.most) learn(from, ended.ns - from);
    return {due};
  }
  std::int64_t latency() const { return latency_; }

 private:
  void slew(std::int64_t elapsed) {
    if (o_.least == o_.most || latency_ == target_ || elapsed <= 0) return;
    const __int128 allowed = static_cast<__int128>(elapsed) * o_.slew_ppm + carry_;
    carry_ = static_cast<std::int64_t>(allowed % kMillion);
    const std::int64_t most = std::min(static_cast<std::int64_t>(allowed / kMillion), elapsed - 1);
    latency_ = target_ < latency_ ? std::max(target_, latency_ - most) : std::min(target_, latency_ + most);
    if (latency_ == target_) carry_ = 0;
  }
  void learn(std::int64_t at, std::int64_t need) {
    if (needs_.empty()) origin_ = at;
    newest_ = needs_.empty() ? at : std::max(newest_, at);
    const std::int64_t length = (o_.window.ns + 63) / 64, block = floor_div(newest_ - origin_, length);
    needs_.push_back({block, need});
    std::int64_t largest = std::numeric_limits<std::int64_t>::min();
    for (const auto& [of, kept] : needs_) {
      if (of >= block - 64) largest = std::max(largest, kept);
    }
    target_ = std::min(std::max(largest + o_.margin.ns, o_.least.ns), o_.most.ns);
    if (need <= latency_ || target_ <= latency_) return;
    latency_ = target_;
    carry_ = 0;
  }

  AdaptiveLatencyOptions o_;
  std::int64_t latency_, target_, carry_ = 0, origin_ = 0, newest_ = 0;
  std::optional<std::int64_t> last_emission_, last_read_;
  std::vector<std::pair<std::int64_t, std::int64_t>> needs_;
};

const char* as_the_oracle(Draw draw) {
  const AdaptiveLatencyOptions options = random_options(draw);
  AdaptiveLatency latency(options);
  Oracle oracle(options);
  for (const auto& [read, ended] : random_trace(draw)) {
    if (latency.emission(read, ended) != oracle.emission(read, ended)) return "F is not the oracle's";
    if (latency.latency().ns != oracle.latency()) return "L is not the oracle's";
  }
  return nullptr;
}

/// A step on the map, with the latency that it had and the latency that it needed.
struct Step {
  RealTime read, end, emission;
  Duration latency, need;
};

/// The mapped steps of a schedule on phase_locked. This map never steps back, so L(n) = F(n) - R(n). The result is empty if
/// the first mapped step had to wait for the last step without a slot.
std::vector<Step> adapted(const Schedule& schedule, const AdaptiveLatencyOptions& options, std::int64_t& growths) {
  PhaseLockedMap map(kLead, AdaptiveLatency(options));
  std::vector<Step> steps;
  for (const Placed& placed : place(map, schedule)) {
    if (placed.slot.kind != SlotKind::mapped) continue;
    const RealTime read = placed.slot.read;
    const RealTime from = options.emission == Emission::linear && !steps.empty() ? steps.back().read : read;
    steps.push_back({read, placed.real.end, placed.emission, placed.emission - read, placed.real.end - from});
  }
  growths = map.latency().growths();
  if (map.emission_repairs() == 0) return steps;
  growths = 0;
  return {};
}

/// Options whose largest latency is enough for most random schedules.
AdaptiveLatencyOptions roomy_options(Draw& draw) {
  AdaptiveLatencyOptions options = random_options(draw);
  options.least = {draw.between(0, 20'000'000)};
  options.most = options.least + Duration{draw.between(200'000'000, 300'000'000)};
  options.start = {draw.between(options.least.ns, options.most.ns)};
  return options;
}

const char* strictly_increasing(const Schedule& schedule, Draw draw) {
  const AdaptiveLatencyOptions options = random_options(draw);
  const bool of_paper = draw.between(0, 1) == 0;
  const std::vector<Placed> placed = of_paper ? place(PaperMap(kLead, AdaptiveLatency(options), 0.3), schedule)
                                              : place(PhaseLockedMap(kLead, AdaptiveLatency(options)), schedule);
  for (std::size_t n = 1; n < placed.size(); ++n) {
    if (placed[n].emission <= placed[n - 1].emission) return "F(n) <= F(n-1)";
  }
  return nullptr;
}

/// Between two steps without a growth, L moves by the slew at most. 1 ns more is possible: a remainder of the step before.
const char* moves_by_the_slew(const Schedule& schedule, Draw draw) {
  const AdaptiveLatencyOptions options = roomy_options(draw);
  std::int64_t growths = 0;
  const std::vector<Step> steps = adapted(schedule, options, growths);
  std::int64_t jumps = 0;
  for (std::size_t n = 1; n < steps.size(); ++n) {
    const Duration by = steps[n].latency - steps[n - 1].latency, elapsed = steps[n].read - steps[n - 1].read;
    const std::int64_t most = floor_mul_div(elapsed.ns, options.slew_ppm, kMillion) + 1;
    if (by.ns < -most) return "L fell faster than the slew";
    if (by.ns <= most) continue;
    ++jumps;
    const bool in_time = steps[n - 1].need <= steps[n - 1].latency;
    if (in_time && options.emission == Emission::hold) return "L grew at once for a force in time";
  }
  if (jumps > growths) return "L grew at once more often than it was counted";
  return nullptr;
}

/// A need that was seen before within the window is covered when it comes again. With interpolated forces the line that
/// leads to force n is promised with L(n-1), before step n-1 has ended.
const char* no_underrun_comes_twice(const Schedule& schedule, Draw draw) {
  const AdaptiveLatencyOptions options = roomy_options(draw);
  const std::size_t delay = options.emission == Emission::linear ? 2 : 1;
  std::int64_t growths = 0;
  const std::vector<Step> steps = adapted(schedule, options, growths);
  for (std::size_t n = delay; n < steps.size(); ++n) {
    const Duration had = steps[n + 1 - delay].latency;  // L at the time when step n's force was promised
    Duration seen{0};
    for (std::size_t m = n - delay + 1; m-- > 0 && steps[n].read - steps[m == 0 ? 0 : m - 1].read < options.window;) {
      seen = std::max(seen, steps[m].need);
    }
    if (steps[n].need <= seen && seen <= options.most && steps[n].need > had) return "an underrun came twice in a window";
  }
  return nullptr;
}

const char* stays_between(const Schedule& schedule, Draw draw) {
  const AdaptiveLatencyOptions options = roomy_options(draw);
  std::int64_t growths = 0, late = 0;
  Duration most_need{0};
  Duration bound = options.start;
  for (const Step& step : adapted(schedule, options, growths)) {
    if (step.latency < options.least || step.latency > options.most) return "L left its bounds";
    if (step.latency > bound) return "L is above the largest need so far, and its margin";
    late += step.need > step.latency;
    most_need = std::max(most_need, step.need);
    bound = std::max({options.start, options.least, most_need + options.margin});
  }
  const bool enough = most_need <= options.most;
  if (options.emission == Emission::hold && enough && late != growths) return "growths are not the late forces";
  return nullptr;
}

/// With start = least = most the latency is fixed, whatever the other options say.
const char* fixed_is_a_special_case(const Schedule& schedule, Draw draw) {
  AdaptiveLatencyOptions options = random_options(draw);
  options.least = options.most = options.start;
  const bool of_paper = draw.between(0, 1) == 0;
  const auto emissions = [&](const AdaptiveLatency& latency) {
    std::vector<RealTime> out;
    const std::vector<Placed> placed =
        of_paper ? place(PaperMap(kLead, latency, 0.3), schedule) : place(PhaseLockedMap(kLead, latency), schedule);
    for (const Placed& p : placed) out.push_back(p.emission);
    return out;
  };
  if (emissions(AdaptiveLatency(options)) != emissions(options.start)) return "it is not the fixed latency";
  return nullptr;
}

/// The sizing pass, which knows no map but only slots of lead 0, predicts which forces are late. The ring that it asks for
/// at the largest latency is large enough.
const char* as_sized(const Schedule& schedule, Draw draw) {
  const AdaptiveLatencyOptions options = random_options(draw);
  const bool of_paper = draw.between(0, 1) == 0;
  const auto run = [&](Duration lead, const AdaptiveLatency& latency) {
    return of_paper ? place(PaperMap(lead, latency, 0.3), schedule) : place(PhaseLockedMap(lead, latency), schedule);
  };
  const std::vector<MappedStep> sized = mapped_steps(run({}, Duration{}));
  std::vector<Duration> late;
  RunningUnderruns underruns({}, kLead, AdaptiveLatency(options), options.emission);
  for (const MappedStep& step : sized) late.push_back(underruns.next(step).late_by);
  const std::size_t ring = capacities_for(sized, {}, kLead, options.most).force_capacity;
  std::vector<Placed> mapped;
  for (const Placed& placed : run(kLead, AdaptiveLatency(options))) {
    if (placed.slot.kind == SlotKind::mapped) mapped.push_back(placed);
  }
  // The first mapped force may have to wait for the last force without a slot. The sizing pass does not see that repair.
  const bool alike = !mapped.empty() && mapped.front().emission == mapped.front().slot.read + options.start;
  std::size_t oldest = 0;
  for (std::size_t n = 0; n < mapped.size(); ++n) {
    const RealTime deadline = mapped[options.emission == Emission::linear && n > 0 ? n - 1 : n].emission;
    if (alike && late[n] != std::max(mapped[n].real.end - deadline, Duration{}))
      return "the sizing pass foretells other late forces";
    while (mapped[oldest].emission < mapped[n].real.end && oldest < n) ++oldest;
    if (n + 1 - oldest + 1 > ring) return "the ring for the largest latency is too small";
  }
  return nullptr;
}

}  // namespace

TEST_CASE("An adaptive latency is that of an oracle which remembers everything") { for_all_draws(kMany, as_the_oracle); }
TEST_CASE("With a latency that adapts forces are emitted in order on any schedule") { for_all(kMany, strictly_increasing); }
TEST_CASE("A latency grows at once only for a late force and moves by its slew else") { for_all(kMany, moves_by_the_slew); }
TEST_CASE("No underrun comes twice within a window") { for_all(kMany, no_underrun_comes_twice); }
TEST_CASE("An adaptive latency stays below the largest need and its margin") { for_all(kMany, stays_between); }
TEST_CASE("A latency that cannot move is the fixed one") { for_all(kMany, fixed_is_a_special_case); }
TEST_CASE("The sizing pass foretells an adaptive latency and its rings hold") { for_all(kMany, as_sized); }

TEST_CASE("An adaptive latency keeps its properties on a million schedules more", "[million]") {
  for_all_draws(kVeryMany, as_the_oracle);
  for_all(kVeryMany, strictly_increasing);
  for_all(kVeryMany, moves_by_the_slew);
  for_all(kVeryMany, no_underrun_comes_twice);
  for_all(kVeryMany, stays_between);
  for_all(kVeryMany, fixed_is_a_special_case);
  for_all(kVeryMany, as_sized);
}

TEST_CASE("One long pause is one hold and the latency comes back after the window at the rate of the slew") {
  // Even slots of 2.222222 ms; every step needs 5 ms, step 300 needs 30 ms.
  const std::int64_t tau = 2'222'222, paused = 300, ppm = GENERATE(1, 499, 5'000, 333'333);
  const Duration margin{GENERATE(0, 1'000'000)};
  const Duration usual{5'000'000}, once{30'000'000}, window{1'000'000'000};
  const Duration start = usual + margin, top = once + margin;
  AdaptiveLatency latency({start, {}, {100'000'000}, window, margin, ppm, Emission::hold});
  const std::int64_t block = window.ns / 64;
  std::int64_t forgotten = paused;  // the first step that is more than 64 blocks after the block of the pause
  while (forgotten * tau / block <= paused * tau / block + 64) ++forgotten;
  CHECK(forgotten * tau - paused * tau >= window.ns);
  CHECK(forgotten * tau - paused * tau <= window.ns + window.ns / 64 + tau);

  std::int64_t late = 0;
  std::optional<RealTime> before;
  for (std::int64_t n = 0; n < 6000; ++n) {
    const RealTime read{n * tau}, ended = read + (n == paused ? once : usual);
    const RealTime emission = latency.emission(read, ended);
    late += ended > emission;
    Duration expected = start;
    if (n > paused) expected = top;
    if (n > forgotten) expected = std::max(start, top - Duration{floor_mul_div((n - forgotten) * tau, ppm, kMillion)});
    REQUIRE(emission - read == expected);
    if (n == paused + 1) CHECK(emission - *before == Duration{tau} + (once - usual));  // one slot, and the hold
    before = emission;
  }
  CHECK(late == 1);
  CHECK(latency.growths() == 1);
}

TEST_CASE("A need that creeps by less than the slew is followed without any underrun") {
  const std::int64_t tau = 2'000'000, creep = GENERATE(-9'999, -1, 0, 1, 9'999);  // 0.5 % of a slot is 10,000 ns
  const std::int64_t need = 40'000'000;
  const Duration margin{10'000};
  AdaptiveLatency latency({Duration{need} + margin, {}, {10'000'000'000}, {20'000'000}, margin, 5'000, Emission::hold});
  Duration last;
  for (std::int64_t n = 0; n < 3000; ++n) {
    const RealTime read{n * tau}, ended = read + Duration{need + n * creep};
    const RealTime emission = latency.emission(read, ended);
    REQUIRE(ended <= emission);
    last = emission - ended;
  }
  CHECK(latency.growths() == 0);
  // If the need falls, L stays above it by as much as it has fallen since a window ago (plus a 64th of the window and a
  // step), which is less than 13 steps.
  CHECK(last <= margin + Duration{std::max<std::int64_t>(-creep, 0) * 13});
}

TEST_CASE("A force that is there when it is due is in time and one nanosecond later it is late") {
  for (const std::int64_t after : {-1, 0, 1}) {
    AdaptiveLatency latency({{5'000'000}, {}, {90'000'000}, {1'000'000'000}, {1'000'000}, 5'000, Emission::hold});
    CHECK(latency.emission(RealTime{0}, RealTime{5'000'000 + after}) == RealTime{5'000'000});
    CHECK(latency.latency() == Duration{after == 1 ? 6'000'001 : 5'000'000});
    CHECK(latency.growths() == (after == 1));
  }
}

TEST_CASE("An adaptive latency beyond its largest is a fixed one") {
  AdaptiveLatency latency({{2'000'000}, {}, {4'000'000}, {1'000'000'000}, {1'000'000}, 5'000, Emission::hold});
  std::int64_t late = 0;
  for (std::int64_t n = 0; n < 50; ++n) {
    const RealTime read{n * 1'000'000};
    late += latency.emission(read, read + Duration{6'000'000}) < read + Duration{6'000'000};
    CHECK(latency.latency() == Duration{4'000'000});
  }
  CHECK(late == 50);
  CHECK(latency.growths() == 1);
}

TEST_CASE("A maximum over a window is that of a list which forgets nothing") {
  for_all_draws(kMany, [](Draw draw) -> const char* {
    const Duration window{draw.between(1, 10'000)};
    const std::int64_t length = (window.ns + 63) / 64;
    TrailingMaximum maximum(window);
    std::vector<std::pair<RealTime, Duration>> all;
    RealTime time{draw.between(-5'000, 5'000)};
    for (std::int64_t i = draw.between(1, 200); i > 0; --i) {
      if (i % 7 != 0) time = time + Duration{draw.between(0, draw.between(0, 9) == 0 ? 20'000 : 60)};
      all.emplace_back(time, Duration{draw.between(-50, 50)});
      const RealTime origin = all.front().first;
      maximum.add(time, all.back().second);
      Duration must{std::numeric_limits<std::int64_t>::min()}, may = must;
      for (const auto& [at, value] : all) {
        if (time - at < window) must = std::max(must, value);
        if ((time - origin).ns / length - (at - origin).ns / length <= 64) may = std::max(may, value);
      }
      if (maximum.largest() < must) return "something within the window is forgotten";
      if (maximum.largest() != may) return "something is kept for too long";
    }
    return nullptr;
  });
}

TEST_CASE("An adaptive latency outside its domain is an assertion") {
  const AdaptiveLatencyOptions good{{2}, {1}, {3}, {100}, {1}, 5'000, Emission::hold};
  CHECK_FALSE(asserts([&] { AdaptiveLatency latency(good); }));
  const auto refused = [&](auto change) {
    AdaptiveLatencyOptions bad = good;
    change(bad);
    return asserts([&] { AdaptiveLatency latency(bad); });
  };
  CHECK(refused([](auto& o) { o.start = {0}; }));
  CHECK(refused([](auto& o) { o.start = {4}; }));
  CHECK(refused([](auto& o) { o.margin = {-1}; }));
  CHECK(refused([](auto& o) { o.window = {0}; }));
  CHECK(refused([](auto& o) { o.slew_ppm = -1; }));
  CHECK(refused([](auto& o) { o.slew_ppm = kMostSlew_ppm + 1; }));
}
