// The least latency at a velocity jump, against a linear program that shares nothing with it.
#include "evenstep/remap/jump_bound.h"

#include "../schedules.h"
#include "catch.h"
#include "evenstep/remap/buffer_oracle.h"

using namespace evenstep;
using namespace evenstep::testing;

namespace {

/// Minimizes c x for A x <= b, x >= 0, with c >= 0, by the dual simplex method. It starts from the basis of all slacks, in a
/// dense tableau whose last row is c and whose last column is b. Infinity if nothing is feasible.
class LinearProgram {
 public:
  explicit LinearProgram(std::size_t variables) : variables_(variables) { rows_.emplace_back(variables + 1, 0.0L); }
  std::vector<long double>& cost() { return rows_.back(); }
  void at_most(const std::vector<std::pair<std::size_t, long double>>& row, long double bound) {
    std::vector<long double> dense(variables_ + 1, 0.0L);
    for (const auto& [variable, factor] : row) dense[variable] += factor;
    dense.back() = bound;
    rows_.insert(rows_.end() - 1, dense);
  }
  long double minimum() {
    for (;;) {
      std::size_t leaves = 0;
      for (std::size_t r = 1; r + 1 < rows_.size(); ++r)
        if (rows_[r].back() < rows_[leaves].back()) leaves = r;
      if (rows_[leaves].back() > -1e-9L) return -rows_.back().back();
      std::size_t enters = variables_;
      for (std::size_t c = 0; c < variables_; ++c) {
        if (rows_[leaves][c] > -1e-12L) continue;
        if (enters == variables_ || ratio(leaves, c) < ratio(leaves, enters)) enters = c;
      }
      if (enters == variables_) return INFINITY;
      pivot(leaves, enters);
    }
  }

 private:
  long double ratio(std::size_t row, std::size_t column) const { return rows_.back()[column] / -rows_[row][column]; }
  void pivot(std::size_t row, std::size_t column) {
    const long double by = rows_[row][column];
    for (long double& one : rows_[row]) one /= by;
    rows_[row][column] = 1 / by;
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      if (r == row) continue;
      const long double factor = rows_[r][column];
      for (std::size_t c = 0; c <= variables_; ++c)
        if (c != column) rows_[r][c] -= factor * rows_[row][c];
      rows_[r][column] = -factor / by;
    }
  }
  std::size_t variables_;
  std::vector<std::vector<long double>> rows_;
};

/// The variables are x_n >= 0, with R(n) = S_n - x_n, and L as the last one.
long double by_linear_program(const std::vector<StepTimes>& steps, Duration jump) {
  LinearProgram program(steps.size() + 1);
  program.cost()[steps.size()] = 1;
  const auto begin = [&](std::size_t n) { return static_cast<long double>(steps[n].begin.ns); };
  for (std::size_t n = 0; n < steps.size(); ++n) {
    program.at_most({{n, 1}, {steps.size(), -1}}, -static_cast<long double>((steps[n].end - steps[n].begin).ns));
    if (n > 0) program.at_most({{n, 1}, {n - 1, -1}}, begin(n) - begin(n - 1));
    if (n < 2) continue;
    const long double bend = begin(n) - 2 * begin(n - 1) + begin(n - 2);
    program.at_most({{n, -1}, {n - 1, 2}, {n - 2, -1}}, static_cast<long double>(jump.ns) - bend);
    program.at_most({{n, 1}, {n - 1, -2}, {n - 2, 1}}, static_cast<long double>(jump.ns) + bend);
  }
  return program.minimum();
}

std::vector<StepTimes> random_steps(Draw& draw, std::int64_t most) {
  std::vector<StepTimes> steps(static_cast<std::size_t>(draw.between(1, most)));
  RealTime now{draw.between(-1'000'000'000, 1'000'000'000)};
  const bool pauses = draw.between(0, 1) == 0;
  for (StepTimes& step : steps) {
    if (pauses && draw.between(0, 3) == 0) now = now + Duration{draw.between(0, 10'000'000)};
    step.begin = now;
    now = now + Duration{draw.between(0, 3'000'000)};
    step.end = now;
  }
  return steps;
}

}  // namespace

TEST_CASE("the least latency at a velocity jump is that of a linear program to 1 ns, 1000 random traces") {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    Draw draw(seed);
    const std::vector<StepTimes> steps = random_steps(draw, 14);
    const Duration jump{draw.between(0, 1) == 0 ? draw.between(0, 50'000) : draw.between(0, 5'000'000)};
    const long double exact = by_linear_program(steps, jump);
    const auto found = static_cast<long double>(least_latency_with_jump(steps, jump).ns);
    INFO("seed " << seed << ", " << steps.size() << " steps, jump " << jump.ns);
    REQUIRE(found >= exact - 1e-3L);
    REQUIRE(found <= exact + 1.001L);
  }
}

TEST_CASE("the curve of latency against jump falls from the best line to the least path, 300 random traces", "[sweep]") {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Draw draw(seed + 5000);
    const std::vector<StepTimes> steps = random_steps(draw, 200);
    Duration last = least_latency_with_jump(steps, {});
    REQUIRE(std::abs((last - best_line(steps).latency).ns) <= 1);
    for (const std::int64_t jump_ns : {1'000, 20'000, 100'000, 400'000, 2'000'000, 50'000'000}) {
      const Duration latency = least_latency_with_jump(steps, Duration{jump_ns});
      REQUIRE(latency <= last);
      last = latency;
    }
    REQUIRE(last == least_path(steps).latency);
  }
}

TEST_CASE("long traces lose no more than 1 ns to rounding: a trace beside itself a day later") {
  Draw draw(3);
  std::vector<StepTimes> steps = flat(jittered(draw, 0.1, 40));
  const Duration jump{44'444};
  const Duration near = least_latency_with_jump(steps, jump);
  for (StepTimes& step : steps) {
    step.begin.ns += 86'400'000'000'000;
    step.end.ns += 86'400'000'000'000;
  }
  CHECK(least_latency_with_jump(steps, jump) == near);
}

TEST_CASE("the pause bound of the reference case is its closed form, and no step means no bound") {
  const std::vector<StepTimes> steps = flat(Periodic{}.schedule(60));
  CHECK(std::abs(pause_bound(steps, Duration{2'222'222}).ns - 11'842'223) <= 1);  // V + 2 s - tau
  CHECK(pause_bound({}, {}).ns == 0);
  CHECK(pauses_bound({}, {}, {}).ns == 0);
  CHECK(least_latency_with_jump({}, {}).ns == 0);
}

TEST_CASE("the pauses bound is reached and never passed by what can still brake if even steps follow, 1,000 schedules") {
  constexpr std::int64_t kSlot = 2'000'000;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(1000); ++seed) {
    Draw draw(seed + 9000);
    const std::int64_t count = draw.between(1, 25), jump = draw.between(1, 400'000);
    std::vector<StepTimes> steps{{RealTime{}, RealTime{kSlot}}};  // begins at 0; a pause before each of the others
    for (std::int64_t k = 1; k <= count; ++k) {
      const RealTime begin = steps.back().end + Duration{draw.between(0, 1) * draw.between(0, 20'000'000)};
      steps.push_back({begin, begin + Duration{kSlot}});
    }
    // What slots need from the first step on that are u faster than a slot then, are never ahead of even steps that might
    // follow, and now hurry.
    const auto needed = [&](const std::vector<StepTimes>& of, std::int64_t u) {
      std::int64_t ahead = 0, most_ahead = 0;
      for (std::int64_t velocity = u - jump; velocity > 0; velocity -= jump)
        most_ahead = std::max(most_ahead, ahead += velocity);
      std::int64_t read = -most_ahead, velocity = kSlot + u, most = 0;
      for (const StepTimes& step : of) {
        most = std::max(most, step.end.ns - read);
        read += velocity += jump;
      }
      return most;
    };
    std::int64_t first = 0;  // the bound's part from the first step
    for (std::int64_t k = 0; k <= count; ++k)
      first = std::max(first, steps[static_cast<std::size_t>(k)].end.ns - k * kSlot - jump * k * (k + 1));
    INFO("seed " << seed);
    for (std::int64_t k = 0; k <= count; ++k) REQUIRE(needed(steps, k * jump) >= first);
    REQUIRE(needed(steps, draw.between(0, count * jump)) >= first);
    std::int64_t all = 0;
    for (std::size_t n = 0; n < steps.size(); ++n)
      for (std::size_t m = n; m < steps.size(); ++m) {
        const auto k = static_cast<std::int64_t>(m - n);
        all = std::max(all, (steps[m].end - steps[n].begin).ns - k * kSlot - jump * k * (k + 1));
      }
    REQUIRE(pauses_bound(steps, Duration{kSlot}, Duration{jump}).ns == all);
    // If one pair of steps sets it, the velocity that the derivation names reaches it.
    const std::vector<StepTimes> pair{steps.front(), {RealTime{50'000'000}, RealTime{52'000'000}}};
    REQUIRE(pauses_bound(pair, Duration{kSlot}, Duration{jump}).ns == needed(pair, jump));
  }
}
