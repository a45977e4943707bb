// What files owe and some do not keep: each rule of docs/timings/recordings.md about damaged recordings.
#include "catch.h"
#include "evenstep/recordings/roles.h"
#include "profile_texts.h"
#include "real_files.h"
#include "support.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

/// "3 begins without an end, the first: a"
std::string left_out_text(const std::vector<LeftOut>& left_out) {
  std::string all;
  for (const LeftOut& one : left_out)
    all += (all.empty() ? "" : "; ") + std::to_string(one.count) + " " + one.what +
           (one.first.empty() ? "" : ", the first: " + one.first);
  return all;
}

struct TraceEvent {
  const char* phase;
  const char* name;
  std::int64_t ts, dur = -1;
  const char* category = "";
  int tid = 1;
};

std::string json_of(const std::vector<TraceEvent>& events) {
  std::string all;
  for (const TraceEvent& one : events) {
    all += std::string(all.empty() ? "[" : ",\n") + R"({"ph":")" + one.phase + R"(","name":")" + one.name +
           R"(","pid":1,"tid":)" + std::to_string(one.tid) + ",\"ts\":" + std::to_string(one.ts);
    if (one.phase[0] == 'X') all += ",\"dur\":" + std::to_string(one.dur);
    if (one.category[0] != 0) all += std::string(",\"cat\":\"") + one.category + "\"";
    all += "}";
  }
  return all + "]";
}

Roles draw_and_step() {
  Roles roles;
  roles.visualization = "draw";
  roles.step = "step";
  return roles;
}

AssignedRoles assigned_of(const Profile& profile) {
  AssignedRolesResult assigned = assign_roles(profile, draw_and_step());
  INFO((assigned ? "" : text(assigned.error().front())));
  REQUIRE(assigned);
  return *assigned;
}

}  // namespace

TEST_CASE(
    "A kernel that runs over the next ones of its queue ends where the next one begins, counted, named and warned of") {
  const ProfileResult profile = read_profile(made_file("overflow.json"));
  REQUIRE(profile);
  CHECK(profile->clipped.count == 1);
  CHECK(profile->clipped.first == "step");
  const AssignedRoles assigned = assigned_of(*profile);
  CHECK(assigned.clipped == 1);
  CHECK(assigned.merged == 0);
  REQUIRE(assigned.segments.size() == 2);  // the third one is cut off with the file
  for (const SegmentTiming& segment : assigned.segments) CHECK(segment.steps.size() == 3);
  CHECK(assigned.segments.front().steps.front().end.ns == 4'000'000);
  CHECK(assigned.damaged());  // 1 of 12
}

TEST_CASE("Of kernels of two queues none is clipped at the other's begin") {
  const Profile profile =
      profile_of(json_of({{"X", "a", 0, 100, "kernel", 1}, {"X", "b", 50, 100, "kernel", 2}, {"X", "c", 70, 5, "", 1}}));
  CHECK(intervals_text(profile, 1000) == "a 0 100\nb 50 150\nc 70 75\n");
  CHECK(profile.clipped.count == 0);
}

TEST_CASE("Kernels that begin together are clipped at the next begin, not at each other's") {
  CHECK(intervals_text(
            profile_of(json_of({{"X", "a", 0, 100, "kernel"}, {"X", "b", 0, 10, "kernel"}, {"X", "c", 30, 10, "kernel"}})),
            1000) == "b 0 10\na 0 30\nc 30 40\n");
}

TEST_CASE("In a thread slices nest, and one that ends within a later one is clipped at its begin") {
  const Profile profile =
      profile_of(json_of({{"X", "outer", 0, 100}, {"X", "inner", 10, 20}, {"X", "cut", 40, 30}, {"X", "over", 60, 90}}));
  // "over" runs over the ends of both that it began in.
  CHECK(intervals_text(profile, 1000) == "outer 0 60\ninner 10 30\ncut 40 60\nover 60 150\n");
  CHECK(profile.clipped.count == 2);
}

TEST_CASE("An overlap of a microsecond is rounding: the shorter way is taken, and nothing is counted") {
  const Profile follows = profile_of(json_of({{"X", "a", 0, 11}, {"X", "b", 10, 10}}));
  CHECK(intervals_text(follows, 1000) == "a 0 10\nb 10 20\n");
  CHECK(follows.clipped.count == 0);
  const Profile within = profile_of(json_of({{"X", "a", 0, 100}, {"X", "b", 50, 51}}));
  CHECK(intervals_text(within, 1000) == "a 0 100\nb 50 100\n");
  CHECK(within.clipped.count == 0);
}

TEST_CASE(
    "A step of a thread that holds a picture and another step has lost its end, and one that holds steps alone has not") {
  const Profile lost = profile_of(json_of({{"X", "draw", 0, 10},
                                           {"X", "step", 10, 9000},
                                           {"X", "step", 20, 5},
                                           {"X", "draw", 30, 10},
                                           {"X", "step", 40, 5},
                                           {"X", "draw", 60, 10}}));
  CHECK(lost.clipped.count == 0);
  const AssignedRoles assigned = assigned_of(lost);
  CHECK(assigned.clipped == 1);
  REQUIRE(assigned.segments.size() == 2);
  CHECK(assigned.segments[0].steps.size() == 2);
  CHECK(assigned.segments[0].steps[0].end.ns == 20'000);
  CHECK(assigned.segments[1].steps.size() == 1);
  const AssignedRoles whole = assigned_of(
      profile_of(json_of({{"X", "draw", 0, 10}, {"X", "step", 10, 15}, {"X", "step", 12, 5}, {"X", "draw", 30, 10}})));
  CHECK(whole.clipped == 0);
  CHECK(whole.merged == 1);
  CHECK(whole.segments[0].steps[0].end.ns == 25'000);
}

TEST_CASE("A picture that holds a step and another picture has lost its end, and one that holds steps alone has not") {
  const AssignedRoles lost = assigned_of(profile_of(json_of(
      {{"X", "draw", 0, 9000}, {"X", "step", 10, 5}, {"X", "draw", 30, 10}, {"X", "step", 40, 5}, {"X", "draw", 60, 10}})));
  CHECK(lost.clipped == 1);
  REQUIRE(lost.segments.size() == 2);
  CHECK(lost.segments[0].visualization->end.ns == 10'000);
  const AssignedRoles whole = assigned_of(profile_of(json_of(
      {{"X", "draw", 0, 20}, {"X", "step", 10, 5}, {"X", "draw", 30, 10}, {"X", "step", 40, 5}, {"X", "draw", 60, 10}})));
  CHECK(whole.clipped == 0);
  CHECK(whole.segments[0].visualization->end.ns == 20'000);
}

TEST_CASE("Begins without an end are left out, those within the one that ends, too") {
  const Profile profile =
      profile_of(json_of({{"B", "a", 0}, {"B", "b", 10}, {"B", "c", 20}, {"E", "a", 30}, {"B", "d", 40}}));
  CHECK(intervals_text(profile, 1000) == "a 0 30\n");
  CHECK(left_out_text(profile.left_out) == "3 begins without an end, the first: b");
}

TEST_CASE("Ends without a begin and ends of another name are left out") {
  const Profile profile = profile_of(json_of({{"E", "x", 0}, {"B", "a", 10}, {"E", "y", 15}, {"E", "", 20}}));
  CHECK(intervals_text(profile, 1000) == "a 10 20\n");
  CHECK(left_out_text(profile.left_out) == "2 ends without a begin, the first: x");
}

TEST_CASE("Complete events that end before they begin are left out") {
  const Profile profile = profile_of(json_of({{"X", "a", 10, -5}, {"X", "b", 0, 5}}));
  CHECK(intervals_text(profile, 1000) == "b 0 5\n");
  CHECK(left_out_text(profile.left_out) == "1 intervals that end before they begin, the first: a");
}

TEST_CASE("Of equal events one is kept") {
  const Profile profile = profile_of(json_of({{"X", "a", 0, 5}, {"X", "a", 0, 5}, {"X", "a", 0, 5}, {"X", "b", 0, 5}}));
  CHECK(intervals_text(profile, 1000) == "a 0 5\nb 0 5\n");
  CHECK(left_out_text(profile.left_out) == "2 intervals that are there twice");
}

TEST_CASE("A begin or end of a thread whose time goes back is left out, and complete events may come in any order") {
  const Profile profile = profile_of(json_of({{"B", "a", 100}, {"B", "b", 50}, {"E", "b", 60}, {"E", "a", 200}}));
  CHECK(intervals_text(profile, 1000) == "a 100 200\n");
  CHECK(left_out_text(profile.left_out) == "2 begins and ends whose time goes back, the first: b");
  CHECK(intervals_text(profile_of(json_of({{"X", "a", 100, 5}, {"X", "b", 50, 5}})), 1000) == "b 50 55\na 100 105\n");
}

TEST_CASE("Rows that enter or leave at a time that goes back are left out") {
  const Profile profile = profile_of(
      "Name,Event Type,Timestamp (us)\na,Enter,100\na,Leave,150\na,Enter,20\na,Leave,30\na,Enter,200\na,Leave,210\n");
  CHECK(intervals_text(profile, 1000) == "a 100 150\na 200 210\n");
  CHECK(left_out_text(profile.left_out) == "2 rows whose time goes back, the first: line 4: a");
}

TEST_CASE("Of several recordings in one file the first is read, and the events of the others are counted") {
  const std::string one = json_of({{"X", "a", 0, 5}, {"X", "b", 10, 5}});
  const Profile json = profile_of(one + "\n" + json_of({{"X", "c", 3, 5}, {"X", "c", 8, 5}, {"X", "c", 18, 5}}));
  CHECK(intervals_text(json, 1000) == "a 0 5\nb 10 15\n");
  CHECK(left_out_text(json.left_out) == "3 events of another recording behind the first one");
  const std::string header = "name,ts,dur\n";
  const Profile csv = profile_of(header + "a,0,5000\n" + header + "b,0,5000\nc,9000,5000\n" + header + "d,1,1\n");
  CHECK(intervals_text(csv, 1000) == "a 0 5\n");
  CHECK(left_out_text(csv.left_out) == "3 rows of another recording behind the first one");
  CHECK_THAT(text(parse_profile(one + "x", "x").error_or({}).front()), Contains("is no JSON"));
}

TEST_CASE("An import is damaged if more than one interval in a hundred was merged, clipped or left out unasked") {
  const auto with = [](int steps, bool overlap) {
    std::vector<TraceEvent> events{{"X", "draw", 0, 10}};
    for (int i = 0; i < steps; ++i) events.push_back({"X", "step", 20 + 10 * i, 5});
    if (overlap) events.push_back({"X", "step", 22, 2});  // within the first one
    events.push_back({"X", "draw", 30 + 10 * steps, 10});
    return assigned_of(profile_of(json_of(events)));
  };
  CHECK(with(97, true).judged == 100);
  CHECK(with(97, true).lost == 1);
  CHECK_FALSE(with(97, true).damaged());
  CHECK(with(96, true).damaged());
  CHECK_FALSE(with(3, false).damaged());
}

TEST_CASE("What roles leave out, and what is cut off at the edges of a recording, is no damage") {
  const AssignedRoles assigned = assigned_of(profile_of(json_of(
      {{"X", "step", 0, 5}, {"X", "draw", 10, 10}, {"X", "other", 20, 5}, {"X", "step", 30, 5}, {"X", "draw", 40, 10}})));
  CHECK(left_out_text(assigned.left_out) ==
        "1 intervals of other names, the first: other; 1 steps and visualizations before the first segment; "
        "1 steps and visualizations of the last segment, which the file may cut off");
  CHECK(assigned.lost == 0);
}

TEST_CASE("A step of several kernels is merged as asked, and no damage") {
  const Profile profile = profile_of(json_of({{"X", "draw", 0, 10},
                                              {"X", "step a", 10, 5, "kernel", 1},
                                              {"X", "step b", 12, 5, "kernel", 2},
                                              {"X", "draw", 40, 10}}));
  Roles roles = draw_and_step();
  CHECK(assign_roles(profile, roles)->lost == 1);
  roles.step_begin = "step a";
  const AssignedRolesResult asked = assign_roles(profile, roles);
  CHECK(asked->merged == 1);
  CHECK(asked->lost == 0);
}
