// What a governor of visualizations costs: the drawings and the pace of records that are written by hand.
#include <optional>

#include "catch.h"
#include "evenstep/reports/measures.h"

using namespace evenstep;

namespace {

RealTime ms_at(std::int64_t ms) { return RealTime{ms * 1'000'000}; }

/// A run that is judged from 200 ms to 1,200 ms, with slots of 50 ms. It has no steps yet.
RunRecord judged_second() {
  RunRecord run;
  run.clock = "virtual";
  run.nominal.judged_from = ms_at(200);
  run.nominal.end = ms_at(1'200);
  run.nominal.slot_s = 50e-3;
  run.nominal.devices.push_back({"left", {}, {}, Rate{1'000, 1}, {}, std::nullopt});
  StrategyRecord& strategy = run.strategies.emplace_back();
  strategy.name = "paper";
  strategy.devices.emplace_back().name = "left";
  return run;
}

struct Drawn {
  std::int64_t from_ms, to_ms;
  bool finishes = true;
};
void add_segment(RunRecord& run, std::int64_t begin_ms, std::optional<Drawn> drawn, bool left_out = false) {
  SegmentRow row;
  row.index = std::ssize(run.strategies[0].segments);
  row.begin = ms_at(begin_ms);
  row.end = ms_at(begin_ms + 50);
  if (drawn) row.visualization = {{ms_at(drawn->from_ms), ms_at(drawn->to_ms)}};
  if (drawn) row.finishes = drawn->finishes;
  row.left_out = left_out;
  run.strategies[0].segments.push_back(row);
}

/// A run with every kind of segment. In the judged second, drawings end at 250, 530 and 620 ms.
RunRecord governed() {
  RunRecord run = judged_second();
  add_segment(run, 0, Drawn{0, 195});                  // over before
  add_segment(run, 100, std::nullopt, true);           // left out before
  add_segment(run, 196, Drawn{196, 250});              // reaches into it: 54 ms
  add_segment(run, 300, std::nullopt, true);           // left out
  add_segment(run, 400, Drawn{400, 470, false});       // a part before the last: 70 ms
  add_segment(run, 500, Drawn{500, 530});              // the last one: 30 ms, 280 ms after the drawing before
  add_segment(run, 600, Drawn{600, 620});              // 20 ms, 90 ms after
  add_segment(run, 700, std::nullopt);                 // nothing was to be drawn here
  add_segment(run, 900, std::nullopt, true);           // left out
  add_segment(run, 1'150, Drawn{1'150, 1'300});        // 50 ms of it; not finished in time
  add_segment(run, 1'200, std::nullopt, true);         // left out after the end
  add_segment(run, 1'250, Drawn{1'310, 1'500, true});  // after the end
  return run;
}

void add_steps(RunRecord& run, const std::vector<std::int64_t>& begins_ms) {
  StrategyRecord& strategy = run.strategies[0];
  for (const std::int64_t begin_ms : begins_ms) {
    StepRow row;
    row.begin = row.read = ms_at(begin_ms);
    row.end = row.emission = ms_at(begin_ms + 5);
    strategy.steps.push_back(row);
    strategy.devices[0].steps.emplace_back();
  }
}

std::optional<double> of(const RunRecord& run, const std::string& metric) {
  const Metrics metrics = measure(run);
  const auto signal = metrics.find("solver.paper");
  if (signal == metrics.end() || !signal->second.contains(metric)) return std::nullopt;
  return signal->second.at(metric);
}

}  // namespace

TEST_CASE("drawings: the rate counts those that finish in the judged span, not a part before the last nor one cut off") {
  RunRecord run = governed();
  CHECK(of(run, "drawing_rate") == 3.0);
  run.nominal.judged_from = ms_at(400);  // 530 and 620 ms in 0.8 s
  CHECK(of(run, "drawing_rate") == Approx(2 / 0.8).epsilon(1e-15));
  run.nominal.end = ms_at(620);  // the end itself does not count: 530 ms in 0.22 s
  CHECK(of(run, "drawing_rate") == Approx(1 / 0.22).epsilon(1e-15));
  run.strategies[0].segments[4].finishes = true;
  CHECK(of(run, "drawing_rate") == Approx(2 / 0.22).epsilon(1e-15));
}

TEST_CASE("drawings: left out are those that should have begun in the judged span, its begin included, its end not") {
  RunRecord run = governed();
  CHECK(of(run, "drawings_left_out") == 2.0);
  run.nominal.judged_from = ms_at(100);
  CHECK(of(run, "drawings_left_out") == 3.0);
  run.nominal.judged_from = ms_at(301);
  CHECK(of(run, "drawings_left_out") == 1.0);
  run.nominal.end = ms_at(1'201);
  CHECK(of(run, "drawings_left_out") == 2.0);
}

TEST_CASE("drawings: the longest pause is of a drawing or of a part, whole if it reaches in, cut at the end of the span") {
  RunRecord run = governed();
  CHECK(of(run, "drawing_pause_max") == Approx(70e-3).epsilon(1e-15));
  run.strategies[0].segments.erase(run.strategies[0].segments.begin() + 4);
  CHECK(of(run, "drawing_pause_max") == Approx(54e-3).epsilon(1e-15));
  run.nominal.end = ms_at(1'220);
  CHECK(of(run, "drawing_pause_max") == Approx(70e-3).epsilon(1e-15));  // 1,150 to 1,220 ms
  run.nominal.end = ms_at(1'400);
  CHECK(of(run, "drawing_pause_max") == Approx(150e-3).epsilon(1e-15));
  run.nominal.judged_from = ms_at(195);  // the first one ended there
  CHECK(of(run, "drawing_pause_max") == Approx(150e-3).epsilon(1e-15));
  run.nominal.judged_from = ms_at(194);
  CHECK(of(run, "drawing_pause_max") == Approx(195e-3).epsilon(1e-15));
}

TEST_CASE("drawings: the longest time without one counts from end to end, and the begin and the end of the span as ends") {
  RunRecord run = governed();
  CHECK(of(run, "drawing_interval_max") == Approx(580e-3).epsilon(1e-15));  // 620 ms to the end
  run.nominal.end = ms_at(800);
  CHECK(of(run, "drawing_interval_max") == Approx(280e-3).epsilon(1e-15));  // 250 to 530 ms
  run.nominal.judged_from = ms_at(251);
  CHECK(of(run, "drawing_interval_max") == Approx(279e-3).epsilon(1e-15));  // from the begin
  run.nominal.judged_from = ms_at(700);
  CHECK(of(run, "drawing_interval_max") == Approx(100e-3).epsilon(1e-15));  // no drawing: the whole span
}

TEST_CASE("drawings: a timing that draws nothing has no metrics of drawings, one that only leaves out has them") {
  RunRecord run = judged_second();
  for (std::int64_t k = 0; k < 10; ++k) add_segment(run, 200 + 100 * k, std::nullopt);
  for (const char* metric : {"drawing_rate", "drawings_left_out", "drawing_pause_max", "drawing_interval_max"})
    CHECK_FALSE(of(run, metric));
  run.strategies[0].segments[3].left_out = true;
  CHECK(of(run, "drawing_rate") == 0.0);
  CHECK(of(run, "drawings_left_out") == 1.0);
  CHECK(of(run, "drawing_pause_max") == 0.0);
  CHECK(of(run, "drawing_interval_max") == 1.0);
}

TEST_CASE("drawings: simulated per real time is the slots from the first judged step to the last over the time between") {
  RunRecord run = governed();
  add_steps(run, {150, 195, 210, 220, 300, 450, 1'199});  // judged: 210 to 1,199
  CHECK(of(run, "simulated_per_real") == Approx(4 * 50e-3 / 989e-3).epsilon(1e-15));
  run.nominal.judged_from = ms_at(211);  // 220 to 1,199
  CHECK(of(run, "simulated_per_real") == Approx(3 * 50e-3 / 979e-3).epsilon(1e-15));
  run.nominal.slot_s = 10e-3;
  CHECK(of(run, "simulated_per_real") == Approx(3 * 10e-3 / 979e-3).epsilon(1e-15));
  run.strategies[0].variable_step = true;  // a step has no slot
  CHECK_FALSE(of(run, "simulated_per_real"));
  run.strategies[0].variable_step = false;
  run.nominal.judged_from = ms_at(500);  // only one step, so there is no time between steps
  CHECK_FALSE(of(run, "simulated_per_real"));
}
