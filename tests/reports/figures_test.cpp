#include "evenstep/reports/figures.h"

#include <cmath>

#include "catch.h"
#include "samples.h"
#include "writers/figures/svg.h"

using namespace evenstep;
using Catch::Contains;

namespace {

Metrics with_growths(const RunRecord& run) {
  Metrics metrics = measure(run);
  add_growths(run, metrics);
  return metrics;
}

}  // namespace

TEST_CASE("ticks are round, inside the range, and two to twice as many as wanted: 15 decades") {
  for (int decade = -9; decade <= 5; ++decade) {
    for (int i = 1; i < 100; ++i) {
      const double span = std::pow(10, decade) * (1 + 0.09 * i);
      const internal::Range range{-0.3 * span, 0.7 * span};
      for (const int wanted : {3, 5, 9}) {
        const std::vector<double> ticks = internal::round_ticks(range, wanted);
        REQUIRE(ticks.size() >= 2);
        REQUIRE(ticks.size() <= 2 * static_cast<std::size_t>(wanted) + 1);
        const double step = ticks[1] - ticks[0];
        const double digit = step / std::pow(10, std::floor(std::log10(step * 1.0001)));
        REQUIRE((std::abs(digit - 1) < 1e-6 || std::abs(digit - 2) < 1e-6 || std::abs(digit - 5) < 1e-6));
        for (const double tick : ticks) REQUIRE((tick >= range.low - step * 1e-6 && tick <= range.high + step * 1e-6));
      }
    }
  }
}

TEST_CASE("axes carry the SI prefix that keeps their numbers readable") {
  CHECK(internal::Axis{{0, 0.12}, "position", "m"}.label() == "position [mm]");
  CHECK(internal::Axis{{-2, 1}, "force", "N"}.label() == "force [N]");
  CHECK(internal::Axis{{0, 3e-6}, "hand", "m"}.label() == "hand [µm]");
  CHECK(internal::Axis{{0, 3e-3}, "off", "step"}.label() == "off [step]");
}

TEST_CASE("a range of one value, of none and of NaN still has a span") {
  for (const auto& values : {std::vector<double>{}, {NAN}, {0}, {5}, {-5, -5, NAN}, {1, 1 + 1e-15}}) {
    const internal::Range range = internal::Range::around(values);
    CHECK(range.high > range.low);
    CHECK(internal::round_ticks(range, 5).size() >= 2);
  }
}

TEST_CASE("an axis of decades names whole powers of ten only, however few or many there are") {
  for (const double low : {-1.05, -2.1, -9.4}) {
    internal::Svg svg(900, 600, "t");
    internal::Panel panel(svg, {100, 0, 800, 140}, {{0, 1}, "", "s"}, {{low, 0}, "error", "m", true});
    panel.draw_axes(false, false);
    const std::string text = std::move(svg).finish();
    CAPTURE(low);
    CHECK_THAT(text, Contains("error [m]") && Contains(">10⁰<"));
    CHECK(synthetic::occurrences(text, ">10⁻¹<") == (low > -4 ? 1 : 0));
    CHECK(synthetic::occurrences(text, ">10⁻²<") == (low < -2 ? 1 : 0));
    const std::size_t names = synthetic::occurrences(text, ">10");
    CHECK(names == (low > -2 ? 2 : low > -4 ? 3 : 5));
  }
}

TEST_CASE("a long curve is decimated to the pixels, and no peak is lost") {
  internal::Svg svg(900, 600, "t");
  internal::Panel panel(svg, {0, 0, 800, 100}, {{0, 100'000}, "", ""}, {{0, 1}, "", ""});
  std::vector<double> x, y;
  for (int i = 0; i < 100'000; ++i) {
    x.push_back(i);
    y.push_back(i == 54'321 ? 1.0 : i == 12'345 ? 0.0 : 0.25);
  }
  panel.curve(x, y, {});
  const std::string text = std::move(svg).finish();
  CHECK(synthetic::occurrences(text, ",") <= 4 * 800 + 10);
  CHECK_THAT(text, Contains(",0.00 ") && Contains(",100.00 "));  // the peak at the top, the trough at the bottom
}

TEST_CASE("a NaN breaks a curve and leaves no number in the file that is none") {
  internal::Svg svg(900, 600, "t");
  internal::Panel panel(svg, {0, 0, 800, 100}, {{0, 10}, "", ""}, {{0, 1}, "", ""});
  panel.curve({0, 1, 2, 3, 4, 5}, {0, 1, NAN, 0, 1, 0}, {});
  const std::string text = std::move(svg).finish();
  CHECK(synthetic::occurrences(text, "<polyline") == 2);
  CHECK_THAT(text, !Contains("nan"));
}

TEST_CASE("figure 1 shows every strategy in both panels and names the units") {
  const RunRecord run = synthetic::reference_run();
  for (const std::string& svg : {figure_1a_svg(run, "left"), figure_1b_svg(run, "left")}) {
    CHECK(synthetic::occurrences(svg, "<polyline") == 8);
    for (const char* name : {"ideal", "direct", "paper", "phase_locked", "off the fitted line [step]"})
      CHECK_THAT(svg, Contains(name));
  }
  CHECK_THAT(figure_1a_svg(run, "left"), Contains("simulation time [s]") && Contains("position [mm]"));
  CHECK_THAT(figure_1b_svg(run, "left"), Contains("real time [s]") && Contains("force [N]"));
}

TEST_CASE("without a nominal speed the lower panel is in SI units") {
  RunRecord run = synthetic::reference_run();
  run.nominal.devices[0].speed_m_per_s.reset();
  CHECK_THAT(figure_1a_svg(run, "left"), Contains("off the fitted line [mm]"));
}

TEST_CASE("figures 2 to 4 join each of the 15 steps to its slot and to its emission") {
  const RunRecord run = synthetic::reference_run();
  const std::string paper = figure_2to4_svg(run, "paper", "left"), direct = figure_2to4_svg(run, "direct", "left");
  CHECK(synthetic::occurrences(paper, "stroke=\"#555555\"") == 2 * 15);
  CHECK(synthetic::occurrences(direct, "stroke=\"#555555\"") == 2 * 15);
  CHECK(synthetic::occurrences(paper, "fill=\"#bfe5d9\"") == 15);  // slots
  CHECK(synthetic::occurrences(direct, "fill=\"#bfe5d9\"") == 0);  // direct has none, and says so
  CHECK_THAT(direct, Contains("none: newest sample"));
  CHECK_THAT(paper,
             Contains("visualization") && Contains("real time [s]") && Contains("hand [mm]") && Contains("force [N]"));
}

TEST_CASE("nothing judged, an unknown device or strategy: a figure that says so") {
  RunRecord run = synthetic::reference_run();
  CHECK_THAT(figure_1a_svg(run, "nobody"), Contains("nothing was judged"));
  CHECK_THAT(figure_2to4_svg(run, "nobody", "left"), Contains("nothing was judged"));
  CHECK_THAT(figure_2to4_svg(RunRecord{}, "paper", "left"), Contains("nothing was judged"));
  for (StrategyRecord& strategy : run.strategies) {
    for (StepRow& step : strategy.steps) step.acquiring = true;
  }
  CHECK_THAT(figure_2to4_svg(run, "paper", "left"), Contains("nothing was judged"));
}

TEST_CASE("all text is 11 px or larger and inside the picture") {
  const std::string svg = figure_2to4_svg(synthetic::nasty_run(), "paper", "left");
  std::size_t texts = 0;
  for (std::size_t at = svg.find("font-size=\""); at != std::string::npos; at = svg.find("font-size=\"", at + 1), ++texts) {
    CHECK(std::stod(svg.substr(at + 11)) >= 11);
  }
  for (std::size_t at = svg.find("<text x=\""); at != std::string::npos; at = svg.find("<text x=\"", at + 1)) {
    CHECK(std::stod(svg.substr(at + 9)) <= 900);
    const double y = std::stod(svg.substr(svg.find("y=\"", at) + 3));
    CHECK((y >= 11 && y <= 600));
  }
  CHECK(texts > 30);
}

namespace {

std::vector<double> numbers_after(const std::string& text, const std::string& key) {
  std::vector<double> numbers;
  for (std::size_t at = text.find(key); at != std::string::npos; at = text.find(key, at + 1))
    numbers.push_back(std::stod(text.substr(at + key.size())));
  return numbers;
}

/// y of every point of every curve.
std::vector<double> heights(const std::string& svg) {
  std::vector<double> ys;
  for (std::size_t at = svg.find("points=\""); at != std::string::npos; at = svg.find("points=\"", at + 1)) {
    const std::size_t end = svg.find('"', at + 8);
    for (std::size_t comma = svg.find(',', at); comma < end; comma = svg.find(',', comma + 1))
      ys.push_back(std::stod(svg.substr(comma + 1)));
  }
  return ys;
}

}  // namespace

TEST_CASE("error over time: panels of interaction and of force with every strategy, whatever the run's length") {
  CHECK_FALSE(error_over_time_svg(RunRecord{}, {}));
  for (const std::int64_t duration_ns : {600'000'000LL, 1'000'000'000LL, 9'500'000'000LL}) {  // judged from 0.27 s on
    const RunRecord run = synthetic::reference_run({duration_ns});
    const std::string svg = error_over_time_svg(run, with_growths(run)).value();
    CHECK(synthetic::occurrences(svg, "<polyline") == 6 * 4);
    for (const char* text :
         {"left.interaction", "left.force", "ideal", "direct", "paper", "phase_locked", "deviation max [step]",
          "velocity jump [step]", "underruns so far [count]", "run time [s]", ">10⁰<", ">direct: deviation "})
      CHECK_THAT(svg, Contains(text));
    CHECK_THAT(svg, !Contains(">10⁻⁸<"));  // 1e-10 m are 4.5e-7 step
    for (const double size : numbers_after(svg, "font-size=\"")) CHECK(size >= 11);
    for (const double x : numbers_after(svg, "<text x=\"")) CHECK((x > 0 && x < 1100));
  }
}

TEST_CASE("error over time: another error that is known has a panel and its growth beside the deviation") {
  RunRecord run = synthetic::reference_run({4'000'000'000});
  for (StrategyRecord& strategy : run.strategies) {
    const double end_s = seconds(run.nominal.end);
    for (std::size_t n = 0; n < strategy.steps.size(); ++n) {
      StepSample& sample = strategy.devices[0].steps[n];
      sample.true_position_m = sample.position_m;
      sample.true_position_m->at(2) += 1e-3 * seconds(strategy.steps[n].begin) / end_s;  // grows
      strategy.twin_force_N.push_back(sample.force_N);
      strategy.twin_force_N.back()[0] += n % 2 ? 0.1 : -0.1;  // does not grow
    }
  }
  const Metrics metrics = with_growths(run);
  CHECK(std::string(growth_name(growths_of(metrics, "left.interaction.paper").at(1).second)) == "linear");
  CHECK(metrics.at("left.interaction.paper").at("error_growth") == 1);
  CHECK(metrics.at("left.force.paper").at("deviation_from_ideal_growth") == 0);
  const std::string svg = error_over_time_svg(run, metrics).value();
  CHECK(synthetic::occurrences(svg, "<polyline") == 8 * 4);
  for (const char* text : {"error RMS [step]", "from ideal RMS [step]", ", error linear (1)<", ", from ideal bounded (0)<"})
    CHECK_THAT(svg, Contains(text));
}

TEST_CASE("growth: an error of the size of rounding is bounded, however it grows") {
  RunRecord run = synthetic::reference_run({4'000'000'000});
  for (StrategyRecord& strategy : run.strategies) {
    const double end_s = seconds(run.nominal.end);
    for (std::size_t n = 0; n < strategy.steps.size(); ++n) {
      StepSample& sample = strategy.devices[0].steps[n];
      sample.true_position_m = sample.position_m;
      strategy.twin_force_N.push_back(sample.force_N);
      // Grows to 16 units in the last place of the largest force.
      strategy.twin_force_N.back()[1] += 16 * 0x1p-52 * 20 * seconds(strategy.steps[n].begin) / end_s;
    }
  }
  const Metrics metrics = with_growths(run);
  CHECK(metrics.at("left.force.paper").at("deviation_from_ideal_growth") == 0);
}

TEST_CASE("error over time: one block per device, SI units where there is no step") {
  RunRecord run = synthetic::reference_run({11'000'000'000});
  run.nominal.devices.push_back(run.nominal.devices[0]);
  run.nominal.devices[1].name = "right";
  run.nominal.devices[1].speed_m_per_s.reset();
  for (StrategyRecord& strategy : run.strategies) {
    strategy.devices.push_back(strategy.devices[0]);
    strategy.devices[1].name = "right";
  }
  const std::string svg = error_over_time_svg(run, {}).value();
  CHECK(synthetic::occurrences(svg, "<polyline") == 2 * 6 * 4);
  CHECK(synthetic::occurrences(svg, "deviation max [step]") == 2);
  CHECK_THAT(svg, Contains("right.force") && Contains("deviation max [m]") && Contains("velocity jump [N]"));
  const std::vector<double> ys = heights(svg);
  constexpr double kHead = 74, kBlock = 60 + 4 * 14 + 3 * 160;
  for (const double y : ys) CHECK((y > kHead && y < kHead + 2 * kBlock));
  const auto above = std::count_if(ys.begin(), ys.end(), [](double y) { return y < kHead + kBlock; });
  CHECK(2 * above == static_cast<std::ptrdiff_t>(ys.size()));
}

TEST_CASE("error over time: zeros lie on the lowest decade, NaN and bins without samples break a curve") {
  RunRecord run = synthetic::reference_run({12'000'000'000});
  run.strategies.resize(1);
  StrategyRecord& only = run.strategies[0];
  for (StepSample& sample : only.devices[0].steps) sample.position_m = {1, 2, 3};  // a hand at rest: no error at all
  const std::string still = error_over_time_svg(run, {}).value();
  CHECK(synthetic::occurrences(still, "<polyline") == 6);
  CHECK_THAT(still, !Contains("nan") && !Contains("inf"));
  for (std::size_t n = 0; n < only.steps.size(); ++n) {
    const double at = seconds(only.steps[n].begin - RealTime{});
    only.steps[n].acquiring = at > 4 && at < 6.5;  // one bin whole
    if (at > 9 && at < 9.1) only.devices[0].steps[n].position_m[0] = NAN;
  }
  const std::string broken = error_over_time_svg(run, {}).value();
  // The curves of deviation and jump fall into three pieces, that of the count does not.
  CHECK(synthetic::occurrences(broken, "<polyline") == 2 * 3 + 1 + 3);
  CHECK_THAT(broken, !Contains("nan") && !Contains("inf"));
}

namespace {

/// A text of the legend: what is 40 px to the right of a line of 34 px.
struct LegendEntry {
  std::string name;
  double line_from = 0, x = 0, y = 0;
  /// In a sans-serif font of 12 px, the letters of these names are at most 7.6 px wide on average.
  double end() const { return x + 7.6 * static_cast<double>(name.size()); }
};
std::vector<LegendEntry> legend_of(const std::string& svg, const std::vector<std::string>& names) {
  std::vector<LegendEntry> entries;
  for (const std::string& name : names) {
    REQUIRE(synthetic::occurrences(svg, '>' + name + "</text>") == 1);
    const std::size_t end = svg.find('>' + name + "</text>"), begin = svg.rfind("<text", end),
                      line = svg.rfind("<line", begin);
    const std::string text = svg.substr(begin, end - begin);
    entries.push_back({name, numbers_after(svg.substr(line, begin - line), "x1=\"").at(0), numbers_after(text, "x=\"").at(0),
                       numbers_after(text, "y=\"").at(0)});
  }
  return entries;
}

}  // namespace

TEST_CASE("legend: every entry is inside the picture, above the panels and over no other, with 1 to 19 strategies") {
  const std::vector<std::string> all{"ideal",        "direct",        "paper",        "phase_locked", "predict",
                                     "filtered",     "variable_step", "foreign",      "jack_dll",     "lsl_dejitter",
                                     "linear",       "absolute_grid", "holt_winters", "polyphase",    "chunk_replace",
                                     "chunk_append", "chunk_blend",   "clocked",      "interpolated"};
  const RunRecord reference = synthetic::reference_run({1'200'000'000});
  for (std::size_t count = 1; count <= all.size(); ++count) {
    RunRecord run = reference;
    run.strategies.assign(count, reference.strategies[1]);
    for (std::size_t i = 0; i < count; ++i) run.strategies[i].name = all[i];
    const std::vector<std::string> names(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count));
    std::vector<std::string> figures{figure_1a_svg(run, "left"), figure_1b_svg(run, "left")};
    figures.push_back(error_over_time_svg(run, {}).value_or(""));
    for (const std::string& svg : figures) {
      if (svg.empty()) continue;
      const double width = numbers_after(svg, " width=\"").at(0), height = numbers_after(svg, " height=\"").at(0);
      const std::vector<LegendEntry> entries = legend_of(svg, names);
      const std::vector<double> curves = heights(svg);
      const double highest_curve = *std::min_element(curves.begin(), curves.end());
      for (std::size_t i = 0; i < count; ++i) {
        INFO(count << " strategies: " << entries[i].name);
        CHECK(entries[i].x - entries[i].line_from == Approx(40));
        CHECK(entries[i].end() <= width - 10);
        CHECK(entries[i].y < highest_curve);
        for (std::size_t j = 0; j < i; ++j)
          CHECK((entries[j].y + 12 <= entries[i].y || entries[j].end() < entries[i].line_from));
      }
      CHECK(*std::max_element(curves.begin(), curves.end()) < height - 40);  // numbers and label of the axis are below
      for (const double y : numbers_after(svg, "\" y=\"")) CHECK(y < height);
    }
    // The panels are as high as when the legend has one line.
    const std::vector<double> of_one = heights(figure_1b_svg(reference, "left")), of_all = heights(figures[1]);
    const auto extent = [](const std::vector<double>& ys) {
      return *std::max_element(ys.begin(), ys.end()) - *std::min_element(ys.begin(), ys.end());
    };
    CHECK(extent(of_all) > 0.8 * extent(of_one));
  }
}
