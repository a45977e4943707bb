#include <nlohmann/json.hpp>

#include "catch.h"
#include "evenstep/pages/comparison_page.h"
#include "evenstep/pages/index_page.h"
#include "evenstep/reports/comparison_record.h"
#include "evenstep/reports/plain_text.h"

using namespace evenstep;
using Catch::Contains;
using Change = ComparedFigure::Change;

namespace {

const std::string kHostile = "<script>alert(1)</script>]]>\u202e\x1b[31m|`x`\n[l](javascript:x) @me #1 www.x.y \xff";

ComparisonRecord record_with(const std::string& name) {
  ComparisonRecord record;
  record.a = {name, 2, {"2026-11-22T00:00:00Z", "2026-11-23T00:00:00Z"}, {name}, {"0.2.0"}};
  record.b = {name, 1, {}, {}, {name}};
  record.runs = {{name, name, ComparedRun::In::both, {name}, 10, 8, ""},
                 {"y", "y", ComparedRun::In::both, {}, 5, 5, "00ff"}};
  record.figures = {{0, name, "latency", "", "s", 0.010, 0.011, "", "", Change::worse, false, {0}},
                    {0, name, "verdict", name, "", {}, {}, name, "absent", Change::incomparable, false, {}},
                    {1, "solver.paper", "solver_seconds", "", "s", 1.0, 2.0, "", "", Change::other, true, {}}};
  record.conditions = {{name, 12, 1}, {"verdict", 3, 0}};
  return record;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

}  // namespace

TEST_CASE("text of others stays on its line and is shown as what it is") {
  CHECK(plain_text("a\nb\tc") == "a b c");
  CHECK(plain_text("\x1b[31m\u202ex") == "⟨U+001B⟩[31m⟨U+202E⟩x");
  CHECK(plain_text("\xff") == "\ufffd");
  CHECK(plain_text(std::string(500, 'x')).size() == 200 + std::string("…").size());
  CHECK(markdown_text("a|b `c` <d> [e](f) @g #1 *h* _i_ www.x") ==
        "a\\|b \\`c\\` \\<d\\> \\[e\\](f) \\@g \\#1 \\*h\\* \\_i\\_ www\\.x");
}

TEST_CASE("the terminal's table has the worst first, with units, change and condition") {
  const std::string text = comparison_text(record_with("x"), false, 40, false);
  CHECK(text ==
        "A  x: 2 runs, 2026-11-22T00:00:00Z to 2026-11-23T00:00:00Z, commit x, evenstep 0.2.0\n"
        "B  x: 1 run, no date, no commit, evenstep x\n"
        "!  x: x\n"
        "run  signal  figure            A       B        change\n"
        "x    x       latency       10 ms   11 ms  +1 ms, +10 %  worse; x\n"
        "x    x       verdict of x      x  absent                cannot be compared\n"
        "FAIL  x: so in 1 of 12 figures\n"
        "pass  verdict: not so in 3 figures\n"
        "FAIL: 1 of 2 conditions broken; 1 worse, 0 better, 0 changed, 1 not comparable; 13 of 15 figures equal to the last "
        "bit; 1 run bit-equal in all\n");
  CHECK_THAT(comparison_text(record_with("x"), false, 1, false), Contains("and 1 more; --all shows them"));
  CHECK_THAT(comparison_text(record_with("x"), false, 40, true), Contains("solver_seconds"));
}

TEST_CASE("a hostile name changes neither the terminal nor the lines of its table") {
  for (const bool colour : {false, true}) {
    const std::string honest = comparison_text(record_with("x"), colour, 40, true),
                      hostile = comparison_text(record_with(kHostile), colour, 40, true);
    CHECK(count(honest, "\n") == count(hostile, "\n"));
    CHECK(count(honest, "\x1b") == count(hostile, "\x1b"));
    CHECK(hostile.find("\u202e") == std::string::npos);
  }
}

TEST_CASE("a hostile name is neither Markdown nor HTML in the text for a pull request") {
  const std::string honest = comparison_markdown(record_with("x")), hostile = comparison_markdown(record_with(kHostile));
  CHECK(count(honest, "\n") == count(hostile, "\n"));
  CHECK(count(honest, " | ") == count(hostile, " | "));
  for (const char* markup : {"<", "`", "[", "@", "#1", "|`", "www.", "\x1b", "\u202e"}) {
    INFO(markup);
    std::size_t bare = 0;
    for (std::size_t at = hostile.find(markup); at != std::string::npos; at = hostile.find(markup, at + 1))
      bare += at == 0 || hostile[at - 1] != '\\';
    CHECK(bare == 0);
  }
}

TEST_CASE("the text for a pull request fits into a comment, however much differs") {
  ComparisonRecord record = record_with(std::string(300, '|'));
  for (int i = 0; i < 3000; ++i) {
    record.figures.push_back(record.figures[0]);
    record.runs.push_back(record.runs[0]);
  }
  const std::string text = comparison_markdown(record);
  CHECK(text.size() < 60'000);
  CHECK_THAT(text, Contains("more figures that differ") && Contains("more notes"));
}

TEST_CASE("the JSON of a comparison is read back, with words where there are no numbers") {
  const nlohmann::json read = nlohmann::json::parse(comparison_json(record_with(kHostile)));
  CHECK(read["holds"] == false);
  CHECK(read["figures"][0]["difference"].get<double>() == Approx(0.001));
  CHECK(read["figures"][1]["b"] == "absent");
  CHECK(read["figures"][2]["change"] == "other");
  CHECK(read["runs"][1]["trace_hash"] == "00ff");
}

TEST_CASE("a hostile name stays a name on both pages, and a link leads nowhere but below the page") {
  const auto index = [](const std::string& name) {
    IndexedRun run{name, name + "/summary.json", name, name, "2026-11-23T00:00:00Z", name, "fail", 0.1, name};
    return index_page(name, {run, run}, "evenstep index " + name);
  };
  const std::string honest = index("x") + comparison_page(record_with("x"), "x"),
                    hostile = index(kHostile) + comparison_page(record_with(kHostile), kHostile);
  for (const char* markup : {"<script", "</script", "<td", "<a ", "<circle"})
    CHECK(count(honest, markup) == count(hostile, markup));
  CHECK(hostile.find("href=\"javascript") == std::string::npos);
  CHECK(count(hostile, "href=\"./%3Cscript%3E") == 3);
  CHECK(hostile.find("\u202e") == std::string::npos);
  CHECK(hostile.find('\x1b') == std::string::npos);
}

TEST_CASE("an index has a row for each scenario, with its latest run, and one for each run") {
  const auto run = [](const std::string& name, const std::string& file, const std::string& date, const std::string& verdict,
                      std::optional<double> margin) {
    return IndexedRun{name, name + "/report.html", "S " + file, file, date, "", verdict, margin, margin ? "late <= 1" : ""};
  };
  const std::string page =
      index_page("runs",
                 {run("1/x", "x.toml", "2026-11-21T00:00:00Z", "pass", 0.25),
                  run("2/x", "x.toml", "2026-11-22T00:00:00Z", "fail", -1e300), run("2/y", "y.toml", "", "none", {})},
                 "evenstep index runs");
  CHECK_THAT(page, Contains("3 runs of 2 scenarios; the latest run of 0 of them passes"));
  CHECK(count(page, "<svg") == 2);
  CHECK_THAT(page, Contains("worst margin of 2 runs, from 25 % to"));
  CHECK_THAT(page, Contains("href=\"./2/x/report.html\"") && Contains("no date") && Contains("none"));
  CHECK(page.find("nan") == std::string::npos);
  CHECK(page.find("inf") == std::string::npos);
}
