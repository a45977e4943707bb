// The remap as C sees it: it gives the same numbers as the C++ Remapper, and an error code for every wrong call.

#include <evenstep_remap.h>

#include <cstddef>
#include <limits>
#include <thread>

#include "catch.h"
#include "evenstep/remap/remapper.h"
#include "random_calls.h"

using namespace evenstep;
using namespace evenstep::testing;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

evenstep_remap_options defaults() {
  evenstep_remap_options options;
  REQUIRE(evenstep_remap_options_init(&options, sizeof options) == EVENSTEP_REMAP_OK);
  return options;
}

/// A handle that destroys itself.
struct Handle {
  explicit Handle(const evenstep_remap_options& options = defaults()) {
    REQUIRE(evenstep_remap_create(&options, &remap) == EVENSTEP_REMAP_OK);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() { evenstep_remap_destroy(remap); }
  operator evenstep_remap*() const { return remap; }
  evenstep_remap* remap = nullptr;
};

evenstep_remap_counts counts_of(const evenstep_remap* remap) {
  evenstep_remap_counts counts;
  counts.struct_size = sizeof counts;
  REQUIRE(evenstep_remap_get_counts(remap, &counts) == EVENSTEP_REMAP_OK);
  return counts;
}

RemapperOptions same(const evenstep_remap_options& c) {
  RemapperOptions options{.lead = {c.lead_ns},
                          .latency = {c.latency_ns},
                          .emission = c.emission == EVENSTEP_REMAP_HOLD ? Emission::hold : Emission::linear,
                          .past_newest_sample = {{c.sample_window_ns}, {c.sample_furthest_ns}},
                          .past_newest_force = {{c.force_window_ns}, {c.force_furthest_ns}},
                          .interaction_capacity = c.sample_capacity,
                          .force_capacity = c.force_capacity};
  if (c.adapts == 1) options.adapt = {.start = {c.adapt_start_ns}, .least = {}, .most = {c.adapt_most_ns}};
  return options;
}

/// The number of calls whose result differs from that of the C++ Remapper, which takes values of eight components.
std::int64_t differences(const std::vector<remap_c_call>& calls, Remapper<std::array<double, 8>>& remap, std::size_t size) {
  std::int64_t differ = 0;
  for (const remap_c_call& call : calls) {
    std::array<double, 8> value{}, given{};
    std::copy_n(call.value, size, given.begin());
    const RealTime at{call.at_ns};
    const auto is = [&](ReadStatus status) { return given == value && call.status == static_cast<std::uint32_t>(status); };
    if (call.what == REMAP_C_SAMPLE) remap.sample(at, given);
    if (call.what == REMAP_C_SEGMENT) remap.segment(at);
    if (call.what == REMAP_C_END_STEP) differ += remap.end_step(at, given).at.ns != call.time_ns;
    if (call.what == REMAP_C_FORCE) {
      const auto force = remap.force(at);
      value = force.value;
      differ += !is(force.status);
    }
    if (call.what == REMAP_C_BEGIN_STEP) {
      const auto [slot, hand] = remap.begin_step(at);
      value = hand.value;
      differ += !is(hand.status) || call.time_ns != slot.read.ns || (call.has_slot == 1) != (slot.kind == SlotKind::mapped);
    }
  }
  return differ;
}

bool equal(const evenstep_remap_counts& c, const RemapCounts& counts) {
  const auto reads = [](const ReadCounts& r) { return std::array{r.inside, r.held, r.extrapolated, r.overruns, r.empty}; };
  return c.steps == counts.steps && c.acquiring == counts.acquiring && c.late_forces == counts.late_forces &&
         c.latest_force_ns == counts.latest_force.ns &&
         reads(counts.hand) == std::array{c.hand_inside, c.hand_held, c.hand_extrapolated, c.hand_overruns, c.hand_empty} &&
         reads(counts.force) ==
             std::array{c.force_inside, c.force_held, c.force_extrapolated, c.force_overruns, c.force_empty};
}

/// Does a call have the expected code, and does the text of the error contain these words?
bool refused(int code, int expected, const std::string& words) {
  INFO(evenstep_remap_last_error());
  return code == expected && std::string(evenstep_remap_last_error()).find(words) != std::string::npos;
}

}  // namespace

TEST_CASE("C99 and C++ get the numbers of the C++ Remapper from evenstep_remap.h, on 200 random schedules") {
  const auto play = GENERATE(&remap_c_play, &remap_c_play_as_cpp);
  std::uint64_t late = 0, extrapolated = 0, overruns = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    INFO("seed " << seed);
    Draw draw(seed);
    const evenstep_remap_options options = random_options(defaults(), draw);
    std::vector<remap_c_call> calls = calls_of(random_schedule(draw, 20), draw);
    evenstep_remap_counts counts;
    REQUIRE(play(&options, calls.data(), static_cast<int>(calls.size()), &counts) == EVENSTEP_REMAP_OK);
    Remapper<std::array<double, 8>> remap(same(options));
    CHECK(differences(calls, remap, options.components) == 0);
    CHECK(equal(counts, remap.counts()));
    late += counts.late_forces;
    extrapolated += counts.hand_extrapolated + counts.force_extrapolated;
    overruns += counts.hand_overruns + counts.force_overruns;
  }
  CHECK((late > 0 && extrapolated > 0 && overruns > 0));  // all three happen in these schedules
}

TEST_CASE("options outside their range are refused by name, and no handle is made") {
  struct Wrong {
    const char* words;
    void (*change)(evenstep_remap_options&);
  };
  const Wrong wrong = GENERATE(values<Wrong>({
      {"components is 0, not in 1 to 8", [](auto& o) { o.components = 0; }},
      {"components is 9", [](auto& o) { o.components = 9; }},
      {"lead_ns", [](auto& o) { o.lead_ns = INT64_MIN; }},
      {"latency_ns", [](auto& o) { o.latency_ns = -1; }},
      {"latency_ns", [](auto& o) { o.latency_ns = EVENSTEP_REMAP_LONGEST_NS + 1; }},
      {"emission", [](auto& o) { o.emission = 2; }},
      {"adapts", [](auto& o) { o.adapts = 2; }},
      {"bandwidth_Hz", [](auto& o) { o.bandwidth_Hz = 0; }},
      {"bandwidth_Hz", [](auto& o) { o.bandwidth_Hz = kNaN; }},
      {"sample_capacity", [](auto& o) { o.sample_capacity = 1; }},
      {"force_capacity", [](auto& o) { o.force_capacity = EVENSTEP_REMAP_MOST_ENTRIES + 1; }},
      {"sample_window_ns", [](auto& o) { o.sample_window_ns = -1; }},
      {"sample_furthest_ns", [](auto& o) { o.sample_furthest_ns = -1; }},
      {"force_window_ns", [](auto& o) { o.force_window_ns = -1; }},
      {"force_furthest_ns", [](auto& o) { o.force_furthest_ns = -1; }},
      {"adapt_least_ns", [](auto& o) { o.adapts = 1, o.adapt_least_ns = -1; }},
      {"adapt_start_ns", [](auto& o) { o.adapts = 1, o.adapt_least_ns = 2, o.adapt_start_ns = 1; }},
      {"adapt_most_ns", [](auto& o) { o.adapts = 1, o.adapt_start_ns = 2, o.adapt_most_ns = 1; }},
      {"adapt_window_ns", [](auto& o) { o.adapts = 1, o.adapt_window_ns = 0; }},
      {"adapt_margin_ns", [](auto& o) { o.adapts = 1, o.adapt_margin_ns = -1; }},
      {"adapt_slew_ppm", [](auto& o) { o.adapts = 1, o.adapt_slew_ppm = 500'001; }},
  }));
  evenstep_remap_options options = defaults();
  wrong.change(options);
  evenstep_remap* remap = reinterpret_cast<evenstep_remap*>(&options);
  CHECK(refused(evenstep_remap_create(&options, &remap), EVENSTEP_REMAP_INVALID, wrong.words));
  CHECK(remap == nullptr);
}

TEST_CASE("a struct of another size and a null pointer are refused, and destroying nothing is allowed") {
  evenstep_remap_options options = defaults();
  evenstep_remap* remap = nullptr;
  CHECK(refused(evenstep_remap_options_init(&options, sizeof options - 1), EVENSTEP_REMAP_ABI_SIZE, "struct_size"));
  CHECK(refused(evenstep_remap_options_init(nullptr, 0), EVENSTEP_REMAP_INVALID, "options is NULL"));
  options.struct_size += 8;
  CHECK(refused(evenstep_remap_create(&options, &remap), EVENSTEP_REMAP_ABI_SIZE, "sizeof"));
  CHECK(refused(evenstep_remap_create(nullptr, &remap), EVENSTEP_REMAP_INVALID, "options is NULL"));
  CHECK(refused(evenstep_remap_create(&options, nullptr), EVENSTEP_REMAP_INVALID, "remap is NULL"));
  evenstep_remap_destroy(nullptr);

  double value[3] = {1, 2, 3};
  const Handle handle;
  evenstep_remap_read read{};
  evenstep_remap_counts counts{};
  CHECK(refused(evenstep_remap_begin_step(handle, 0, value, &read), EVENSTEP_REMAP_ABI_SIZE, "evenstep_remap_begin_step"));
  CHECK(refused(evenstep_remap_get_counts(handle, &counts), EVENSTEP_REMAP_ABI_SIZE, "evenstep_remap_get_counts"));
  CHECK(refused(evenstep_remap_get_counts(handle, nullptr), EVENSTEP_REMAP_INVALID, "counts is NULL"));
  CHECK(refused(evenstep_remap_get_counts(nullptr, &counts), EVENSTEP_REMAP_INVALID, "remap is NULL"));
  CHECK(refused(evenstep_remap_sample(nullptr, 0, value), EVENSTEP_REMAP_INVALID, "remap is NULL"));
  CHECK(refused(evenstep_remap_sample(handle, 0, nullptr), EVENSTEP_REMAP_INVALID, "position is NULL"));
  CHECK(refused(evenstep_remap_force(nullptr, 0, value, nullptr), EVENSTEP_REMAP_INVALID, "remap is NULL"));
  CHECK(refused(evenstep_remap_force(handle, 0, nullptr, nullptr), EVENSTEP_REMAP_INVALID, "force is NULL"));
  CHECK(refused(evenstep_remap_segment(nullptr, 0), EVENSTEP_REMAP_INVALID, "remap is NULL"));
  CHECK(refused(evenstep_remap_begin_step(nullptr, 0, value, nullptr), EVENSTEP_REMAP_INVALID, "remap is NULL"));
  CHECK(refused(evenstep_remap_begin_step(handle, 0, nullptr, nullptr), EVENSTEP_REMAP_INVALID, "position is NULL"));
  CHECK(refused(evenstep_remap_end_step(nullptr, 0, value, nullptr), EVENSTEP_REMAP_INVALID, "remap is NULL"));
  CHECK(refused(evenstep_remap_end_step(handle, 0, nullptr, nullptr), EVENSTEP_REMAP_INVALID, "force is NULL"));
  CHECK(counts_of(handle).steps == 0);
}

TEST_CASE("calls out of order, times that go back and values that are not finite are refused and change nothing") {
  double value[3] = {1, 2, 3}, wrong[3] = {1, kNaN, 3};
  const Handle handle;
  CHECK(refused(evenstep_remap_sample(handle, 0, wrong), EVENSTEP_REMAP_INVALID, "position[1] is not finite"));
  REQUIRE(evenstep_remap_sample(handle, 10, value) == EVENSTEP_REMAP_OK);
  CHECK(refused(evenstep_remap_sample(handle, 9, value), EVENSTEP_REMAP_ORDER, "now_ns is 9 ns, before"));
  CHECK(refused(evenstep_remap_sample(handle, INT64_MAX, value), EVENSTEP_REMAP_INVALID, "now_ns"));
  CHECK(refused(evenstep_remap_force(handle, INT64_MIN, value, nullptr), EVENSTEP_REMAP_INVALID, "now_ns"));

  REQUIRE(evenstep_remap_segment(handle, 10) == EVENSTEP_REMAP_OK);
  CHECK(refused(evenstep_remap_segment(handle, 9), EVENSTEP_REMAP_ORDER, "begin_ns is 9 ns"));
  CHECK(refused(evenstep_remap_end_step(handle, 10, value, nullptr), EVENSTEP_REMAP_ORDER, "no step has begun"));
  double position[3];
  REQUIRE(evenstep_remap_begin_step(handle, 20, position, nullptr) == EVENSTEP_REMAP_OK);
  CHECK(position[2] == 3);  // the newest sample
  CHECK(refused(evenstep_remap_begin_step(handle, 21, position, nullptr), EVENSTEP_REMAP_ORDER, "has not ended"));
  CHECK(refused(evenstep_remap_segment(handle, 21), EVENSTEP_REMAP_ORDER, "has begun and not ended"));
  CHECK(refused(evenstep_remap_end_step(handle, 19, value, nullptr), EVENSTEP_REMAP_ORDER, "now_ns is 19 ns"));
  CHECK(refused(evenstep_remap_end_step(handle, 21, wrong, nullptr), EVENSTEP_REMAP_INVALID, "force[1] is not finite"));
  REQUIRE(evenstep_remap_end_step(handle, 21, value, nullptr) == EVENSTEP_REMAP_OK);  // the step was still open
  CHECK(counts_of(handle).steps == 1);
  CHECK(counts_of(handle).acquiring == 1);
}

TEST_CASE("no call of a million with any numbers at all stops the program or gives an unknown code") {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Draw draw(seed);
    const Handle handle(random_options(defaults(), draw));
    std::int64_t now = 0;
    double value[8] = {};
    for (int i = 0; i < 20'000; ++i) {
      // Mostly a little later, at times as far as is allowed, or any number at all.
      const std::int64_t furthest =
          draw.between(0, 1'000) == 0 ? EVENSTEP_REMAP_FURTHEST_NS : std::int64_t{1} << draw.between(0, 40);
      now = std::min(now + draw.between(0, furthest), EVENSTEP_REMAP_FURTHEST_NS);
      const std::int64_t at = draw.between(0, 50) == 0 ? static_cast<std::int64_t>(draw.next()) : now;
      value[0] = draw.between(0, 50) == 0 ? kNaN : std::ldexp(draw.unit(), static_cast<int>(draw.between(-1'000, 1'000)));
      int code = 0;
      switch (draw.between(0, 5)) {
        case 0:
          code = evenstep_remap_sample(handle, at, value);
          break;
        case 1:
          code = evenstep_remap_force(handle, at, value, nullptr);
          break;
        case 2:
          code = evenstep_remap_segment(handle, at);
          break;
        case 3:
          code = evenstep_remap_begin_step(handle, at, value, nullptr);
          break;
        default:
          code = evenstep_remap_end_step(handle, at, value, nullptr);
          break;
      }
      if (code != EVENSTEP_REMAP_OK && code != EVENSTEP_REMAP_INVALID && code != EVENSTEP_REMAP_ORDER) FAIL("code " << code);
      if (code == EVENSTEP_REMAP_OK && at != now) now = at;
    }
  }
}

TEST_CASE("a device thread and a simulation thread use one handle at the same time, and a third takes the counts") {
  const Handle handle;
  constexpr std::int64_t kMs = 1'000'000, kSteps = 20'000;
  std::atomic<bool> done{false};
  std::atomic<int> refused_calls{0};
  const auto accept = [&](int code) { refused_calls += code != EVENSTEP_REMAP_OK; };
  std::thread device([&] {
    double force[3];
    for (std::int64_t tick = 0; !done; ++tick) {
      const double position[3] = {static_cast<double>(tick), 0, 0};
      accept(evenstep_remap_sample(handle, tick * kMs, position));
      accept(evenstep_remap_force(handle, tick * kMs, force, nullptr));
    }
  });
  std::thread third([&] {
    evenstep_remap_counts counts{};
    counts.struct_size = sizeof counts;
    while (!done) accept(evenstep_remap_get_counts(handle, &counts));
  });
  double position[3];
  for (std::int64_t n = 0; n < kSteps; ++n) {
    if (n % 10 == 0) accept(evenstep_remap_segment(handle, n * kMs));
    accept(evenstep_remap_begin_step(handle, n * kMs, position, nullptr));
    accept(evenstep_remap_end_step(handle, n * kMs + kMs / 2, position, nullptr));
  }
  done = true;
  device.join();
  third.join();
  CHECK(refused_calls == 0);
  CHECK(counts_of(handle).steps == kSteps);
}

TEST_CASE("an error's text belongs to the thread whose call was refused") {
  const Handle handle;
  CHECK(evenstep_remap_segment(nullptr, 0) == EVENSTEP_REMAP_INVALID);
  std::string text;
  std::thread([&] {
    text = evenstep_remap_last_error();
    evenstep_remap_end_step(handle, 0, nullptr, nullptr);
  }).join();
  CHECK(text.empty());
  CHECK(std::string(evenstep_remap_last_error()) == "evenstep_remap_segment: remap is NULL");
}

// Other languages write this layout down by hand. It changes only with EVENSTEP_REMAP_ABI.
TEST_CASE("the structs of the C header keep their layout, and the library its version") {
  CHECK(evenstep_remap_abi() == 1);
  static_assert(sizeof(evenstep_remap_options) == 128 && offsetof(evenstep_remap_options, bandwidth_Hz) == 32 &&
                offsetof(evenstep_remap_options, sample_window_ns) == 48 &&
                offsetof(evenstep_remap_options, adapt_slew_ppm) == 120);
  static_assert(sizeof(evenstep_remap_read) == 32 && offsetof(evenstep_remap_read, has_slot) == 24);
  static_assert(sizeof(evenstep_remap_clock) == 32 && offsetof(evenstep_remap_clock, dropped_jump_ns) == 24);
  static_assert(sizeof(evenstep_remap_counts) == 120 && offsetof(evenstep_remap_counts, force_empty) == 112);
}

TEST_CASE("a first segment of 60 years does not carry the slots out of time") {
  double value[3] = {};
  const Handle handle;
  const auto step = [&](std::int64_t at) {
    REQUIRE(evenstep_remap_begin_step(handle, at, value, nullptr) == EVENSTEP_REMAP_OK);
    REQUIRE(evenstep_remap_end_step(handle, at, value, nullptr) == EVENSTEP_REMAP_OK);
  };
  REQUIRE(evenstep_remap_segment(handle, -EVENSTEP_REMAP_FURTHEST_NS) == EVENSTEP_REMAP_OK);
  step(-EVENSTEP_REMAP_FURTHEST_NS);
  REQUIRE(evenstep_remap_segment(handle, EVENSTEP_REMAP_FURTHEST_NS) == EVENSTEP_REMAP_OK);
  for (int n = 0; n < 1'000; ++n) step(EVENSTEP_REMAP_FURTHEST_NS);  // each slot is a tenth of the pace after the one before
  CHECK(counts_of(handle).steps == 1'001);
}

TEST_CASE("a handle of a loop with its own time has the slots of the C++ Remapper, dropped time and all") {
  const Clocked same{{90, 1}, {700'000}};
  evenstep_remap_clock clock{
      .struct_size = sizeof clock, .reserved = 0, .steps = 90, .seconds = 1, .dropped_jump_ns = 700'000};
  const evenstep_remap_options options = defaults();
  evenstep_remap* remap = nullptr;
  REQUIRE(evenstep_remap_create_clocked(&options, &clock, &remap) == EVENSTEP_REMAP_OK);
  Remapper<std::array<double, 3>> expected({.clocked = same});
  evenstep_remap_read read{};
  read.struct_size = sizeof read;
  double value[3] = {};
  for (std::int64_t n = 0; n < 300; ++n) {
    const std::int64_t at = n * 12'000'000, t = sim_time({90, 1}, n + n / 50).ns;  // a step is dropped now and then
    REQUIRE(evenstep_remap_begin_step_at(remap, at, t, value, &read) == EVENSTEP_REMAP_OK);
    CHECK(read.has_slot == 1);
    CHECK(read.read_ns == expected.begin_step({at}, SimTime{t}).slot.read.ns);
    std::int64_t emission = 0;
    REQUIRE(evenstep_remap_end_step(remap, at, value, &emission) == EVENSTEP_REMAP_OK);
    CHECK(emission == expected.end_step({at}, {}).at.ns);
  }
  evenstep_remap_destroy(remap);

  const auto refused = [&](std::int64_t& field, std::int64_t wrong, const char* error) {
    const std::int64_t right = std::exchange(field, wrong);
    CHECK(evenstep_remap_create_clocked(&options, &clock, &remap) == EVENSTEP_REMAP_INVALID);
    CHECK(remap == nullptr);
    CHECK(std::string(evenstep_remap_last_error()) == std::string("evenstep_remap_create_clocked: ") + error);
    field = right;
  };
  refused(clock.steps, 0, "steps is 0, not in 1 to 1000000000");
  refused(clock.seconds, 0, "seconds is 0, not in 1 to 1000000000");
  refused(clock.dropped_jump_ns, -1, "dropped_jump_ns is -1, not in 0 to 1000000000000000");
  CHECK(evenstep_remap_create_clocked(&options, nullptr, &remap) == EVENSTEP_REMAP_INVALID);
  clock.struct_size = 8;
  CHECK(evenstep_remap_create_clocked(&options, &clock, &remap) == EVENSTEP_REMAP_ABI_SIZE);
  const Handle plain;
  CHECK(evenstep_remap_begin_step_at(plain, 0, INT64_MAX, value, nullptr) == EVENSTEP_REMAP_INVALID);
  CHECK(evenstep_remap_begin_step_at(plain, 0, 0, value, nullptr) == EVENSTEP_REMAP_OK);
}
