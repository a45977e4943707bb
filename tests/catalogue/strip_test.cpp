// The decade strip: the table, the picture and the CSV contain everything that happened.
#include <cmath>

#include "catch.h"
#include "evenstep/reports/case_record.h"

using namespace evenstep;
using Catch::Contains;

namespace {

CaseRecord every_status() {
  CaseRow row{"rk4", "cpu", {}};
  double value = 1;
  for (const CellStatus status : {CellStatus::ok, CellStatus::damped, CellStatus::drifting, CellStatus::refused,
                                  CellStatus::diverged, CellStatus::unavailable, CellStatus::interrupted}) {
    CaseCell cell;
    cell.value = value;
    cell.status = status;
    cell.steps = 17;
    value *= 10;
    row.cells.push_back(cell);
  }
  row.cells[0].metrics = {{"order", 1.5}, {"order_min", 1.5}};
  row.cells[1].metrics = {{"order", 2.5}, {"order_min", 2.5}};
  row.cells[1].shown = 0.25;
  row.cells[2].shown = 0.03;
  row.cells[3].detail = "too long, \"quoted\"";
  row.cells[4].schedule_differs = true;
  return {"oscillator", "stiffness", "N/m", {row}};
}

std::size_t count_of(const std::string& text, const std::string& what) {
  std::size_t count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

}  // namespace

TEST_CASE("The table shows the value and the fate of every cell, with the number of what is not quite right") {
  const std::string table = case_table(every_status());
  for (const char* part : {"stiffness [N/m]", "1e+05", "rk4 cpu", " ok", "x0.25", "~0.03", "refused", "@17", " not run"})
    CHECK_THAT(table, Contains(part));
}

TEST_CASE("The picture has a cell of its own colour and words for every status, and a legend that explains them") {
  const std::string svg = case_strip_svg(every_status(), "a <case>");
  CHECK_THAT(svg, Contains("a &lt;case&gt;"));
  for (const char* text : {">ok<", ">x0.25<", ">~0.03<", ">refused<", ">@17<", ">-<", ">not run<", ">interrupted<",
                           "refused by the solver", "energy left"})
    CHECK_THAT(svg, Contains(text));
  for (const char* colour : {"#009e73", "#e69f00", "#d55e00"}) CHECK(count_of(svg, colour) >= 2);  // cell and legend
  CHECK(count_of(svg, "<rect") == 1 + 7 + 7);
}

TEST_CASE("A strip without rows is an empty picture, not a crash") {
  CHECK_THAT(case_strip_svg({}, "none"), Contains("</svg>"));
  CHECK(case_table({}).empty());
}

TEST_CASE("Counts add up, largest and least are taken over the cells in range, and a NaN is not hidden") {
  CaseRecord record = every_status();
  auto all = measure(record).at("case.rk4.cpu");
  CHECK(all.at("cells") == 7);
  for (const char* status :
       {"ok", "damped", "drifting", "refused", "diverged", "unavailable", "interrupted", "schedule_difference"})
    CHECK(all.at(status) == 1);
  CHECK(all.at("order") == 2.5);
  CHECK(all.at("order_min") == 1.5);
  const auto some = measure(record, ValueRange{10, 1000}).at("case.rk4.cpu");
  CHECK(some.at("cells") == 3);
  CHECK(some.at("ok") == 0);
  CHECK(some.at("order_min") == 2.5);
  CHECK(measure(record, ValueRange{2, 9}).empty());
  record.rows[0].cells[1].metrics["order"] = NAN;
  CHECK(std::isnan(measure(record).at("case.rk4.cpu").at("order")));
}

TEST_CASE("cells.csv has a line per cell with every metric that any cell has") {
  const std::string csv = cells_csv(every_status());
  CHECK_THAT(csv, Contains("method,solver,value,status,shown,steps,digest,schedule_differs,order,order_min,detail\n"));
  CHECK_THAT(csv, Contains("rk4,cpu,10,damped,0.25,17,0000000000000000,0,2.5,2.5,\n"));
  CHECK_THAT(csv, Contains("rk4,cpu,1000,refused,,17,0000000000000000,0,,,\"too long, \"\"quoted\"\"\"\n"));
  CHECK_THAT(csv, Contains("rk4,cpu,1000000,interrupted,"));
  CHECK(count_of(csv, "\n") == 8);
}
