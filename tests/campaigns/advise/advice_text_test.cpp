// The table, the words, the JSON and the figure of an advice, for choices that are written here.
#include <sstream>

#include "catch.h"
#include "evenstep/reports/advice_record.h"
#include "evenstep/reports/json.h"

using namespace evenstep;
using Catch::Contains;

namespace {

AdviceChoice choice(int number, const char* map, const char* renderer, double delay_s, double jump, double stiffness) {
  AdviceChoice out;
  out.number = number;
  out.map = map;
  out.renderer = renderer;
  out.needs_stiffness = std::string(renderer) == "local";
  out.delay_s = delay_s;
  out.jump_step = jump;
  out.force_jump_step = 1;
  out.stiffness_N_per_m = stiffness;
  out.tried_N_per_m = 0.8 * stiffness;
  out.comes_to_rest = true;
  if (out.map != "direct") out.latency = Duration{static_cast<std::int64_t>(delay_s * 1e9) - 1'000'000};
  return out;
}

AdviceRecord record() {
  AdviceRecord out;
  out.input = "timing.csv";
  out.steps = 1800;
  out.segments = 120;
  out.choices = {choice(1, "direct", "hold", 0.005, 5.4, 190), choice(2, "paper", "hold", 0.042, 1.9, 23.8),
                 choice(3, "phase_locked", "hold", 0.042, 0.02, 23.8), choice(4, "phase_locked", "local", 0.042, 0.02, 2000),
                 choice(5, "phase_locked", "linear", 0.042004, 0.02, 23.8)};
  rank(out);
  return out;
}

}  // namespace

TEST_CASE("a choice that needs more does not beat one that needs less") {
  const AdviceRecord advice = record();
  CHECK(advice.choices[0].on_front);
  CHECK_FALSE(advice.choices[1].on_front);
  CHECK(advice.choices[1].dominated_by == std::vector<int>{3, 5});
  CHECK(advice.choices[2].on_front);  // choice 4 is stiffer, but needs the solver's stiffness
  CHECK(advice.choices[3].on_front);
}

TEST_CASE("numbers that are equal to three digits tie") {
  const AdviceRecord advice = record();
  CHECK(advice.choices[2].ties == std::vector<int>{5});
  CHECK(advice.choices[4].ties == std::vector<int>{3});
  CHECK(advice.choices[4].on_front);
}

TEST_CASE("a choice whose hand shakes is not ranked, beats nothing and is never advised") {
  AdviceRecord advice = record();
  advice.choices[2].comes_to_rest = advice.choices[4].comes_to_rest = false;
  rank(advice);
  CHECK_FALSE(advice.choices[2].ranked);
  CHECK_FALSE(advice.choices[2].on_front);
  CHECK(advice.choices[1].on_front);
  CHECK_THAT(advice_text(advice), Contains("its hand shakes with 19 N/m"));
  CHECK(choice_to_use(advice, false)->number == 2);
}

TEST_CASE("how such a size does on what it has not seen is said of the choice for a solver of forces, and in the JSON") {
  AdviceRecord advice = record();
  CHECK_THAT(advice_text(advice), !Contains("Sized on its first parts"));
  advice.choices[2].unseen = SizeUnseen{.played = 200, .late = 11, .late_by = {5'400'000}, .missing_by = {1'000'000}};
  CHECK_THAT(advice_text(advice, 1000),
             Contains("Sized on its first parts, it is late in 5.5 % of the segments of the parts after "
                      "them, by up to 5.4 ms."));
  const Json unseen = Json::parse(advice_json(advice)).at("choices").at(2).at("unseen");
  CHECK(unseen.at("late_segments") == 11);
  CHECK(unseen.at("played_segments") == 200);
  CHECK(unseen.at("late_by_ns") == 5'400'000);
  advice.choices[2].unseen->late = 0;
  CHECK_THAT(advice_text(advice, 1000), Contains("Sized on its first parts, it is never late in the parts after them."));
}

TEST_CASE("a jump that is only rounding is none") {
  AdviceRecord advice = record();
  CHECK_THAT(advice_text(advice, 1000), Contains("Without a map (1, direct, hold) the hand jumps by 5.4 steps"));
  advice.choices[0].jump_step = 4e-13;
  CHECK_THAT(advice_text(advice, 1000), Contains("Without a map (1, direct, hold) the hand does not jump"));
}

TEST_CASE("the choice to use is smooth, late in nothing, loses nothing and needs what there is") {
  AdviceRecord advice = record();
  CHECK(choice_to_use(advice, true)->number == 4);
  CHECK(choice_to_use(advice, false)->number == 3);
  advice.choices[3].late_any_phase = 0.01;
  advice.choices[2].drawings_lost = advice.choices[4].simulated_lost = 0.1;
  rank(advice);
  CHECK(choice_to_use(advice, true) == nullptr);
  CHECK(choice_to_use(advice, false)->number == 2);  // rough, but nothing else is left
}

TEST_CASE("without any choice the conclusion says that there is none") {
  AdviceRecord advice = record();
  for (AdviceChoice& one : advice.choices) one.comes_to_rest = false;
  rank(advice);
  CHECK_THAT(advice_conclusion(advice).front(), Contains("Nothing can be advised"));
  CHECK(advice_svg(advice).empty());
}

TEST_CASE("a choice whose run failed is a row that says so") {
  AdviceRecord advice = record();
  advice.choices[1].failure = "it diverged";
  rank(advice);
  CHECK_FALSE(advice.choices[1].ranked);
  CHECK_THAT(advice_text(advice), Contains("it diverged"));
  CHECK(Json::parse(advice_json(advice))["choices"][1]["failure"] == "it diverged");
}

TEST_CASE("the table has a row for each choice, in the same columns") {
  const std::string table = advice_text(record());
  CHECK_THAT(table, Contains("*   1  direct, hold                 -         -      5.00      5.4        1        0       0  "
                             "     0     190  \n"));
  CHECK_THAT(table, Contains("    2  paper, hold             41.000         -     42.00      1.9        1        0       0  "
                             "     0    23.8  beaten by 3, 5\n"));
  CHECK_THAT(table, Contains("*   3  phase_locked, hold      41.000         -     42.00     0.02        1        0       0  "
                             "     0    23.8  as good as 5\n"));
}

TEST_CASE("the words of an advice keep to the columns of the terminal, and the table does not change") {
  AdviceRecord advice = record();
  advice.notes = {"This note is one of those that are longer than the narrowest of terminals, on purpose."};
  const std::string narrow = advice_text(advice, 60), wide = advice_text(advice, 1000);
  std::istringstream lines(narrow);
  std::size_t broken = 0, rows = 0;
  for (std::string line; std::getline(lines, line);) {
    INFO(line);
    if (line.size() > 60) {
      CHECK_THAT(wide, Contains(line + "\n"));  // a line of the table
      ++rows;
    } else if (wide.find(line + "\n") == std::string::npos) {
      ++broken;
    }
  }
  CHECK(rows == 2 + advice.choices.size());
  CHECK(broken >= 8);
  CHECK_THAT(narrow, Contains("\n  If it gives forces only: 3 (phase_locked, hold): 42 ms\n  from hand to force,"));
}

TEST_CASE("a latency that adapts beats none that is fixed, and is advised as what it is") {
  AdviceRecord advice = record();
  AdviceChoice adaptive = choice(6, "phase_locked", "hold", 0.040, 0.02, 23.8);
  adaptive.adaptive = true;
  adaptive.latency_most = Duration{41'000'000};
  adaptive.underrun_rate = 0.002;
  advice.choices.push_back(adaptive);
  rank(advice);
  CHECK(advice.choices[2].on_front);
  CHECK(advice.choices[5].on_front);
  CHECK(choice_to_use(advice, false)->number == 3);
  CHECK_THAT(advice_text(advice, 1000), Contains("phase_locked, adaptive, hold") &&
                                            Contains("It is late in 0.2 % of the segments, and carries what 41 ms do"));
  const Json json = Json::parse(advice_json(advice));
  CHECK(json["choices"][5]["latency_most_ns"] == 41'000'000);
  CHECK(json["choices"][2]["latency_most_ns"].is_null());
}

TEST_CASE("a map that predicts pays with how far it runs on, and is never what to use") {
  AdviceRecord advice = record();
  AdviceChoice predicted = choice(6, "predict", "hold", 0.001, 0.001, 500);
  predicted.latency = {};
  predicted.searched = true;
  predicted.runs_on_s = 0.0123;
  advice.choices.push_back(predicted);
  rank(advice);
  CHECK(advice.choices[5].on_front);
  CHECK(advice.choices[2].on_front);  // slower and no smoother than choice 6, but does not run on
  CHECK(choice_to_use(advice, false)->number == 3);
  CHECK_THAT(advice_text(advice, 1000), Contains("At a stop it runs on by 12.3 ms of the hand's way."));
  const Json row = Json::parse(advice_json(advice))["choices"][5];
  CHECK(row["latency_ns"] == 0);
  CHECK(row["stiffness_from"] == "search");
  CHECK(row["runs_on_s"] == 0.0123);
}

TEST_CASE("the JSON has the numbers of every choice") {
  const Json json = Json::parse(advice_json(record()));
  CHECK(json["use"] == 4);
  CHECK(json["use_with_forces_only"] == 3);
  REQUIRE(json["choices"].size() == 5);
  const Json& direct = json["choices"][0];
  CHECK(direct["latency_ns"].is_null());
  CHECK(direct["delay_s"] == 0.005);
  CHECK(direct["pareto"] == true);
  CHECK(direct["needs"].empty());
  CHECK(json["choices"][3]["needs"][0] == "stiffness");
  CHECK(json["choices"][1]["beaten_by"] == Json::array({3, 5}));
  CHECK(json["choices"][1]["scenario"] == "choice-2.toml");
}

TEST_CASE("the figure has a mark for each ranked choice") {
  const std::string svg = advice_svg(record());
  std::size_t dots = 0, squares = 0;
  for (std::size_t at = 0; (at = svg.find("<circle", at)) != std::string::npos; ++at) ++dots;
  for (std::size_t at = 0; (at = svg.find("#767676", at)) != std::string::npos; ++at) ++squares;
  CHECK(dots == 2 * 4 + 1);  // the front in both panels, and the legend
  CHECK(squares >= 2 + 1);
  CHECK_THAT(svg, Contains("delay, hand to force") && Contains("stiffness carried") && Contains("3-5<"));
}
