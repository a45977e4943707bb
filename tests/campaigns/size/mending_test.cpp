// What is blamed for a late step, and whether mending it wins what is said. The tests know the schedule without the fault.
#include "src/size/mend.h"

#include "traces.h"

using namespace evenstep;
using namespace evenstep::internal;
using namespace evenstep::testing;

namespace {

/// 10 ms of visualization, 10 steps of 2 ms, back to back.
std::vector<SegmentTiming> back_to_back(std::size_t count) {
  return play({.segment = {1000, 30}, .visualization = {10 * ms}, .steps = {10}, .step = Duration{2 * ms}}, count);
}
/// The same with 5 ms of idle time at the end of each segment.
std::vector<SegmentTiming> with_idle(std::size_t count) {
  return play({.segment = {1000, 35}, .visualization = {10 * ms}, .steps = {10}, .step = Duration{2 * ms}}, count);
}

void push_back(SegmentTiming& segment, std::size_t from_step, Duration by) {
  for (std::size_t i = from_step; i < segment.steps.size(); ++i)
    segment.steps[i] = {segment.steps[i].begin + by, segment.steps[i].end + by};
}

/// Makes the visualization of segment k longer by `by`. What follows waits, as far as there is no idle time.
void lengthen_visualization(std::vector<SegmentTiming>& segments, std::size_t k, Duration by, bool all_after) {
  segments[k].visualization->end = segments[k].visualization->end + by;
  push_back(segments[k], 0, by);
  for (std::size_t j = k + 1; all_after && j < segments.size(); ++j) {
    segments[j].begin = segments[j].begin + by;
    segments[j].visualization = {segments[j].visualization->begin + by, segments[j].visualization->end + by};
    push_back(segments[j], 0, by);
  }
}

bool same_steps(const std::vector<SegmentTiming>& a, const std::vector<SegmentTiming>& b) {
  for (std::size_t k = 0; k < a.size(); ++k) {
    if (a[k].begin != b[k].begin || a[k].steps.size() != b[k].steps.size()) return false;
    for (std::size_t i = 0; i < a[k].steps.size(); ++i) {
      if (a[k].steps[i].begin != b[k].steps[i].begin || a[k].steps[i].end != b[k].steps[i].end) return false;
    }
  }
  return a.size() == b.size();
}

/// The segments as they are while the culprit is mended.
std::vector<SegmentTiming> mended(std::vector<SegmentTiming> segments, std::int64_t step) {
  Mending mending(segments);
  const std::vector<SegmentTiming> before = segments;
  std::vector<SegmentTiming> seen;
  REQUIRE(mending.mended(mending.blame(step), [&] { seen = segments; }));
  CHECK(same_steps(segments, before));  // they are put back afterwards
  return seen;
}

std::vector<SegmentTiming> without_visualizations(std::vector<SegmentTiming> segments) {
  for (SegmentTiming& segment : segments) {
    segment.visualization.reset();
    segment.begin = segment.steps.front().begin;
  }
  return segments;
}

}  // namespace

TEST_CASE("a long visualization is blamed on the first step behind it for every step of its segment and the next two") {
  auto segments = back_to_back(40);
  lengthen_visualization(segments, 20, {7 * ms}, true);
  const Mending mending(segments);
  for (std::int64_t step = 200; step < 230; ++step) {
    const SizeCulprit culprit = mending.blame(step);
    REQUIRE(culprit.step == step);
    REQUIRE(culprit.segment == step / 10);
    REQUIRE(culprit.index == step % 10);
    REQUIRE(culprit.late_step == 200);
    REQUIRE(culprit.pause_excess.ns == 7 * ms);
    REQUIRE(culprit.run_excess.ns == 0);
  }
  CHECK(mending.blame(199).late_step == -1);
  CHECK(mending.blame(230).late_step == -1);
}

TEST_CASE("mended is the schedule without the fault and nothing behind idle time moves") {
  for (const std::size_t k : {0U, 20U, 39U}) {
    auto late = back_to_back(40);
    lengthen_visualization(late, k, {7 * ms}, true);
    CHECK(same_steps(mended(late, static_cast<std::int64_t>(10 * k + 9)), back_to_back(40)));
    auto idle = with_idle(40);
    lengthen_visualization(idle, k, {3 * ms}, false);
    CHECK(same_steps(mended(idle, static_cast<std::int64_t>(10 * k + 9)), with_idle(40)));
  }
}

TEST_CASE("a step that ran long is mended by its own length and a pause between steps too") {
  auto late = with_idle(40);
  late[20].steps[3].end = late[20].steps[3].end + Duration{2 * ms};
  push_back(late[20], 4, {2 * ms});
  {
    const Mending mending(late);
    CHECK(mending.blame(204).late_step == 203);
    CHECK(mending.blame(204).run_excess.ns == 2 * ms);
    CHECK(mending.blame(202).late_step == -1);
    CHECK(mending.blame_run_time(203).run_excess.ns == 2 * ms);
    CHECK(mending.blame_run_time(204).late_step == -1);
  }
  CHECK(same_steps(mended(late, 205), with_idle(40)));
  auto paused = with_idle(40);
  push_back(paused[20], 3, {200'000});  // below 1 % of the segment, so it does not count as idle time
  CHECK(same_steps(mended(paused, 205), with_idle(40)));
}

TEST_CASE("without visualizations the pause is the gap and only free running segments move up") {
  auto free = back_to_back(40);
  for (std::size_t k = 0; k < 40; ++k)  // lengths that differ by 10 % are not paced
    lengthen_visualization(free, k, {static_cast<std::int64_t>(k % 3) * 3 * ms}, true);
  auto late = free;
  lengthen_visualization(late, 20, {7 * ms}, true);
  const auto seen = mended(without_visualizations(late), 209);
  // Segment 20 has a pause of 16 ms, and of 23 ms where it is late. The usual pause is 13 ms.
  lengthen_visualization(free, 20, {-3 * ms}, true);
  CHECK(same_steps(seen, without_visualizations(free)));

  auto paced = with_idle(40);
  lengthen_visualization(paced, 20, {3 * ms}, false);
  CHECK(same_steps(mended(without_visualizations(paced), 209), without_visualizations(with_idle(40))));
}

TEST_CASE("where nothing is late nobody is blamed and a step 1 % longer than usual is not late") {
  auto segments = with_idle(40);
  segments[20].steps[3].end = segments[20].steps[3].end + Duration{20'000};
  segments[20].steps[4].begin = segments[20].steps[3].end;
  const Mending mending(segments);
  for (std::int64_t step = 0; step < 400; ++step) REQUIRE(mending.blame(step).late_step == -1);
}

TEST_CASE("the mended latency is that of the schedule without the fault for maps and bounds") {
  auto late = back_to_back(60);
  lengthen_visualization(late, 30, {7 * ms}, true);
  const SizeRecord record = size_segments(late, "", {}), whole = size_segments(back_to_back(60), "", {});
  CHECK(record.held.best_line.latency > whole.held.best_line.latency);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(record.strategies[i].any_phase.latency > whole.strategies[i].any_phase.latency);
    CHECK(record.strategies[i].any_phase.culprit.late_step == 300);
    CHECK(record.strategies[i].any_phase.culprit.mended_latency == whole.strategies[i].any_phase.latency);
  }
  auto slow = with_idle(60);
  slow[30].steps[3].end = slow[30].steps[3].end + Duration{2 * ms};
  push_back(slow[30], 4, {2 * ms});
  const SizeRecord spike = size_segments(slow, "", {});
  CHECK(spike.held.taut_string.latency.ns == 4 * ms + 999'999);
  CHECK(spike.held.taut_string.culprit.step == 303);
  CHECK(spike.held.taut_string.culprit.mended_latency.ns == 2 * ms + 999'999);
}
