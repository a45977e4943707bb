#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>

#include "catch.h"
#include "timing_checks.h"

using namespace evenstep;

namespace {

/// The paper's numbers: 30 Hz, V = 11.1 ms, N = 15, the steps fill the rest.
const ProgrammedTiming kReference{};

struct NamedTiming {
  const char* description;
  ProgrammedTiming timing;
};

/// Timings with "fill" of every shape: short, long, incommensurable, one step, no step, no visualization, slowest and
/// fastest segments.
std::vector<NamedTiming> fills() {
  std::vector<NamedTiming> all = {
      {"the paper's", {}},
      {"no visualization", {.visualization = {0}}},
      {"one step", {.steps = {1}}},
      {"no step", {.steps = {0}}},
      {"neither", {.visualization = {0}, .steps = {0}}},
      {"N ns for N steps in the shortest segments", {.segment = {30, 1}, .visualization = {33'333'333 - 15}}},
      {"a segment of three seconds", {.segment = {1, 3}, .visualization = {1'000'000'007}, .steps = {1'001}}},
      {"NTSC", {.segment = {30'000, 1'001}, .visualization = {7'654'321}, .steps = {13}}},
      {"as long as scenarios may be: 10^6 s", {.segment = {1, 1'000'000}, .visualization = {1}, .steps = {20'000}}},
      {"1 kHz", {.segment = {1'000, 1}, .visualization = {333'333}, .steps = {7}}},
  };
  for (std::size_t i = 0, count = all.size(); i < count; ++i) {
    all.push_back(all[i]);
    all.back().timing.order = SegmentOrder::steps_first;
  }
  return all;
}

/// Whether `function` ends the process with an assertion.
template <class Function>
bool asserts(Function function) {
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGABRT, SIG_DFL);
    if (!std::freopen("/dev/null", "w", stderr)) _exit(1);
    function();
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT;
}

}  // namespace

TEST_CASE("the paper's boundaries are floor(k 1e9 / 30) over 10^6 segments: they do not drift", "[sweep]") {
  const auto timing = make_programmed_timing(kReference);
  SegmentTiming segment;
  std::int64_t wrong_boundary = 0, wrong_visualization = 0, wrong_step = 0, wrong_duration = 0;
  for (std::int64_t k = 0; k < 1'000'000; ++k) {
    REQUIRE(timing->next(segment));
    const std::int64_t begin = k * 1'000'000'000 / 30, end = (k + 1) * 1'000'000'000 / 30;
    wrong_boundary += segment.index != k || segment.begin.ns != begin || segment.end.ns != end;
    wrong_visualization += segment.visualization->begin.ns != begin || segment.visualization->end.ns != begin + 11'100'000;
    wrong_step += segment.steps.size() != 15 || segment.steps.front().begin.ns != begin + 11'100'000 ||
                  segment.steps.back().end.ns != end;
    for (std::size_t i = 0; i < segment.steps.size(); ++i) {
      wrong_step += i > 0 && segment.steps[i].begin != segment.steps[i - 1].end;
      // (T - V) / N = 1 482 222.2 ns
      const std::int64_t duration = length(segment.steps[i]).ns;
      wrong_duration += duration != 1'482'222 && duration != 1'482'223;
    }
  }
  CHECK(wrong_boundary == 0);
  CHECK(wrong_visualization == 0);
  CHECK(wrong_step == 0);
  CHECK(wrong_duration == 0);
  CHECK(segment.end.ns == 33'333'333'333'333);  // 10^6 / 30 s
}

TEST_CASE("filling steps share the rest of every segment evenly to 1 ns and leave nothing idle", "[sweep]") {
  for (const auto& [description, programmed] : fills()) {
    INFO(description << (programmed.order == SegmentOrder::steps_first ? ", steps first" : ", visualization first"));
    const auto segments = play(programmed, 300);
    CHECK(disorder(segments) == 0);
    std::int64_t wrong = 0;
    for (const SegmentTiming& segment : segments) {
      wrong += segment.begin != tick_time(programmed.segment, segment.index) ||
               segment.end != tick_time(programmed.segment, segment.index + 1);
      wrong += segment.steps.size() != static_cast<std::size_t>(programmed.steps.front());
      wrong += segment.visualization.has_value() != (programmed.visualization.ns > 0);
      if (segment.steps.empty()) continue;
      wrong += idle(segment) != Duration{0};
      const auto durations = step_durations({segment});
      const auto [shortest, longest] = std::minmax_element(durations.begin(), durations.end());
      wrong += *longest - *shortest > Duration{1};
    }
    CHECK(wrong == 0);
  }
}

TEST_CASE("the visualization begins the segment, or ends it where the steps come first") {
  for (const auto& [description, programmed] : fills()) {
    INFO(description);
    std::int64_t wrong = 0;
    for (const SegmentTiming& segment : play(programmed, 100)) {
      if (!segment.visualization) continue;
      const Interval visualization = *segment.visualization;
      wrong += length(visualization) != programmed.visualization;
      wrong += programmed.order == SegmentOrder::steps_first ? visualization.end != segment.end
                                                             : visualization.begin != segment.begin;
      if (segment.steps.empty()) continue;
      wrong +=
          segment.steps.front().begin != (programmed.order == SegmentOrder::steps_first ? segment.begin : visualization.end);
    }
    CHECK(wrong == 0);
  }
}

TEST_CASE("T 32 ms, V 8 ms and 16 steps of 1.5 ms fill the segment exactly, and tie with a 1 kHz tick at every other step") {
  const ProgrammedTiming ties{.segment = {125, 4}, .visualization = {8'000'000}, .steps = {16}, .step = Duration{1'500'000}};
  const auto segments = play(ties, 10'000);
  CHECK(disorder(segments) == 0);
  std::int64_t wrong = 0, launches_at_a_tick = 0;
  for (const SegmentTiming& segment : segments) {
    wrong += segment.begin.ns != segment.index * 32'000'000 || idle(segment) != Duration{0};
    for (std::int64_t i = 0; i < 16; ++i) {
      wrong += segment.steps[i].begin.ns != segment.begin.ns + 8'000'000 + i * 1'500'000 ||
               length(segment.steps[i]).ns != 1'500'000;
      launches_at_a_tick += segment.steps[i].begin.ns % 1'000'000 == 0;
    }
  }
  CHECK(wrong == 0);
  CHECK(launches_at_a_tick == 10'000 * 8);
}

TEST_CASE("a fixed step shorter than the fill keeps the boundaries of the rate, the rest is idle after the steps") {
  for (const bool steps_first : {false, true}) {
    for (const std::int64_t step_ns : {1LL, 1'000'000LL, 1'482'221LL, 1'482'222LL}) {
      INFO("steps first " << steps_first << ", step " << step_ns);
      const ProgrammedTiming programmed{
          .step = Duration{step_ns}, .order = steps_first ? SegmentOrder::steps_first : SegmentOrder::visualization_first};
      const auto segments = play(programmed, 1'000);
      CHECK(disorder(segments) == 0);
      std::int64_t wrong = 0;
      for (const SegmentTiming& segment : segments) {
        const RealTime first_step = segment.begin + (steps_first ? Duration{0} : Duration{11'100'000});
        const RealTime visualization = steps_first ? segment.end - Duration{11'100'000} : segment.begin;
        wrong += segment.begin != tick_time({30, 1}, segment.index) || segment.end != tick_time({30, 1}, segment.index + 1);
        wrong += segment.visualization->begin != visualization || length(*segment.visualization).ns != 11'100'000;
        for (std::int64_t i = 0; i < 15; ++i) {
          wrong += segment.steps[i].begin != first_step + Duration{step_ns} * i || length(segment.steps[i]).ns != step_ns;
        }
        wrong += idle(segment) != segment.end - segment.begin - Duration{11'100'000 + 15 * step_ns};
      }
      CHECK(wrong == 0);
    }
  }
}

TEST_CASE("1 ns more than fits in a segment is refused by an assertion") {
  const auto make = [](const ProgrammedTiming& timing) { return [timing] { make_programmed_timing(timing); }; };
  const ProgrammedTiming ties{.segment = {125, 4}, .visualization = {8'000'000}, .steps = {16}, .step = Duration{1'500'000}};
  ProgrammedTiming too_long = ties;
  too_long.visualization.ns += 1;
  CHECK_FALSE(asserts(make(ties)));
  CHECK(asserts(make(too_long)));

  // 1/30 s is 33 333 333.3 ns, so everything must fit in segments of 33 333 333 ns.
  CHECK_FALSE(asserts(make({.visualization = {33'333'333 - 15}})));
  CHECK(asserts(make({.visualization = {33'333'333 - 14}})));
  CHECK(asserts(make({.steps = {}})));
  CHECK(asserts(make({.steps = {-1}})));
  CHECK(asserts(make({.step = Duration{0}})));
}

TEST_CASE("the segment handed in is overwritten whole, whatever it held") {
  const auto timing = make_programmed_timing({.visualization = {0}, .steps = {3}});
  SegmentTiming reused{
      .index = 99, .begin = {1}, .visualization = Interval{{5}, {6}}, .steps = std::vector<Interval>(20), .end = {2}};
  REQUIRE(timing->next(reused));
  CHECK(digest_of({reused}) == digest_of(play({.visualization = {0}, .steps = {3}}, 1)));
}
