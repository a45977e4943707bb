// What forgets behaves afterwards as if it were new. (phase_locked: phase_locked_map_test.cpp; an adaptive latency and its
// window, compared with lists that forget nothing: budget/adaptive_latency_test.cpp.)

#include "evenstep/remap/buffer_oracle.h"
#include "evenstep/remap/filters.h"
#include "evenstep/remap/resampler.h"
#include "for_all.h"

using namespace evenstep;
using namespace evenstep::testing;

namespace {

bool same(const LatencyBudget& a, const LatencyBudget& b) {
  return a.lead == b.lead && a.latency == b.latency && a.lead_culprit == b.lead_culprit &&
         a.latency_culprit == b.latency_culprit;
}

/// The steps after any one of them, given in pieces; `before` says whether those up to it are given, too, and forgotten.
template <class Sum, class Add>
void second_part(Sum& sum, const std::vector<MappedStep>& steps, Draw draw, bool before, Add add) {
  const auto middle = static_cast<std::size_t>(draw.between(0, std::ssize(steps)));
  if (before) {
    for (std::size_t n = 0; n < middle; ++n) add(sum, steps[n]);
    sum.restart();
  }
  for (std::size_t n = middle; n < steps.size(); ++n) add(sum, steps[n]);
}

const char* needs_restart(const Schedule& schedule, Draw draw) {
  const std::vector<MappedStep> steps = mapped_steps(place(PhaseLockedMap({}, {}), schedule));
  const SamplingGrid grids[]{{{1000, 1}, {}}, {{draw.between(50, 4000), 1}, RealTime{draw.between(0, 999'999)}}};
  for (const Emission emission : {Emission::hold, Emission::linear}) {
    for (const auto phase : {RunningNeeds::Phase::any, RunningNeeds::Phase::this_one}) {
      RunningNeeds restarted(grids, emission, phase), fresh(grids, emission, phase);
      const auto add = [](RunningNeeds& needs, const MappedStep& step) { needs.add({&step, 1}); };
      second_part(restarted, steps, draw, true, add);
      second_part(fresh, steps, draw, false, add);
      if (!same(restarted.budget(), fresh.budget())) return "needs remember steps from before restart()";
    }
  }
  return nullptr;
}

const char* lines_and_paths_restart(const Schedule& schedule, Draw draw) {
  const std::vector<MappedStep> steps = mapped_steps(place(PhaseLockedMap({}, {}), schedule));
  const auto add = [](auto& sum, const MappedStep& step) { sum.add(step.step, step.begin, step.end); };
  RunningPath path, fresh_path;
  second_part(path, steps, draw, true, add);
  second_part(fresh_path, steps, draw, false, add);
  if (path.least().latency != fresh_path.least().latency ||
      path.least().latency_culprit != fresh_path.least().latency_culprit)
    return "a path remembers steps from before restart()";
  RunningLine line, fresh_line;
  second_part(line, steps, draw, true, add);
  second_part(fresh_line, steps, draw, false, add);
  const BestLine a = line.best(), b = fresh_line.best();
  if (a.latency != b.latency || a.latency_culprit != b.latency_culprit || a.lead_culprit != b.lead_culprit)
    return "a line remembers steps from before restart()";
  return nullptr;
}

/// Stamps in any order, numbers that begin anew in between.
const char* resampler_forgets(Draw draw) {
  ResamplerSpec spec;
  constexpr Resampling kKinds[]{Resampling::scheduled, Resampling::scheduled_held, Resampling::newest,
                                Resampling::polyphase};
  spec.kind = kKinds[draw.between(0, 3)];
  spec.taps = static_cast<int>(draw.between(1, 4));
  spec.capacity = static_cast<std::size_t>(draw.between(2 * spec.taps + 1, 20));
  Resampler<double> old(spec), fresh(spec);
  std::int64_t newest_ns = 0;
  for (std::int64_t i = draw.between(1, 60); i > 0; --i) {
    newest_ns += draw.between(1, 20'000'000);
    old.arrive(RealTime{newest_ns - draw.between(0, 40'000'000)}, draw.unit(), draw.between(0, 1'000));
  }
  const std::int64_t first_ns = newest_ns + draw.between(1, 500'000'000);
  std::int64_t last_ns = first_ns;
  const auto count = static_cast<std::int64_t>(spec.capacity) + draw.between(0, 10);
  for (std::int64_t i = 0; i < count; ++i, last_ns += draw.between(1, 20'000'000)) {
    const double value = draw.unit();
    old.arrive(RealTime{last_ns}, value, i);
    fresh.arrive(RealTime{last_ns}, value, i);
  }
  for (int i = 0; i < 10; ++i) {
    const RealTime at{draw.between(first_ns - 100'000'000, last_ns + 100'000'000)};
    const Reading<double> a = old.at(at), b = fresh.at(at);
    if (a.value != b.value || a.status != b.status || a.newest != b.newest) return "samples that no longer fit are played";
  }
  return nullptr;
}

/// Once an input has been constant for settling_time(), a filter is one that begins with that constant, to 1e-8 of what came
/// before: settling_time() leaves a billionth, and a state may hold several times the input.
const char* filters_settle(Draw draw) {
  const Rate rate{1000, 1};
  const double cutoff_Hz = 1 + 400 * draw.unit();
  const FilterSpec kinds[]{MovingAverageSpec{static_cast<int>(draw.between(1, 50))}, ButterworthSpec{cutoff_Hz},
                           OneEuroSpec{cutoff_Hz, 5 * draw.unit(), 1 + 10 * draw.unit()}};
  for (const FilterSpec& spec : kinds) {
    auto old = make_filter<double>(spec, rate), fresh = make_filter<double>(spec, rate);
    for (std::int64_t i = draw.between(1, 100); i > 0; --i) old.next(2 * draw.unit() - 1);
    const double constant = 2 * draw.unit() - 1;
    const std::int64_t samples = settling_time(spec, rate).ns / 1'000'000 + 1;
    for (std::int64_t i = 0; i < samples; ++i) old.next(constant);
    fresh.next(constant);
    for (int i = 0; i < 50; ++i) {
      const double x = 2 * draw.unit() - 1;
      if (!(std::abs(old.next(x) - fresh.next(x)) <= 1e-8)) return "a filter remembers longer than settling_time()";
    }
  }
  return nullptr;
}

}  // namespace

TEST_CASE("needs that were restarted are those of the later steps alone: 20,000 schedules") {
  for_all(20'000, needs_restart);
}
TEST_CASE("lines and paths that were restarted are those of the later steps alone: 20,000 schedules") {
  for_all(20'000, lines_and_paths_restart);
}
TEST_CASE("a resampler is full of new samples: what it plays is as if there had been no others, 20,000 sources") {
  for_all_draws(20'000, resampler_forgets);
}
TEST_CASE("after settling_time() of a constant a filter is as one that begins with it, in 2,000 histories") {
  for_all_draws(2'000, filters_settle);
}
