// What to use for a wanted error, and the texts of a study, for records that are written here.
#include <algorithm>

#include "evenstep/campaigns/felt_study.h"
#include "evenstep/reports/json.h"
#include "study_scenes.h"

using namespace evenstep;
using Catch::Contains;

namespace {

using State = StudyCell::State;

StudyCell cell(const std::string& method, double substep_s, double force_error, double cpu) {
  StudyCell made{"cpu", method, 0, substep_s};
  made.error[StudyQuantity::position] = force_error * 1e-3;
  made.error[StudyQuantity::force] = force_error;
  made.error[StudyQuantity::energy] = force_error * 2;
  made.cpu = {cpu * 0.9, cpu, cpu * 1.2};
  made.wall = made.cpu;
  made.repeats = 3;
  return made;
}

StudyRecord record() {
  StudyRecord study;
  study.scenario = "a, \"b\" & <c>";
  study.reference.method = "rk4";
  for (const StudyQuantity q : kStudyQuantities) {
    study.reference.scale[q] = 2e-3;
    study.reference.estimate[q] = 1e-9;
  }
  study.cells = {cell("symplectic-euler", 1e-3, 0.02, 0.1), cell("symplectic-euler", 5e-4, 0.005, 0.5),
                 cell("rk4", 1e-3, 0.001, 2.0), cell("implicit-euler", 1e-3, 5e-10, 9.0)};
  StudyCell refused{"cpu", "rk4", 0, 2e-3};
  refused.state = State::refused;
  refused.reason = "above the limit, \"so it is\"";
  study.cells.push_back(refused);
  return study;
}

StudyAdvice advice_for(const StudyRecord& study, const std::string& goal) {
  const Result<StudyGoal> parsed = parse_goal(goal);
  INFO(parsed.error_or(""));
  REQUIRE(parsed.ok());
  return advise(study, *parsed);
}

}  // namespace

TEST_CASE("The advice is the cheapest cell that meets the error, and says whether it keeps real time") {
  const StudyRecord study = record();
  const StudyAdvice easy = advice_for(study, "2 % force");
  REQUIRE(easy.cell == &study.cells[0]);
  CHECK(easy.keeps_real_time);
  CHECK_THAT(easy.text, Contains("symplectic-euler on cpu, step 1 ms") && Contains("error 2 %") &&
                            Contains("keeps real time here, 8.33 times over"));
  CHECK(advice_for(study, "1.99 % force").cell == &study.cells[1]);
  const StudyAdvice slow = advice_for(study, "0.1 % force");
  REQUIRE(slow.cell == &study.cells[2]);
  CHECK_FALSE(slow.keeps_real_time);
  CHECK_THAT(slow.text, Contains("does not keep real time here, 2.4 times too slow"));
  CHECK(advice_for(study, "1 % energy").cell == &study.cells[1]);
  CHECK(advice_for(study, "5 um position").cell == &study.cells[1]);
  CHECK(advice_for(study, "0.25 % position").cell == &study.cells[1]);  // of the motion of 2 mm: 5 um
}

TEST_CASE("A cell keeps real time only if the slowest of its repeats does") {
  StudyRecord study = record();
  study.cells.resize(1);
  study.cells[0].cpu = {0.7, 0.9, 1.25};
  const StudyAdvice late = advice_for(study, "2 % force");
  CHECK_FALSE(late.keeps_real_time);
  CHECK_THAT(late.text, Contains("does not keep real time here, 1.25 times too slow"));
  study.cells[0].cpu.max = 0.96;
  const StudyAdvice on_time = advice_for(study, "2 % force");
  CHECK(on_time.keeps_real_time);
  CHECK_THAT(on_time.text, Contains("keeps real time here, 1.04 times over"));
}

TEST_CASE("The cheapest is so by the median of its repeats, not by a slow one") {
  StudyRecord study = record();
  study.cells.resize(2);
  for (StudyCell& each : study.cells) each.error[StudyQuantity::force] = 0.005;
  study.cells[0].cpu = {0.1, 0.2, 0.9};
  study.cells[1].cpu = {0.25, 0.3, 0.4};
  CHECK(advice_for(study, "1 % force").cell == &study.cells[0]);
}

TEST_CASE("Costs of several machines are advised on with a warning that names the machines, in text and in JSON") {
  StudyRecord study = record();
  CHECK_THAT(advice_for(study, "2 % force").text, !Contains("warning"));
  CHECK_THAT(study_table(study), !Contains("warning"));
  CHECK(Json::parse(study_json(study)).contains("machines") == false);
  study.machines = {"fast, 8 processors", "slow, 2 processors"};
  for (StudyCell& each : study.cells) {
    if (each.state == State::measured) each.machine = study.machines[1];
  }
  study.cells[1].machine = study.machines[0];
  const std::string warning =
      "warning: the costs were measured on 2 machines (#1 fast, 8 processors; #2 slow, 2 processors), and only those of one "
      "machine can be compared";
  const StudyAdvice advice = advice_for(study, "2 % force");
  CHECK(advice.cell == &study.cells[0]);
  CHECK_THAT(advice.text, Contains("\n" + warning) && Contains("keeps real time on slow, 2 processors, 8.33 times over"));
  CHECK_THAT(study_table(study),
             Contains("\n  " + warning) && Contains("0.1 (0.09 .. 0.12) #2\n") && Contains("0.5 (0.45 .. 0.6) #1\n"));
  const Json json = Json::parse(study_json(study));
  CHECK(json.at("machines") == Json({"fast, 8 processors", "slow, 2 processors"}));
  CHECK_THAT(json.at("warning").get<std::string>(), Contains(warning));
  CHECK(json.at("cells").at(1).at("machine") == "fast, 8 processors");
  CHECK_THAT(study_csv(study), Contains(",\"slow, 2 processors\"\n") && Contains(",3,,\"fast, 8 processors\"\n"));
}

TEST_CASE("Costs of several machines are advised on with the same warning for a felt force") {
  FeltStudyRecord study;
  study.reference.scale_N = 1;
  study.reference.estimate_N = 1e-9;
  FeltPoint point;
  point.strategy = "phase_locked";
  point.method = "rk4";
  point.total.rms_N = 1e-3;
  point.cpu = {1, 1, 1};
  study.points = {point, point};
  study.points[1].cpu = {2, 2, 2};
  const StudyGoal goal = *parse_goal("1 % force");
  CHECK_THAT(advise(study, goal).text, !Contains("warning"));
  CHECK(Json::parse(felt_study_json(study)).contains("warning") == false);
  study.machines = {"fast, 8 processors", "slow, 2 processors"};
  study.points[0].machine = study.machines[0];
  study.points[1].machine = study.machines[1];
  const char* const warning =
      "warning: the costs were measured on 2 machines (#1 fast, 8 processors; #2 slow, 2 processors)";
  CHECK_THAT(advise(study, goal).text,
             Contains("1 CPU seconds per simulated second on fast, 8 processors\nwarning: ") && Contains(warning));
  CHECK_THAT(felt_study_table(study), Contains(warning) && Contains("1 (1 .. 1) #1\n") && Contains("2 (2 .. 2) #2\n"));
  CHECK_THAT(Json::parse(felt_study_json(study)).at("warning").get<std::string>(), Contains(warning));
  CHECK_THAT(felt_study_csv(study), Contains(",\"slow, 2 processors\"\n"));
}

TEST_CASE("Where nothing meets the error the advice names the least, and below the reference's floor it does not guess") {
  const StudyRecord study = record();
  const StudyAdvice none = advice_for(study, "2e-8 % force");
  CHECK(none.cell == nullptr);
  CHECK_THAT(none.text, Contains("cannot tell what meets 2e-8 % force"));
  StudyRecord coarse = study;
  coarse.cells.resize(3);
  CHECK_THAT(advice_for(coarse, "0.01 % force").text,
             Contains("none meets 0.01 % force; the least error is 0.1 %: rk4 on cpu, step 1 ms"));
  coarse.cells.clear();
  CHECK(advice_for(coarse, "1 % force").text == "none meets 1 % force");
}

TEST_CASE("A goal is an error and a quantity, anything else is refused with an example") {
  for (const char* bad :
       {"", "force", "1 %", "1 force", "1 % speed", "1 m force", "0 % force", "-1 % force", "nan % force", "% force"}) {
    INFO(bad);
    const Result<StudyGoal> parsed = parse_goal(bad);
    CHECK_FALSE(parsed.ok());
    CHECK_THAT(parsed.error(), Contains("\"1 % force\""));
  }
}

TEST_CASE("The table marks what is at the reference's floor, and gives the reason of what was not measured") {
  const std::string table = study_table(record());
  CHECK_THAT(table, Contains("5e-10*") && Contains("refused: above the limit, \"so it is\"") &&
                        Contains("at the reference's floor"));
  CHECK(table.find("0.02*") == std::string::npos);
}

TEST_CASE("The table says once that a solver lacks a method, the CSV for every step") {
  StudyRecord study = record();
  StudyCell lacking = study.cells.back();
  lacking.state = State::unavailable;
  lacking.reason = "no such method";
  study.cells.insert(study.cells.end(), 3, lacking);
  lacking.method = "implicit-euler";
  study.cells.insert(study.cells.end(), 3, lacking);
  const auto count = [](const std::string& text) {
    std::size_t found = 0;
    for (std::size_t at = 0; (at = text.find("no such method", at)) != std::string::npos; ++at) ++found;
    return found;
  };
  CHECK(count(study_table(study)) == 2);
  CHECK(count(study_csv(study)) == 6);
}

TEST_CASE("The table says what a negative order means where there is one") {
  StudyRecord study = record();
  CHECK_THAT(study_table(study), !Contains("negative order"));
  study.cells[1].order[StudyQuantity::position] = -0.3;
  CHECK_THAT(study_table(study), Contains("-0.30") && Contains("a negative order: the shorter step has the larger error"));
}

TEST_CASE("Every row of the CSV has as many fields as its header, and text is quoted") {
  const std::string csv = study_csv(record());
  const std::size_t columns =
      static_cast<std::size_t>(std::count(csv.begin(), csv.begin() + static_cast<std::ptrdiff_t>(csv.find('\n')), ','));
  std::size_t rows = 0, commas = 0;
  bool quoted = false;
  for (const char c : csv) {
    quoted ^= c == '"';
    commas += c == ',' && !quoted;
    if (c != '\n') continue;
    CHECK(commas == columns);
    commas = 0;
    ++rows;
  }
  CHECK(rows == 6);
  CHECK_THAT(csv, Contains("\"above the limit, \"\"so it is\"\"\"") && Contains(",position force energy,"));
}

TEST_CASE("The figure has a point per measured cell, hollow at the floor, and names what has no point") {
  for (const StudyQuantity q : kStudyQuantities) {
    const std::string svg = study_svg(record(), q);
    const auto count = [&](const std::string& text) {
      std::size_t found = 0;
      for (std::size_t at = 0; (at = svg.find(text, at)) != std::string::npos; ++at) ++found;
      return found;
    };
    CHECK(count("r=\"4\"") == 5);    // four cells and the legend's
    CHECK(count("r=\"2.4\"") == 2);  // one cell and the legend's
    CHECK(count("nan") == 0);
    CHECK(count("inf") == 0);
    CHECK(count("&lt;c&gt;") >= 1);
    CHECK(count("refused (1):") == 1);
  }
  StudyRecord empty = record();
  empty.cells.clear();
  CHECK(study_svg(empty, StudyQuantity::force).find("nan") == std::string::npos);
}
