#include "evenstep/recordings/roles.h"

#include "catch.h"
#include "evenstep/recordings/timing_csv.h"
#include "real_files.h"

using namespace evenstep;
using Catch::Contains;

namespace {

struct Made {
  const char* name;
  std::int64_t begin_ns, end_ns;
  const char* source = "";
};

Profile profile_of(const std::vector<Made>& all, const std::string& category = "", TrackOrder order = TrackOrder::any) {
  Profile profile;
  profile.file = "x.csv";
  const auto index = [](auto& list, auto value, auto same) {
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (same(list[i])) return static_cast<std::uint32_t>(i);
    }
    list.push_back(value);
    return static_cast<std::uint32_t>(list.size() - 1);
  };
  for (const Made& one : all) {
    const auto name =
        index(profile.names, ProfileName{one.name, category}, [&](const auto& n) { return n.text == one.name; });
    const auto source = index(profile.sources, std::string(one.source), [&](const auto& s) { return s == one.source; });
    if (source == profile.tracks.size()) profile.tracks.push_back({source, "", order});
    profile.intervals.push_back({{one.begin_ns}, {one.end_ns}, name, source});
  }
  return profile;
}

Roles roles_of(const std::string& visualization, const std::string& step, const std::string& segment = "") {
  Roles roles;
  roles.visualization = visualization;
  roles.step = step;
  roles.segment = segment;
  return roles;
}

/// The rows of timing.csv, without its header.
std::string rows_of(const Profile& profile, const Roles& roles) {
  const AssignedRolesResult assigned = assign_roles(profile, roles);
  if (!assigned) return text(assigned.error().front());
  const std::string csv = format_timing_csv(assigned->segments);
  return csv.substr(csv.find('\n') + 1);
}

}  // namespace

TEST_CASE("A role that matches no name is answered with the twelve names that are most frequent") {
  const std::vector<std::string> names{"a", "b", "c", "d", "e", "f", "g", "h", "i", "j", "k", "l", "m", "n", "o"};
  std::vector<Made> all;
  for (const std::string& name : names) all.push_back({name.c_str(), std::ssize(all) * 10, std::ssize(all) * 10 + 5});
  for (int i = 0; i < 3; ++i) all.push_back({"often", 1000 + i * 10, 1005 + i * 10});
  const AssignedRolesResult assigned = assign_roles(profile_of(all), roles_of("drawing", ""));
  REQUIRE_FALSE(assigned);
  const std::string said = text(assigned.error().front());
  CHECK_THAT(said, Contains("no name matches the visualization 'drawing'; there are 'often' (3), ") &&
                       Contains("and 4 more names"));
}

TEST_CASE("A segment goes from one visualization to the next, and the last one, which the file cuts off, is left out") {
  const Profile profile = profile_of({{"step", 5, 9},
                                      {"draw", 100, 130},
                                      {"step", 130, 150},
                                      {"step", 155, 190},
                                      {"draw", 200, 240},
                                      {"step", 240, 290},
                                      {"draw", 300, 310},
                                      {"step", 310, 320}});
  CHECK(rows_of(profile, roles_of("draw", "step")) ==
        "0,visualization,0,0,30\n0,step,0,30,50\n0,step,1,55,90\n0,idle,0,90,100\n"
        "1,visualization,0,100,140\n1,step,0,140,190\n1,idle,0,190,200\n");
  const AssignedRolesResult assigned = assign_roles(profile, roles_of("draw", "step"));
  REQUIRE(assigned);
  REQUIRE(assigned->left_out.size() == 2);
  CHECK(assigned->left_out[0].what == "steps and visualizations before the first segment");
  CHECK(assigned->left_out[0].count == 1);
  CHECK(assigned->left_out[1].count == 2);
  CHECK(assigned->became.at(0).role == "visualization");
  CHECK(assigned->became.at(0).count == 3);
}

TEST_CASE("Kernels that overlap on several streams are one step, of their union and not of their sum") {
  const Profile profile = profile_of({{"draw", 0, 10}, {"a", 10, 30}, {"b", 20, 40}, {"a", 40, 50}, {"draw", 60, 70}});
  CHECK(rows_of(profile, roles_of("draw", "a|b")) ==
        "0,visualization,0,0,10\n0,step,0,10,40\n0,step,1,40,50\n0,idle,0,50,60\n");
  CHECK(assign_roles(profile, roles_of("draw", "a|b"))->merged == 1);
}

TEST_CASE("Kernels that draw one picture are one visualization, a step between them makes two") {
  const Profile profile =
      profile_of({{"draw", 0, 10}, {"draw", 12, 20}, {"step", 20, 30}, {"draw", 40, 50}, {"draw", 50, 51}});
  CHECK(rows_of(profile, roles_of("draw", "step")) == "0,visualization,0,0,20\n0,step,0,20,30\n0,idle,0,30,40\n");
}

TEST_CASE("With a begin of a step, its parts are one step up to the next begin") {
  const Profile profile = profile_of(
      {{"draw", 0, 10}, {"force", 10, 12}, {"move", 13, 15}, {"force", 16, 18}, {"move", 18, 20}, {"draw", 30, 40}});
  Roles roles = roles_of("draw", "force|move");
  roles.step_begin = "force";
  CHECK(rows_of(profile, roles) == "0,visualization,0,0,10\n0,step,0,10,15\n0,step,1,16,20\n0,idle,0,20,30\n");
}

TEST_CASE("Segments that are ranges have an end, so the last one is kept, and what runs after it is left out") {
  const Profile profile =
      profile_of({{"cycle", 0, 98}, {"step", 10, 20}, {"cycle", 100, 195}, {"step", 110, 130}, {"step", 200, 210}});
  CHECK(rows_of(profile, roles_of("", "step", "cycle")) ==
        "0,step,0,0,10\n0,idle,0,10,100\n1,step,0,100,120\n1,idle,0,120,185\n");
}

TEST_CASE("Steps alone are one segment") {
  CHECK(rows_of(profile_of({{"a", 7, 9}, {"a", 10, 12}}), roles_of("", "a")) == "0,step,0,0,2\n0,step,1,3,5\n");
}

TEST_CASE("Pictures alone are a segment each, and get the steps that are given as far as these fit") {
  const Profile profile = profile_of({{"app", 0, 10}, {"app", 40, 50}, {"app", 60, 80}, {"app", 100, 110}});
  CHECK(rows_of(profile, roles_of("app", "")) ==
        "0,visualization,0,0,10\n0,idle,0,10,40\n1,visualization,0,40,50\n1,idle,0,50,60\n2,visualization,0,60,80\n"
        "2,idle,0,80,100\n");
  Roles roles = roles_of("app", "");
  roles.steps = 2;
  roles.step_time = {10};
  const AssignedRolesResult assigned = assign_roles(profile, roles);
  REQUIRE(assigned);
  CHECK(assigned->segments[0].steps.size() == 2);
  CHECK(assigned->segments[1].steps.size() == 1);
  CHECK(assigned->segments[2].steps.size() == 2);
  CHECK(assigned->left_out.back().what == "given steps that do not fit between two visualizations");
  CHECK(assigned->left_out.back().count == 1);
}

TEST_CASE("A picture that the GPU begins before the one before it is done begins when that is done") {
  Profile profile = profile_of({{"app", 0, 12}, {"app", 10, 25}, {"app", 15, 20}, {"app", 30, 40}});
  profile.only_visualizations = true;
  CHECK(rows_of(profile, roles_of("app", "")) == "0,visualization,0,0,12\n1,visualization,0,12,25\n1,idle,0,25,30\n");
  const AssignedRolesResult assigned = assign_roles(profile, roles_of("app", ""));
  REQUIRE(assigned);
  CHECK(assigned->cut == 1);
}

TEST_CASE("Given steps of more than 1e6 s are refused") {
  Roles roles = roles_of("app", "");
  roles.steps = 10'000;
  roles.step_time = {1'000'000'000'000'000};
  CHECK_THAT(rows_of(profile_of({{"app", 0, 10}, {"app", 40, 50}}), roles), Contains("longer than 1e6 s"));
}

TEST_CASE("A role that matches nothing is refused with the names there are, the most frequent first") {
  const Profile profile = profile_of({{"rare", 0, 1}, {"often", 1, 2}, {"often", 2, 3}});
  CHECK(rows_of(profile, roles_of("", "stepp")) ==
        "x.csv: error: no name matches the step 'stepp'; there are 'often' (2), 'rare' (1)");
  CHECK_THAT(rows_of(profile, Roles{}),
             Contains("which of its names are the steps?") && Contains("'often' (2), 'rare' (1)"));
  CHECK_THAT(rows_of(profile, roles_of("", "(")), Contains("'(' is no extended regular expression"));
}

TEST_CASE("A role whose intervals come from several processes asks which one, and names them") {
  const Profile profile =
      profile_of({{"step", 0, 1, "process 7"}, {"step", 1, 2, "process 8"}, {"step", 2, 3, "process 8"}});
  CHECK_THAT(rows_of(profile, roles_of("", "step")), Contains("--process REGEX: 'process 7' (1), 'process 8' (2)"));
  Roles roles = roles_of("", "step");
  roles.process = "8$";
  CHECK(rows_of(profile, roles) == "0,step,0,0,1\n0,step,1,1,2\n");
  roles.process = "9$";
  CHECK_THAT(rows_of(profile, roles), Contains("come from 2 processes, and '9$' matches 0 of them"));
}

TEST_CASE("Roles from different processes do not ask which one") {
  const Profile profile =
      profile_of({{"cycle", 0, 10, "host"}, {"step", 1, 2, "GPU"}, {"cycle", 10, 20, "host"}, {"step", 11, 12, "GPU"}});
  CHECK(rows_of(profile, roles_of("", "step", "cycle")) == "0,step,0,0,1\n0,idle,0,1,10\n1,step,0,10,11\n1,idle,0,11,19\n");
}

TEST_CASE("Names are listed with count, median length and period, those that count up are one") {
  const Profile profile = profile_of({{"Step#1", 0, 10}, {"Step#2", 20, 40}, {"Step#30", 40, 70}, {"a", 41, 42}});
  const std::vector<NameSummary> names = summarize(profile);
  REQUIRE(names.size() == 2);
  CHECK(names[0].text == "Step#N");
  CHECK(names[0].count == 3);
  CHECK(names[0].median.ns == 20);
  REQUIRE(names[0].period);
  CHECK(names[0].period->ns == 20);
  CHECK_FALSE(names[1].period);
}

TEST_CASE("Of kernels the longest one that recurs and is rare is guessed to be the visualization, the others steps") {
  std::vector<Made> all;
  for (std::int64_t i = 0; i < 100; ++i)
    all.push_back({i % 20 == 0 ? "reduce" : "advance", 10 * i, 10 * i + (i % 20 == 0 ? 9 : 5)});
  const AssignedRolesResult assigned = assign_roles(profile_of(all, "kernel"), {});
  REQUIRE(assigned);
  CHECK(assigned->guessed);
  CHECK(assigned->roles.visualization == "^reduce$");
  CHECK(assigned->segments.size() == 4);
  CHECK(assigned->segments[0].steps.size() == 19);
}

TEST_CASE("What is assigned reads back from timing.csv as it is: a thousand drawn recordings") {
  std::uint64_t state = 1;
  const auto up_to = [&](std::uint64_t most) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::int64_t>((state >> 33) % (most + 1));
  };
  for (int round = 0; round < 1000; ++round) {
    std::vector<Made> all;
    std::int64_t at = up_to(1000) - 500;
    for (std::int64_t i = 0; i < 5 + up_to(40); ++i) {
      constexpr const char* kNames[] = {"draw", "step", "step", "cycle", "other"};
      all.push_back({kNames[up_to(4)], at, at + up_to(30)});
      at += up_to(20);
    }
    const AssignedRolesResult assigned =
        assign_roles(profile_of(all), roles_of("draw", "step", up_to(1) == 0 ? "" : "cycle"));
    if (!assigned) continue;
    const std::string csv = format_timing_csv(assigned->segments);
    const TimingCsv read = parse_timing_csv(csv, "x.csv");
    INFO("round " << round << "\n" << csv << (read ? "" : text(read.error().front())));
    REQUIRE(read);
    REQUIRE(format_timing_csv(*read) == csv);
  }
}

TEST_CASE("Each preset takes the steps and the drawing of a file of its engine, and names where it has these names from") {
  struct Expected {
    const char *preset, *file;
    std::size_t segments, steps;  ///< steps of the first segment
    std::int64_t step_us, picture_us;
  };
  for (const Expected& one : {Expected{"unity", "unity.json", 6, 2, 1500, 9000},
                              {"godot", "godot.csv", 5, 2, 1900, 9200},
                              {"unreal", "unreal-insights.csv", 6, 1, 3000, 8000},
                              {"mujoco", "mujoco.json", 5, 5, 1200, 7500},
                              {"pytorch", "pytorch.json", 6, 5, 2000, 0},
                              {"isaac", "isaac.csv", 5, 4, 2400, 7000}}) {
    INFO(one.preset);
    const ProfileResult profile = read_profile(test::made_file(one.file));
    REQUIRE(profile);
    const AssignedRolesResult assigned = assign_roles(*profile, with_preset({}, one.preset));
    INFO((assigned ? "" : text(assigned.error().front())));
    REQUIRE(assigned);
    CHECK_FALSE(assigned->damaged());
    REQUIRE(assigned->segments.size() == one.segments);
    const SegmentTiming& first = assigned->segments.front();
    REQUIRE(first.steps.size() == one.steps);
    CHECK((first.steps.front().end - first.steps.front().begin).ns == one.step_us * 1000);
    REQUIRE(first.visualization.has_value() == (one.picture_us > 0));
    if (first.visualization) CHECK((first.visualization->end - first.visualization->begin).ns == one.picture_us * 1000);
  }
  REQUIRE(role_presets().size() == 6);
  for (const RolePreset& preset : role_presets()) CHECK(std::string(preset.source).size() > 20);
}

TEST_CASE("Roles that are given come before those of a preset, whose other roles are left out where no name matches") {
  const Profile profile = profile_of({{"mj_step", 0, 5}, {"paint", 10, 15}, {"mj_step", 20, 25}, {"paint", 30, 35}});
  CHECK(rows_of(profile, with_preset({}, "mujoco")) == "0,step,0,0,5\n0,step,1,20,25\n");
  Roles roles;
  roles.visualization = "paint";
  CHECK(with_preset(roles, "mujoco").step == "^mj_step$");
  CHECK(rows_of(profile, with_preset(roles, "mujoco")) == "0,visualization,0,0,5\n0,step,0,10,15\n0,idle,0,15,20\n");
  roles.visualization = "print";
  CHECK_THAT(rows_of(profile, with_preset(roles, "mujoco")), Contains("no name matches the visualization 'print'"));
  CHECK_THAT(rows_of(profile, with_preset({}, "godot")), Contains("no name matches the step '^Physics Step$'"));
}

TEST_CASE("What roles would take is marked in the list of names") {
  const Profile profile =
      profile_of({{"frame#1", 0, 9}, {"a", 1, 2}, {"b", 2, 3}, {"draw", 4, 5}, {"other", 6, 7}, {"frame#2", 9, 20}});
  Roles roles = roles_of("draw", "^a$|b|draw", "^frame");
  roles.step_begin = "^a$";
  const std::vector<NameSummary> names = summarize(profile);
  const RoleMarks marks = mark_roles(profile, roles, names);
  REQUIRE(marks);
  std::string all;
  for (std::size_t i = 0; i < names.size(); ++i) all += names[i].text + ": " + (*marks)[i] + "\n";
  CHECK(all == "frame#N: segment\na: begins a step\nb: step\ndraw: visualization\nother: \n");
  CHECK_FALSE(mark_roles(profile, roles_of("", "stepp"), names));
}
