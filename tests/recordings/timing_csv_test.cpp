#include "evenstep/recordings/timing_csv.h"
#include "evenstep/recordings/step_list.h"

#include <filesystem>
#include <random>

#include "catch.h"
#include "evenstep/recordings/recording.h"
#include "evenstep/text/csv_rows.h"
#include "support.h"

using namespace evenstep;
using Catch::Contains;

namespace {
const std::string kHeader = "segment,kind,index,begin_ns,end_ns\n";

std::string first_error(const std::string& rows) {
  const TimingCsv csv = parse_timing_csv(kHeader + rows, "x.csv");
  return csv ? "" : text(csv.error().front());
}
}  // namespace

TEST_CASE("A recording is shifted to begin at 0, keeps its gaps, and idle rows only move the end") {
  const TimingCsv csv = parse_timing_csv(kHeader +
                                             "7,visualization,0,1000,1100\r\n7,step,0,1110,1200\n7,idle,0,1200,1300\n"
                                             "8,step,1,1300,1400\n8,step,3,1400,1400\n",
                                         "x.csv");
  REQUIRE(csv);
  REQUIRE(csv->size() == 2);
  const SegmentTiming& first = (*csv)[0];
  CHECK(first.index == 0);
  CHECK(first.begin.ns == 0);
  REQUIRE(first.visualization);
  CHECK(first.visualization->end.ns == 100);
  REQUIRE(first.steps.size() == 1);
  CHECK(first.steps[0].begin.ns == 110);
  CHECK(first.end.ns == 300);
  CHECK((*csv)[1].index == 1);
  CHECK_FALSE((*csv)[1].visualization);
  CHECK((*csv)[1].begin.ns == 300);
  CHECK((*csv)[1].steps.size() == 2);
}

TEST_CASE("Written, a segment is its visualization and steps by time and its idle rest") {
  SegmentTiming first, second, third;
  first = {4, {0}, Interval{{0}, {30}}, {{{30}, {50}}, {{55}, {90}}}, {100}};
  second = {5, {100}, Interval{{180}, {200}}, {{{110}, {180}}}, {200}};
  third = {6, {200}, std::nullopt, {}, {210}};
  CHECK(format_timing_csv({first, second, third}) == kHeader +
                                                         "4,visualization,0,0,30\n4,step,0,30,50\n4,step,1,55,90\n"
                                                         "4,idle,0,90,100\n"
                                                         "5,segment,0,100,200\n5,step,0,110,180\n5,visualization,0,180,200\n"
                                                         "6,idle,0,200,210\n");
  CHECK(format_timing_csv({}) == kHeader);
}

TEST_CASE("A column simulated_ns has each step's own simulation time, and is written where there are any") {
  const std::string header = "segment,kind,index,begin_ns,end_ns,simulated_ns\n";
  const std::string rows =
      "0,visualization,0,0,30,\n1,step,0,30,50,-5\n1,step,1,55,90,15\n1,idle,0,90,100,\n2,step,0,100,110,75\n";
  const TimingCsv csv = parse_timing_csv(header + rows, "x.csv");
  REQUIRE(csv);
  CHECK((*csv)[0].simulated.empty());
  CHECK((*csv)[1].simulated == std::vector<SimTime>{{-5}, {15}});
  CHECK((*csv)[1].simulated_at((*csv)[1].steps[1]) == SimTime{15});
  CHECK_FALSE((*csv)[0].simulated_at(Interval{}));
  CHECK(format_timing_csv(*csv) == header + rows);
  CHECK(usual_step_size(*csv) == Duration{60});  // of 20 and 60 the later one; where time was dropped they are rare
  CHECK(usual_step_size(*parse_timing_csv(kHeader + "0,step,0,0,9\n", "x.csv")) == Duration{});
}

TEST_CASE("A step without its simulation time, or with one that goes back, is an error with its place") {
  const std::string header = "segment,kind,index,begin_ns,end_ns,simulated_ns\n";
  const auto error_of = [&](const std::string& rows) {
    const TimingCsv csv = parse_timing_csv(header + rows, "x.csv");
    REQUIRE_FALSE(csv);
    const Diagnostic& error = csv.error().front();
    return std::to_string(error.line) + ":" + std::to_string(error.column) + ": " + error.message;
  };
  CHECK(error_of("0,step,0,0,9,\n") == "2:14: a step has its own simulation time here, in whole ns");
  CHECK(error_of("0,step,0,0,9,7\n0,step,1,9,12,6\n") == "3:15: simulation time 6 ns follows 7 ns");
  CHECK(error_of("0,step,0,0,9,x\n").starts_with("2:14: 'x' is not a whole number"));
  CHECK(
      error_of("0,step,0,0,9,0\n0,step,1,9,12,1000000000000001\n").starts_with("3:15: the recording is longer than 1e6 s"));
  CHECK(error_of("0,step,0,0,9\n") == "2:1: 5 cells, where a row has 6");
}

TEST_CASE("What is written reads back: a thousand drawn recordings, visualizations beside the steps or between them") {
  std::mt19937_64 random(1);
  const auto up_to = [&](std::uint64_t most) { return static_cast<std::int64_t>(random() % (most + 1)); };
  for (int round = 0; round < 1000; ++round) {
    std::vector<SegmentTiming> written;
    RealTime now{0};
    for (std::int64_t k = 0; k < 1 + up_to(4); ++k) {
      SegmentTiming segment;
      segment.index = k;
      segment.begin = now;
      segment.visualization = Interval{now, now + Duration{1 + up_to(50)}};
      if (up_to(1) == 0) now = segment.visualization->end;
      for (std::int64_t i = up_to(5); i > 0; --i) {
        const RealTime begin = now + Duration{up_to(3)};
        now = begin + Duration{1 + up_to(20)};
        segment.steps.push_back({begin, now});
      }
      now = segment.end = std::max(now, segment.visualization->end) + Duration{up_to(10)};
      written.push_back(segment);
    }
    const TimingCsv csv = parse_timing_csv(format_timing_csv(written), "x.csv");
    REQUIRE(csv);
    REQUIRE(csv->size() == written.size());
    for (std::size_t k = 0; k < written.size(); ++k) {
      const SegmentTiming &a = written[k], &b = (*csv)[k];
      CHECK((a.begin == b.begin && a.end == b.end));
      CHECK((a.visualization->begin == b.visualization->begin && a.visualization->end == b.visualization->end));
      CHECK(std::equal(a.steps.begin(), a.steps.end(), b.steps.begin(), b.steps.end(),
                       [](const Interval& x, const Interval& y) { return x.begin == y.begin && x.end == y.end; }));
    }
  }
}

TEST_CASE("A visualization may overlap the steps of its own and of the next segment") {
  const TimingCsv csv = parse_timing_csv(kHeader +
                                             "0,visualization,0,0,100\n0,step,0,10,50\n0,step,1,50,90\n0,step,2,90,120\n"
                                             "1,visualization,0,105,200\n1,step,0,120,150\n",
                                         "x.csv");
  REQUIRE(csv);
  CHECK((*csv)[0].end.ns == 120);
  CHECK((*csv)[1].begin.ns == 105);
}

TEST_CASE("Steps may open a segment: it begins with the first of them") {
  const TimingCsv csv =
      parse_timing_csv(kHeader + "0,step,0,5,10\n0,visualization,0,10,30\n1,idle,0,30,40\n1,step,0,40,50\n", "x.csv");
  REQUIRE(csv);
  CHECK((*csv)[0].begin.ns == 0);
  CHECK((*csv)[0].visualization->begin.ns == 5);
  CHECK((*csv)[1].begin.ns == 35);  // the step, not the idle time before it
}

TEST_CASE(
    "A row of kind segment says where a segment begins, also one without anything in it, and is written where it is "
    "needed") {
  const std::string rows =
      "0,visualization,0,0,10\n0,step,0,0,18\n1,segment,0,20,40\n1,step,0,25,44\n2,segment,0,40,60\n"
      "2,idle,0,40,60\n3,visualization,0,60,70\n";
  const TimingCsv csv = parse_timing_csv(kHeader + rows, "x.csv");
  REQUIRE(csv);
  REQUIRE(csv->size() == 4);
  CHECK((*csv)[1].begin.ns == 20);
  CHECK((*csv)[1].end.ns == 44);
  CHECK(((*csv)[2].begin.ns == 40 && (*csv)[2].end.ns == 60 && (*csv)[2].steps.empty()));
  // An idle row says the same of a segment with nothing else in it.
  CHECK(format_timing_csv(*csv) == kHeader +
                                       "0,visualization,0,0,10\n0,step,0,0,18\n1,segment,0,20,44\n1,step,0,25,44\n"
                                       "2,idle,0,40,60\n3,visualization,0,60,70\n");
  // One without any length, which nothing else could show.
  std::vector<SegmentTiming> empty = *csv;
  empty[2].end = empty[2].begin;
  const TimingCsv again = parse_timing_csv(format_timing_csv(empty), "x.csv");
  REQUIRE(again);
  CHECK(format_timing_csv(*again) == format_timing_csv(empty));
  CHECK((*again)[2].begin.ns == 40);
}

TEST_CASE("Times may be negative, and zero may be anywhere in a recording") {
  const std::string later = "0,visualization,0,0,100\n0,step,0,100,150\n1,step,0,160,200\n1,idle,0,200,210\n";
  const TimingCsv csv = parse_timing_csv(kHeader + later, "x.csv");
  for (const std::string earlier :
       {"0,visualization,0,-120,-20\n0,step,0,-20,30\n1,step,0,40,80\n1,idle,0,80,90\n",
        "0,visualization,0,-4000000000000000000,-3999999999999999900\n0,step,0,-3999999999999999900,-3999999999999999850\n"
        "1,step,0,-3999999999999999840,-3999999999999999800\n1,idle,0,-3999999999999999800,-3999999999999999790\n"}) {
    const TimingCsv shifted = parse_timing_csv(kHeader + earlier, "x.csv");
    REQUIRE(shifted);
    CHECK(format_timing_csv(*shifted) == format_timing_csv(*csv));
  }
  const TimingCsv list = parse_timing_or_steps("begin_ns,end_ns\n-40,-10\n-10,20\n", "x.csv");
  REQUIRE(list);
  CHECK(list->front().steps[1].end.ns == 60);
}

TEST_CASE("A mistake in a recording is named with its line and column") {
  struct {
    const char* rows;
    const char* error;
  } const table[] = {
      {"0,step,0,0\n", "x.csv:2:1: error: 4 cells, where a row has 5"},
      {"0,step,0,0,1,2\n", "x.csv:2:1: error: 6 cells"},
      {"0,step,0,0,1\n0,step,1,1.5,2\n", "x.csv:3:10: error: '1.5' is not a whole number"},
      {"0,step,0, 0,1\n", "x.csv:2:10: error: ' 0' is not a whole number"},
      {"0,step,-5,0,1\n", "'-5' is not a whole number from 0 to"},
      {"0,step,0,-4000000000000000001,1\n", "x.csv:2:10: error: '-4000000000000000001' is not a whole number from -4"},
      {"0,step,0,--5,1\n", "'--5' is not a whole number"},
      {"0,step,0,-,1\n", "'-' is not a whole number"},
      {"0,step,0,-4000000000000000000,4000000000000000000\n", "are these nanoseconds?"},
      {"0,step,0,-5,-6\n", "x.csv:2:13: error: ends at -6 ns, before it begins at -5 ns"},
      {"0,step,0,-9,-5\n0,step,1,-6,4\n", "begins at -6 ns, before the step before it ended at -5 ns"},
      {"0,step,0,0x5,1\n", "'0x5' is not a whole number"},
      {"0,step,0,,1\n", "'' is not a whole number"},
      {"0,step,0,0,9223372036854775808\n", "'9223372036854775808' is not a whole number"},
      {"x,step,0,0,1\n", "'x' is not a whole number"},
      {"0,render,0,0,1\n", "x.csv:2:3: error: kind 'render' must be segment, visualization, step or idle"},
      {"0,step,0,0,1\n0,segment,0,0,9\n", "x.csv:3:3: error: a segment has one row 'segment', its first, of index 0"},
      {"0,segment,0,5,9\n0,segment,0,5,9\n", "x.csv:3:3: error: a segment has one row 'segment'"},
      {"0,segment,0,5,9\n0,step,0,4,9\n", "x.csv:3:10: error: begins at 4 ns, before its segment begins at 5 ns"},
      {"0,step,0,5,4\n", "x.csv:2:12: error: ends at 4 ns, before it begins at 5 ns"},
      {"0,step,0,0,10\n0,step,1,9,12\n", "x.csv:3:10: error: begins at 9 ns, before the step before it ended at 10 ns"},
      {"0,step,0,0,10\n1,step,0,9,12\n", "before the step before it ended"},
      {"0,visualization,0,0,10\n1,visualization,0,9,12\n", "before the visualization before it ended"},
      {"1,step,0,0,10\n0,step,0,10,12\n", "x.csv:3:1: error: segment 0 follows segment 1"},
      {"0,step,0,0,10\n2,step,0,10,12\n", "segment 2 follows segment 0"},
      {"0,step,1,0,10\n0,step,1,10,12\n", "x.csv:3:8: error: index 1 follows 1"},
      {"0,idle,1,0,10\n0,idle,0,10,12\n", "index 0 follows 1"},
      {"0,visualization,0,0,1\n0,visualization,0,1,2\n", "one visualization"},
      {"0,visualization,1,0,1\n", "one visualization"},
      {"0,visualization,0,50,60\n1,step,0,40,41\n", "segment 1 begins at 40 ns, not after the segment before it"},
      {"0,step,0,0,1\n0,step,1,1,2000000000000000\n", "are these nanoseconds?"},
      // The first row need not be the earliest.
      {"0,idle,0,4000000000000000000,4000000000000000000\n0,step,0,0,5\n", "x.csv:3:10: error: the recording is longer"},
      {"", "x.csv:1:1: error: no rows"},
  };
  for (const auto& row : table) {
    INFO(row.rows);
    CHECK_THAT(first_error(row.rows), Contains(row.error));
  }
  for (const char* header : {"", "0,step,0,0,1\n", "segment,kind,index,begin_ns\n"}) {
    const TimingCsv csv = parse_timing_csv(header, "x.csv");
    REQUIRE(csv.error_or({}).size() == 1);
    CHECK_THAT(text(csv.error()[0]),
               Contains("x.csv:1:1: error: the first line must be segment,kind,index,begin_ns,end_ns"));
  }
}

TEST_CASE("A byte order mark at the beginning of a timing.csv or a list of steps is skipped") {
  const std::string mark = "\xEF\xBB\xBF";
  CHECK(parse_timing_csv(mark + kHeader + "0,step,0,0,10\n", "x.csv"));
  CHECK(parse_timing_csv(mark + "# made by a tool\n" + kHeader + "0,step,0,0,10\n", "x.csv"));
  CHECK(parse_timing_or_steps(mark + "begin_ns,end_ns\n0,10\n", "x.csv"));
}

TEST_CASE("Remarks before the header are left out, lines still count, and a remark among the rows is no row") {
  const std::string rows = kHeader + "0,step,0,0,10\n";
  CHECK(parse_timing_csv("# made by a tool\n#\n" + rows, "x.csv"));
  CHECK(parse_timing_or_steps("# made by a tool\nbegin_ns,end_ns\n0,10\n", "x.csv"));
  const TimingCsv late = parse_timing_csv("# one\n# two\n" + kHeader + "0,step,0,5,4\n", "x.csv");
  CHECK_THAT(text(late.error_or({}).at(0)), Contains("x.csv:4:"));
  for (const std::string only : {"#", "# one\n", "# one\n# two"})
    CHECK_THAT(text(parse_timing_csv(only, "x.csv").error_or({}).at(0)), Contains("the first line must be"));
  CHECK_THAT(text(parse_timing_csv(rows + "# late\n", "x.csv").error_or({}).at(0)), Contains("x.csv:3:1"));
  const testing::TemporaryFolder folder;
  CHECK(is_timing_csv(folder.write("mark.csv", "\xEF\xBB\xBF# one\n" + rows)));
  CHECK(is_timing_csv(folder.write("remarks.csv", "# one\n# two\n" + rows)));
  CHECK(read_timing_csv(folder / "remarks.csv"));
  CHECK_FALSE(is_timing_csv(folder.write("other.csv", "# one\n# two\nts,dur,name\n")));
  CHECK_FALSE(is_timing_csv(folder.write("remark.csv", "#")));
}

TEST_CASE("A wrong column gives 20 errors, not one for each of a million rows") {
  std::string rows = kHeader;
  for (int i = 0; i < 1000; ++i) rows += "0,step,0,0,x\n";
  CHECK(parse_timing_csv(rows, "x.csv").error_or({}).size() == internal::kMostCsvErrors);
}

TEST_CASE("Ten million rows are read and one more is refused", "[million]") {
  std::string rows = kHeader;
  const std::string row = "0,idle,0,0,1\n";
  rows.reserve(rows.size() + row.size() * (internal::kMostCsvRows + 1));
  // Only the first idle row would be in order, and each of the others would be an error. So the rows are valid steps.
  std::int64_t t = 0;
  for (std::int64_t i = 0; i < internal::kMostCsvRows; ++i, ++t) {
    rows += "0,step," + std::to_string(i) + "," + std::to_string(t) + "," + std::to_string(t + 1) + "\n";
  }
  CHECK(parse_timing_csv(rows, "x.csv"));
  rows += "1,step,0," + std::to_string(t) + "," + std::to_string(t + 1) + "\n";
  const TimingCsv csv = parse_timing_csv(rows, "x.csv");
  REQUIRE(csv.error_or({}).size() == 1);
  CHECK_THAT(csv.error()[0].message, Contains("more than 10000000 rows"));
}

TEST_CASE("A recording that is not there, or is a folder, is an error of the whole file") {
  const testing::TemporaryFolder folder;
  CHECK_THAT(text(read_timing_csv(folder / "none.csv").error().at(0)), Contains("none.csv: error: no such file"));
  CHECK_THAT(text(read_timing_csv(folder / "sub/none.csv").error().at(0)), Contains("there is no folder"));
  CHECK_THAT(text(read_timing_csv(folder / "").error().at(0)), Contains("is a directory"));
}

TEST_CASE("Every recording that is shipped reads, and holds what a replay relies on") {
  const std::filesystem::path recorded = std::filesystem::path(EVENSTEP_SOURCE_DIR) / "scenarios" / "recorded";
  std::size_t read = 0;
  for (const auto& entry : std::filesystem::directory_iterator(recorded)) {
    if (entry.path().extension() != ".csv") continue;
    INFO(entry.path());
    ++read;
    const TimingCsv csv = read_timing_csv(entry.path().string());
    for (const Diagnostic& error : csv.error_or({})) UNSCOPED_INFO(text(error));
    REQUIRE(csv);
    RealTime last_end{0};
    RealTime last_begin{-1};
    for (const SegmentTiming& segment : *csv) {
      CHECK(segment.begin > last_begin);
      last_begin = segment.begin;
      for (const Interval& step : segment.steps) {
        CHECK(step.begin >= last_end);
        CHECK(step.begin >= segment.begin);
        last_end = step.end;
      }
      CHECK((segment.steps.empty() || segment.end >= segment.steps.back().end));
    }
    CHECK(csv->front().begin.ns == 0);
  }
  CHECK(read >= 9);
}

TEST_CASE(
    "a list of steps becomes the segments of its cycle, without the steps before the first long pause, or a step each") {
  const auto list = [](std::int64_t first, std::int64_t last) {  // five steps of 1 ms, 20 ms of pause, jittered
    std::vector<Interval> steps;
    for (std::int64_t n = first; n < last; ++n) {
      const std::int64_t begin = n / 5 * 26'000'000 + n % 5 * 1'100'000 + n * 7919 % 1000;
      steps.push_back({RealTime{begin}, RealTime{begin + 1'000'000}});
    }
    return steps;
  };
  const auto cycle = [](const std::vector<Interval>& steps) {
    SegmentTiming all;
    all.steps = steps;
    return cycle_of({all});
  };
  const std::vector<Interval> whole = list(0, 200), late = list(2, 200);
  const CutSteps cut = cut_steps(whole, cycle(whole));
  CHECK(cut.left_out == 0);
  REQUIRE(cut.segments.size() == 40);
  for (const SegmentTiming& segment : cut.segments) CHECK(segment.steps.size() == 5);
  CHECK(cut.segments[7].begin == whole[35].begin);
  CHECK(cut.segments[7].end == whole[39].end);
  const CutSteps later = cut_steps(late, cycle(late));
  CHECK(later.left_out == 3);
  CHECK(later.segments.size() == 39);
  std::vector<Interval> even;
  for (std::int64_t n = 0; n < 50; ++n) even.push_back({RealTime{n * 2'000'000}, RealTime{n * 2'000'000 + 1'000'000}});
  CHECK(cut_steps(even, cycle(even)).segments.size() == 50);
}
