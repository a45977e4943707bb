// Scenario files that are missing, too large or wrong, and the files that a scenario names.
#include "catch.h"
#include "checked.h"
#include "evenstep/format/scenario.h"
#include "support.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

TEST_CASE("A file that is not there, a folder, or one past the size limit is refused") {
  const TemporaryFolder folder;
  CHECK_THAT(errors_of(read_scenario(folder / "none.toml")), Contains("none.toml: error: no such file"));
  CHECK_THAT(errors_of(read_scenario(folder / "no/none.toml")), Contains("there is no folder"));
  CHECK_THAT(errors_of(read_scenario(folder / "")), Contains("is a directory"));
  const std::string head = kSpring;
  const std::size_t limit = 1 << 20;
  const std::string full = head + std::string(limit - head.size(), '\n');
  CHECK(errors_of(read_scenario(folder.write("full.toml", full))) == "");
  CHECK_THAT(errors_of(read_scenario(folder.write("over.toml", full + "\n"))),
             Contains("over.toml: error: is larger than 1048576 bytes"));
  CHECK_THAT(errors_of(read_scenario(folder.write("empty.toml", ""))), Contains("empty.toml:1:1: error: no 'format'"));
}

TEST_CASE("A trace or a motion file that is wrong is reported with its own line, one that is missing where it is named") {
  const TemporaryFolder folder;
  folder.write("bad.csv", "segment,kind,index,begin_ns,end_ns\n0,step,0,5,4\n");
  folder.write("idle.csv", "segment,kind,index,begin_ns,end_ns\n0,idle,0,0,4\n");
  folder.write("hand.csv", "t_s,x_m,y_m,z_m\n0,0,0,0\n0,1,1,1\n1,nan,0,0\n2,1,2\n3,1,2,3 \n4,1e4,0,0\n");
  folder.write("head.csv", "t,x,y,z\n");
  folder.write("none_at_all.csv", "t_s,x_m,y_m,z_m\n");
  std::string timing = kSpring;
  timing.replace(timing.find("segment = "), timing.find("[scene]") - timing.find("segment = "), "trace = \"bad.csv\"\n");
  const auto with = [&](const std::string& text) { return errors_of(read_scenario(folder.write("s.toml", text))); };
  CHECK_THAT(with(timing), Contains("bad.csv:2:12: error: ends at 4 ns"));
  CHECK_THAT(with(changed(timing, "bad.csv", "nothere.csv")),
             Contains("s.toml:9:9: error: 'trace': '") && Contains("nothere.csv' no such file"));
  CHECK_THAT(with(changed(timing, "bad.csv", "idle.csv")),
             Contains("s.toml:9:9: error: 'trace': '") && Contains("holds no step"));
  CHECK_THAT(with(changed(timing, "bad.csv", "")), Contains("'trace': names no file"));
  std::string motion = kSpring;
  motion.replace(motion.find("motion = "), motion.find("[[expect]]") - motion.find("motion = "),
                 "motion = { kind = \"recorded\", file = \"hand.csv\" }\n");
  const std::string errors = with(motion);
  CHECK_THAT(errors, Contains("hand.csv:3:1: error: 0 s is not later than the row before"));
  CHECK_THAT(errors, Contains("hand.csv:4:3: error: 'nan' is not a number"));
  CHECK_THAT(errors, Contains("hand.csv:5:1: error: 3 cells, where a row has 4"));
  CHECK_THAT(errors, Contains("hand.csv:6:7: error: '3 ' is not a number"));
  CHECK_THAT(errors, Contains("hand.csv:7:3: error: '1e4' is not a number between -1000 and 1000"));
  CHECK_THAT(with(changed(motion, "hand.csv", "nothere.csv")),
             Contains("s.toml:17:") && Contains("nothere.csv' no such file"));
  CHECK_THAT(with(changed(motion, "hand.csv", "head.csv")), Contains("the first line must be t_s,x_m,y_m,z_m"));
  CHECK_THAT(with(changed(motion, "hand.csv", "none_at_all.csv")), Contains("no rows"));
}
