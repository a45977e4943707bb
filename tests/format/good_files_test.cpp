#include <fmt/format.h>

#include <filesystem>

#include "catch.h"
#include "checked.h"
#include "evenstep/format/scenario.h"
#include "support.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

std::string with_study(const std::string& keys) { return kTissue + ("[study]\n" + keys + "\n"); }

}  // namespace

TEST_CASE("A spring scenario holds what its file says, and the defaults") {
  const Scenario s = good(kSpring);
  CHECK(s.name == "spring");
  CHECK(s.tags == std::vector<std::string>{"ci"});
  CHECK(s.run_duration.ns == 4'000'000'000);
  CHECK(s.warmup.ns == 8 * 33'333'333LL);
  CHECK(s.seed == 1);
  CHECK(s.strategies.size() == 4);
  CHECK(s.live == StrategyKind::phase_locked);
  CHECK(s.timing.programmed.segment == Rate{30, 1});
  CHECK(s.timing.programmed.visualization.ns == 11'100'000);
  CHECK(s.timing.programmed.steps == std::vector<int>{15});
  CHECK_FALSE(s.timing.programmed.step);
  CHECK(s.solver == SolverKind::cpu_double);
  CHECK(std::get<SpringScene>(s.scene.body).stiffness_N_per_m == 200);
  CHECK(s.scene.step_rate == Rate{450, 1});
  CHECK(s.scene.tool_count == 1);
  CHECK_FALSE(s.scene.needs_energy);
  CHECK(s.nominal.segment.ns == 33'333'333);
  CHECK(s.nominal.slot.ns == 2'222'222);
  CHECK(s.nominal.step_run_time.ns == 1'482'222);  // (1/30 s - 11.1 ms) / 15 = 1.48222… ms
  REQUIRE(s.devices.size() == 1);
  CHECK(s.devices[0].rate == Rate{1000, 1});
  CHECK(s.devices[0].limits.max_N == 100);
  CHECK(s.devices[0].limits.max_slew_N_per_s == 1e6);
  const auto& motion = std::get<ConstantVelocity>(s.devices[0].motion.shape);
  CHECK(motion.velocity_m_per_s.x == 0.1);
  CHECK(motion.smooth_start.ns == 200'000'000);
  CHECK(s.remap.estimate_weight == 0.1);
  CHECK(s.remap.bandwidth_Hz == 2);
  CHECK(s.remap.jump == 0.07);
  CHECK(s.remap.latency.kind == Budget::Kind::any_phase);
  CHECK(s.remap.lead.kind == Budget::Kind::any_phase);
  CHECK(s.remap.interaction_underrun == InteractionUnderrun::clamp);
  CHECK(s.remap.force_underrun == ForceUnderrun::hold);
  CHECK(s.keep_rows);
  REQUIRE(s.expectations.size() == 1);
  CHECK(s.expectations[0].min->number == 4);
  CHECK(s.expectations[0].min->unit == "step");
  CHECK_FALSE(s.expectations[0].max);
  CHECK(s.expectations[0].place.line == 18);
  check_round_trip(s);
}

TEST_CASE("A tissue scenario with two devices holds what its file says") {
  const Scenario s = good(kTissue);
  CHECK(s.solver == SolverKind::opencl);
  const auto& tissue = std::get<TissueScene>(s.scene.body);
  CHECK(tissue.lattice == std::array<int, 3>{9, 9, 10});
  CHECK(tissue.particle_count == 800);
  CHECK(tissue.damping_per_s == 1e-3 / 1.25e-4);
  REQUIRE(tissue.tools.size() == 2);
  CHECK(tissue.tools[1].center_m.y == 0);
  CHECK(tissue.tools[0].radius_m == 6e-3);
  CHECK(s.timing.programmed.visualization_variation == 0.1);
  CHECK(s.timing.programmed.step_variation == 0.025);
  CHECK(s.timing.programmed.steps == std::vector<int>{14, 15, 16});
  CHECK(s.scene.step_rate == Rate{450, 1});
  CHECK(s.scene.tool_count == 2);
  CHECK(s.scene.needs_energy);
  CHECK(s.devices[1].queue == QueuePolicy::libusb);
  CHECK(s.devices[1].phase.ns == 500'000);
  CHECK(s.devices[1].emission == Emission::hold);
  CHECK(std::get<Sine>(s.devices[1].motion.shape).frequency == Rate{1, 3});
  CHECK(std::get<RampStop>(s.devices[0].motion.shape).stop.ns == 500'000'000);
  CHECK(s.remap.latency.kind == Budget::Kind::fixed);
  CHECK(s.remap.latency.fixed.ns == 66'666'666);
  REQUIRE(s.expect_stop);
  CHECK(s.expect_stop->reason == "diverged");
  CHECK(*s.expect_stop->at_most_step == 100);
  check_round_trip(s);
}

TEST_CASE("A PID device has the pool and the faults that its file names and a run the signal and the stop") {
  const Scenario s = good(kPid);
  CHECK(s.interrupt->ns == 3'000'000'000);
  const auto& pid = std::get<PidSpec>(s.devices.at(0).driver);
  CHECK(pid.pool_effects == 3);
  CHECK(pid.block_load_error_at == 1);  // the second request
  CHECK(pid.flavour == PidFlavour::array);
  CHECK(pid.board == BoardKind::openffboard_2);
  CHECK(pid.options.reversed_force == std::array{true, false, false});
  CHECK((pid.options.reversed_spring[0] == false && pid.options.reversed_spring[1] == true));
  CHECK_FALSE(pid.options.reversed_spring[2]);
  CHECK(pid.options.effect_duration->ns == 2'000'000'000);
  const std::vector<ReportFault>& faults = s.devices[0].faults;
  REQUIRE(faults.size() == 4);
  CHECK((faults[0].kind == ReportFault::Kind::write_lost && faults[0].tick == 500 && faults[0].amount == 7));
  for (int i = 1; i < 4; ++i) CHECK((faults[i].kind == ReportFault::Kind::unread && faults[i].tick == 1000 + i));
  REQUIRE(s.expect_stop);
  CHECK(s.expect_stop->reason == "interrupted");
  CHECK(s.expect_stop->message == "at 3 s");
  CHECK(*s.expect_stop->at_least_step == 1300);
  CHECK(*s.expect_stop->at_most_step == 1400);
  check_round_trip(s);

  const Scenario plain = good(kSpring);
  CHECK_FALSE(plain.interrupt);
  std::string text = kPid;
  const std::string keys = "pool = 3\nblock_load_error = 2\n";
  text.replace(text.find(keys), keys.size(), "");
  const Scenario whole = good(text);
  CHECK(std::get<PidSpec>(whole.devices[0].driver).pool_effects == 40);
  CHECK(std::get<PidSpec>(whole.devices[0].driver).block_load_error_at == -1);  // never
}

TEST_CASE("A tissue has the materials, faces, method and couplings that its file names") {
  std::string text = kTissue;
  text.replace(text.find("damping = \"1 mN s/m\""), 0, R"(axial_damping = "0.01 N s/m"
gravity = ["0 m/s2", "2 mm/s2", "-9.81 m/s2"]
fixed = ["left", "back", "top"]
regions = [
  { min = ["0 m", "0 m", "20 mm"], max = ["40 mm", "40 mm", "30 mm"], stiffness = "5 kN/m" },
  { min = ["20 mm", "0 m", "0 m"], max = ["20 mm", "40 mm", "45 mm"], mass = "1 g" },
]
method = "vertex-block-descent"
iterations = 7
local_model = "settled"
)");
  text.replace(text.find("radius = \"6 mm\""), 15,
               "radius = \"6 mm\", coupling = \"spring\", stiffness = \"200 N/m\", damping = \"3 mN s/m\"");
  text.replace(text.rfind("radius = \"6 mm\""), 15, "radius = \"7 mm\", coupling = \"probe\", stiffness = \"2 kN/m\"");
  const Scenario s = good(text);
  const auto& tissue = std::get<TissueScene>(s.scene.body);
  CHECK(tissue.damping_per_s == 1e-3 / 1.25e-4);
  CHECK(tissue.axial_damping_N_s_per_m == 0.01);
  CHECK(tissue.gravity_m_per_s2 == glm::dvec3(0, 2e-3, -9.81));
  CHECK(tissue.fixed.x_min);
  CHECK(tissue.fixed.y_max);
  CHECK(tissue.fixed.z_max);
  CHECK_FALSE((tissue.fixed.x_max || tissue.fixed.y_min || tissue.fixed.z_min));
  REQUIRE(tissue.regions.size() == 2);
  CHECK(tissue.regions[0].min_m == glm::dvec3(0, 0, 0.02));
  CHECK(tissue.regions[0].max_m == glm::dvec3(0.04, 0.04, 0.03));
  CHECK(tissue.regions[0].stiffness_N_per_m == 5000);
  CHECK(tissue.regions[0].particle_mass_kg == 1.25e-4);  // as outside
  CHECK(tissue.regions[1].stiffness_N_per_m == 50);      // as outside
  CHECK(tissue.regions[1].particle_mass_kg == 1e-3);
  CHECK(tissue.method == Method::vertex_block_descent);
  CHECK(tissue.iterations == 7);
  CHECK(s.scene.local_model == LocalModel::settled);
  REQUIRE(tissue.tools.size() == 2);
  CHECK(tissue.tools[0].kind == CouplingKind::spring);
  CHECK(tissue.tools[0].stiffness_N_per_m == 200);
  CHECK(tissue.tools[0].damping_N_s_per_m == 3e-3);
  CHECK(tissue.tools[1].kind == CouplingKind::probe);
  CHECK(tissue.tools[1].stiffness_N_per_m == 2000);
  CHECK(tissue.tools[1].damping_N_s_per_m == 0);
  check_round_trip(s);
}

TEST_CASE("A study has the steps, methods and solvers that its file names, the coarsest step first, or all there are") {
  const Scenario plain = good(kTissue);
  CHECK(plain.study.error == StudyError::felt_force);
  CHECK(plain.study.duration == plain.run_duration - plain.warmup);
  CHECK(plain.study.methods == std::vector<Method>{Method::symplectic_euler, Method::rk4, Method::implicit_euler});
  CHECK(plain.study.solvers == std::vector<SolverKind>{SolverKind::cpu_float});
  CHECK(plain.study.steps.empty());
  CHECK(plain.study.iterations.empty());
  CHECK(plain.study.repeats == 5);
  const Scenario state = good(with_study("error = \"state\""));
  CHECK(state.study.duration.ns == 64'000'000);
  CHECK(state.study.methods == std::vector<Method>(kAllMethods.begin(), kAllMethods.end()));
  const Scenario s = good(with_study(R"(error = "state"
duration = "3 segments"
methods = ["rk4", "vertex-block-descent"]
solvers = ["opencl", "cpu-double"]
step_sizes = ["900 Hz", "450 Hz", "150 Hz", "225 Hz"]
iterations = [3, 30]
repeats = 7)"));
  CHECK(s.study.duration.ns == 99'999'999);
  CHECK(s.study.methods == std::vector<Method>{Method::rk4, Method::vertex_block_descent});
  CHECK(s.study.solvers == std::vector<SolverKind>{SolverKind::opencl, SolverKind::cpu_double});
  REQUIRE(s.study.steps.size() == 4);
  const int expected[][2] = {{1, 3}, {1, 2}, {1, 1}, {2, 1}};  // substeps, steps of 1/450 s
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(s.study.steps[i].substeps == expected[i][0]);
    CHECK(s.study.steps[i].steps == expected[i][1]);
  }
  CHECK(s.study.iterations == std::vector<int>{3, 30});
  CHECK(s.study.repeats == 7);
  check_round_trip(s);
}

TEST_CASE("Every method, face and local model is read as the one it names") {
  const auto tissue_with = [](const std::string& set) {
    return std::get<TissueScene>(good(kTissue, {{set}, {}}).scene.body);
  };
  for (const Method method : kAllMethods) {
    INFO(name_of(method));
    CHECK(tissue_with(std::string("scene.method=") + name_of(method)).method == method);
  }
  bool FixedFaces::*const faces[] = {&FixedFaces::x_min, &FixedFaces::x_max, &FixedFaces::y_min,
                                     &FixedFaces::y_max, &FixedFaces::z_min, &FixedFaces::z_max};
  const char* const names[] = {"left", "right", "front", "back", "bottom", "top"};
  for (std::size_t i = 0; i < 6; ++i) {
    const FixedFaces fixed = tissue_with(std::string("scene.fixed=") + names[i]).fixed;
    for (std::size_t j = 0; j < 6; ++j) CHECK(fixed.*faces[j] == (i == j));
  }
  CHECK_FALSE(tissue_with("scene.fixed=none").fixed.any());
  const auto model = [](const std::string& name) {
    return good(kTissue, {{"scene.local_model=" + name}, {}}).scene.local_model;
  };
  CHECK(model("none") == LocalModel::none);
  CHECK(model("instantaneous") == LocalModel::instantaneous);
  CHECK(model("settled") == LocalModel::settled);
}

TEST_CASE("What a device renders is read with its defaults, and asks the scene for its stiffness") {
  const auto rendered = [](const std::string& base, const std::string& keys) {
    return good(base, {{"device.left.render={ " + keys + " }"}, {}});
  };
  const Scenario plain = good(kSpring, {});
  CHECK(std::holds_alternative<ForceRender>(plain.devices[0].render));
  CHECK(plain.scene.local_model == LocalModel::none);
  const Scenario local = rendered(kSpring, "kind = \"local\", emission = \"hold\"");
  CHECK_FALSE(std::get<LocalRender>(local.devices[0].render).by_device);
  CHECK(local.devices[0].emission == Emission::hold);
  CHECK(std::get<LocalRender>(local.devices[0].render).alpha == 1.0);
  CHECK(std::get<LocalRender>(local.devices[0].render).knows_gap);
  CHECK(local.scene.local_model == LocalModel::instantaneous);
  const Scenario all = rendered(kSpring, "kind = \"local\", alpha = \"auto\", stiffness = \"settled\", gap = false");
  CHECK_FALSE(std::get<LocalRender>(all.devices[0].render).alpha);
  CHECK_FALSE(std::get<LocalRender>(all.devices[0].render).knows_gap);
  CHECK(all.scene.local_model == LocalModel::settled);
  CHECK(std::get<LocalRender>(rendered(kSpring, "kind = \"local\", alpha = 2").devices[0].render).alpha == 2.0);
  using Cap = LocalRender::Cap::Kind;
  CHECK(std::get<LocalRender>(local.devices[0].render).cap.kind == Cap::none);
  const LocalRender::Cap fixed =
      std::get<LocalRender>(rendered(kSpring, "kind = \"local\", cap = \"1.5 kN/m\"").devices[0].render).cap;
  CHECK(fixed.kind == Cap::fixed);
  CHECK(fixed.fixed_N_per_m == 1500);
  const std::string device = "device.left.driver=\"pid\"",
                    travel = "travel = [\"400 mm\", \"400 mm\", \"0 mm\"], full_scale = \"100 N\"";
  const auto sprung = [&](const std::string& pid, const std::string& kind) {
    return good(kSpring,
                {{device, "device.left.pid={ " + travel + pid + " }", "device.left.render={ kind = \"" + kind + "\" }"}, {}})
        .devices[0];
  };
  const auto sprung_pid = [&](const std::string& pid, const std::string& kind) {
    return std::get<PidSpec>(sprung(pid, kind).driver);
  };
  const std::string x = ", springs = [\"x\"]";
  CHECK(std::get<LocalRender>(sprung(x, "device_spring").render).by_device);
  CHECK(sprung_pid(x, "device_spring").options.springs);
  CHECK_FALSE(sprung_pid(", effect_duration = \"none\"", "local").options.effect_duration);
  CHECK_FALSE(sprung_pid("", "local").options.springs);
  CHECK_FALSE(sprung_pid(x, "device_spring").options.full_slope_N_per_m);
  CHECK(sprung_pid(x + ", full_slope = \"750 N/m\"", "device_spring").options.full_slope_N_per_m == glm::dvec3(750));
  CHECK(period_s(sprung_pid(x, "device_spring").firmware_rate) == 1 / 4000.0);
  CHECK(period_s(sprung_pid(x + ", firmware_rate = \"8 kHz\"", "device_spring").firmware_rate) == 1 / 8000.0);
  const Scenario smith =
      rendered(kSpring, "kind = \"smith\", frequency = \"7 Hz\", damping_ratio = 0.2, static_stiffness = \"300 N/m\"");
  const SmithRender& model = std::get<SmithRender>(smith.devices[0].render);
  CHECK(model.mode.frequency_Hz == 7.0);
  CHECK(model.mode.damping_ratio == 0.2);
  CHECK(model.mode.static_N_per_m == 300.0);
  CHECK(model.factor == 1.1);
  CHECK(smith.scene.local_model == LocalModel::none);
}

TEST_CASE("A recorded motion reads its rows, rounded to the nanosecond, also after a byte order mark") {
  const TemporaryFolder folder;
  folder.write("hand.csv", "\xEF\xBB\xBFt_s,x_m,y_m,z_m\n0,0,0,0\n0.0333333333333,1e-3,-2e-3,0.5\n");
  std::string text = kSpring;
  text.replace(text.find("motion = "), text.find("[[expect]]") - text.find("motion = "),
               "motion = { kind = \"recorded\", file = \"hand.csv\" }\n");
  const ReadResult result = read_scenario(folder.write("s.toml", text));
  INFO(errors_of(result));
  REQUIRE(result);
  const auto& rows = std::get<RecordedMotion>(result->devices[0].motion.shape).rows;
  REQUIRE(rows.size() == 2);
  CHECK(rows[1].first.ns == 33'333'333);
  CHECK(rows[1].second.y == -2e-3);
  check_round_trip(*result);
}

TEST_CASE("A hand reads its plant, its arm, its path and what it starts with") {
  std::string text = kSpring;
  text.replace(text.find("warmup"), 21, "strategies = [\"direct\"]");
  text.replace(
      text.find("motion = "), text.find("[[expect]]") - text.find("motion = "),
      "delay = \"1 ms\"\n[device.motion]\nkind = \"hand\"\nmass = \"200 g\"\ndamping = \"1 N s/m\"\nstiffness = \"2 N/m\"\n"
      "arm = { mass = \"0.554 kg\", damping = \"6.45 N s/m\", stiffness = \"135 N/m\" }\npush = [\"-1 N\", \"0 N\", \"2 "
      "mN\"]\n"
      "offset = [\"5 mm\", \"0 mm\", \"0 mm\"]\nvelocity = [\"0 m/s\", \"1 cm/s\", \"0 m/s\"]\n"
      "path = { kind = \"minimum-jerk\", delay = \"1 segment\", moves = [\n"
      "  { to = [\"10 mm\", \"0 mm\", \"0 mm\"], duration = \"0.4 s\", rest = \"1 s\" },\n"
      "  { to = [\"0 mm\", \"0 mm\", \"3 mm\"], duration = \"12 ms\" }] }\n");
  text.replace(text.find("left.interaction.direct"), 23, "closed_loop.left.direct");
  text.replace(text.find("velocity_jump"), 13, "energy_min");
  text.replace(text.find("min = \"4 step\""), 14, "min = \"-1 mJ\"");
  const Scenario s = good(text);
  const DeviceSpec& device = s.devices[0];
  REQUIRE(device.hand);
  CHECK(device.force_delay.ns == 1'000'000);
  CHECK(device.hand->mass_kg == 0.2);
  CHECK(device.hand->damping_N_s_per_m == 1);
  CHECK(device.hand->total_mass_kg() == 0.2 + 0.554);
  CHECK(device.hand->total_damping_N_s_per_m() == 1 + 6.45);
  CHECK(device.hand->total_stiffness_N_per_m() == 2 + 135);
  CHECK(device.hand->push_N == glm::dvec3(-1, 0, 2e-3));
  CHECK(device.hand->offset_m == glm::dvec3(5e-3, 0, 0));
  CHECK(device.hand->velocity_m_per_s == glm::dvec3(0, 0.01, 0));
  const auto& path = std::get<MinimumJerk>(device.motion.shape);
  REQUIRE(path.moves.size() == 2);
  CHECK(path.moves[0].rest.ns == 1'000'000'000);
  CHECK(path.moves[1].to_m == glm::dvec3(0, 0, 3e-3));
  CHECK(path.moves[1].duration.ns == 12'000'000);
  CHECK(device.motion.begin.ns == 33'333'333);
  CHECK_FALSE(s.scene.needs_energy);  // the energy at the port is not that of the tissue
  check_round_trip(s);
}

TEST_CASE("A wall and a mode read what they are") {
  const auto with = [](const std::string& scene) {
    std::string text = kSpring;
    text.replace(text.find("kind = \"spring\""), 37, scene);
    return good(text).scene.body;
  };
  const auto wall = std::get<WallScene>(
      with("kind = \"wall\"\nstiffness = \"2 N/mm\"\nnormal = [0, -1, 0.5]\nsurface = \"-3 mm\"\nhardening = \"5 mm\""));
  CHECK(wall.stiffness_N_per_m == 2000);
  CHECK(wall.normal == glm::dvec3(0, -1, 0.5));
  CHECK(wall.surface_m == -3e-3);
  CHECK(wall.hardening_m == 5e-3);
  const auto plain = std::get<WallScene>(with("kind = \"wall\""));
  CHECK(plain.stiffness_N_per_m == 200);
  CHECK(plain.hardening_m == 0);
  const auto mode =
      std::get<ModeScene>(with("kind = \"mode\"\nfrequency = \"30 Hz\"\none_sided = true\nsurface = \"1 mm\""));
  CHECK(mode.frequency_Hz == 30);
  CHECK(mode.damping_ratio == 0.1);
  CHECK(mode.one_sided);
  CHECK(mode.surface_m == 1e-3);
}

TEST_CASE("A stick-slip motion reads its times, also in units of the timing, and begins after its delay") {
  std::string text = kSpring;
  text.replace(text.find("motion = "), text.find("[[expect]]") - text.find("motion = "),
               "motion = { kind = \"stick-slip\", velocity = [\"0.1 m/s\", \"0 m/s\", \"-20 mm/s\"], "
               "stick = \"2 segments\", slip = \"12.5 ms\", delay = \"1 s\" }\n");
  // Without a nominal speed, limits cannot be counted in steps.
  text.replace(text.find("min = \"4 step\""), 14, "min = \"1 mm\"");
  const Scenario s = good(text);
  const auto& motion = std::get<StickSlip>(s.devices[0].motion.shape);
  CHECK(motion.velocity_m_per_s == glm::dvec3(0.1, 0, -0.02));
  CHECK(motion.stick.ns == 66'666'666);
  CHECK(motion.slip.ns == 12'500'000);
  CHECK(s.devices[0].motion.begin.ns == 1'000'000'000);
  check_round_trip(s);
}

TEST_CASE("A motion back and forth reads its times, and a device what it expects of saturation") {
  std::string text = kSpring;
  text.replace(text.find("motion = "), text.find("[[expect]]") - text.find("motion = "),
               "saturation = \"expected\"\n"
               "motion = { kind = \"back-and-forth\", velocity = [\"0.1 m/s\", \"0 m/s\", \"-20 mm/s\"], "
               "straight = \"30 segments\", turn = \"0.2 s\", start = \"smooth 0.1 s\", delay = \"1 s\" }\n");
  const Scenario s = good(text);  // and its expectation in steps: it has a nominal speed
  const auto& motion = std::get<BackAndForth>(s.devices[0].motion.shape);
  CHECK(motion.start.velocity_m_per_s == glm::dvec3(0.1, 0, -0.02));
  CHECK(motion.start.smooth_start.ns == 100'000'000);
  CHECK(motion.straight.ns == 999'999'990);  // the unit is a whole number of ns
  CHECK(motion.turn.ns == 200'000'000);
  CHECK(s.devices[0].motion.begin.ns == 1'000'000'000);
  CHECK(s.devices[0].expects_saturation);
  CHECK_FALSE(good(kSpring).devices[0].expects_saturation);
  check_round_trip(s);
}

TEST_CASE("Every scenario that is shipped reads and its resolved form is the same scenario") {
  const std::filesystem::path scenarios = std::filesystem::path(EVENSTEP_SOURCE_DIR) / "scenarios";
  std::size_t read = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(scenarios)) {
    if (entry.path().extension() != ".toml") continue;
    INFO(entry.path());
    const ReadResult result = read_scenario(entry.path().string());
    INFO(errors_of(result));
    REQUIRE(result);
    check_round_trip(*result);
    ++read;
  }
  CHECK(read >= 100);
}

TEST_CASE("An adaptive latency is read as it is written, starts at its least, and comes back from the resolved file") {
  const std::string plain = "[remap]\nlatency = \"adaptive\"\n";
  const auto read = [](const std::string& remap) {
    std::string text = kSpring;
    text.replace(text.find("[[expect]]"), 0, remap + "\n");
    ReadResult result = read_text(text);
    INFO(errors_of(result));
    REQUIRE(result);
    const ReadResult again = read_text(result->resolved_toml);
    INFO(errors_of(again));
    REQUIRE(again);
    CHECK(describe(*again) == describe(*result));
    return *result;
  };
  const Scenario defaults = read(plain);
  CHECK(defaults.remap.latency.kind == Budget::Kind::adaptive);
  CHECK(defaults.remap.latency.fixed == Duration{100'000'000});
  CHECK(defaults.remap.adapt.start == Duration{0});
  CHECK(defaults.remap.adapt.window == Duration{10'000'000'000});
  CHECK(defaults.remap.adapt.slew_ppm == 5'000);
  const Scenario given = read(plain +
                              "adapt = { start = \"20 ms\", min = \"12.842223 ms\", max = \"40 ms\", window = \"90 "
                              "segments\", slew = \"0.0123 %\", margin = \"2 slots\" }");
  CHECK(given.remap.adapt.start == Duration{20'000'000});
  CHECK(given.remap.adapt.least == Duration{12'842'223});
  CHECK(given.remap.adapt.most == Duration{40'000'000});
  CHECK(given.remap.adapt.window == given.nominal.segment * 90);
  CHECK(given.remap.adapt.slew_ppm == 123);
  CHECK(given.remap.adapt.margin == Duration{4'444'444});
  CHECK(read(plain + "adapt = { min = \"7 ms\" }").remap.adapt.start == Duration{7'000'000});
  // Values that nobody uses need not fit together. So --set remap.latency=minimal can be compared with the file as it is.
  CHECK(read("[remap]\nadapt = { min = \"7 ms\", max = \"5 ms\" }").remap.latency.kind == Budget::Kind::any_phase);
}

TEST_CASE("Filters, policies and long runs are read as they are written") {
  const auto read = [](const std::string& remap, const std::string& run = "") {
    std::string text = kSpring;
    text.replace(text.find("[run]"), 5, "[run]\n" + run);
    text.replace(text.find("[[expect]]"), 0, remap + "\n");
    ReadResult result = read_text(text);
    INFO(errors_of(result));
    REQUIRE(result);
    return *result;
  };
  const Scenario butterworth = read("[remap.filter]\ncutoff = \"7.5 Hz\"\non = \"interaction\"");
  CHECK(std::get<ButterworthSpec>(butterworth.remap.filter).cutoff_Hz == 7.5);
  CHECK_FALSE(butterworth.remap.filter_force);
  const Scenario euro =
      read("[remap.filter]\nkind = \"one-euro\"\nmin_cutoff = \"2 Hz\"\nbeta = 3\nderivative_cutoff = \"4 Hz\"");
  CHECK(std::get<OneEuroSpec>(euro.remap.filter).min_cutoff_Hz == 2);
  CHECK(std::get<OneEuroSpec>(euro.remap.filter).beta == 3);
  CHECK(std::get<OneEuroSpec>(euro.remap.filter).derivative_cutoff_Hz == 4);
  // A window is counted in samples of the signal that it averages: one segment is 33 ticks or 15 steps.
  const Scenario average = read("[remap.filter]\nkind = \"moving-average\"");
  CHECK(std::get<MovingAverageSpec>(filter_at(average.remap, {1000, 1})).samples == 33);
  CHECK(std::get<MovingAverageSpec>(filter_at(average.remap, {450, 1})).samples == 15);
  CHECK(std::get<MovingAverageSpec>(filter_at(average.remap, {1, 1})).samples == 1);
  const Scenario gate =
      read("[remap]\nunderrun = { interaction = \"gate\", force = \"extrapolate\" }", "keep = \"summary\"\n");
  CHECK(gate.remap.interaction_underrun == InteractionUnderrun::gate);
  CHECK(gate.remap.force_underrun == ForceUnderrun::extrapolate);
  CHECK_FALSE(gate.keep_rows);
}

TEST_CASE("Ages of reports are read exactly, and where they are given a sample's time is when it was taken") {
  const auto with = [](const std::string& keys) {
    return good(changed(kSpring, "name = \"left\"", "name = \"left\"\n" + keys));
  };
  const DeviceSpec plain = good(kSpring).devices.at(0);
  CHECK_FALSE((plain.age.is_given() || follows_clock(plain)));
  CHECK(largest_age(plain).ns == 0);

  const DeviceSpec aged =
      with("report_age = \"0.3 ms\"\nreport_age_jitter = \"1.2 ms\"\nclock_rate_error = \"-50 ppm\"").devices.at(0);
  CHECK((aged.age.least.ns == 300'000 && aged.age.jitter.ns == 1'200'000 && aged.age.clock_ppm == -50));
  CHECK(follows_clock(aged));
  // Plus the wait for a tick, the period that a slower clock may seem to be behind, and a stamp.
  CHECK(largest_age(aged).ns == 300'000 + 1'200'000 + 2 * 1'000'051 - 1 + 999);
  const DeviceSpec faster = with("report_age_jitter = \"1.2 ms\"\nclock_rate_error = \"50 ppm\"").devices.at(0);
  CHECK(largest_age(faster).ns == 1'200'000 + 999'999 + 999);
  for (const char* const keys : {"report_age_jitter = \"2.5 ms\"", "clock_rate_error = \"-1000 ppm\""})
    CHECK(largest_age(with(std::string(keys) + "\nsample_time = \"arrival\"").devices.at(0)).ns == 0);
  CHECK_FALSE(follows_clock(with("report_age = \"1 ms\"\nsample_time = \"arrival\"").devices.at(0)));
  CHECK(follows_clock(with("sample_time = \"taken\"").devices.at(0)));

  // On one clock, reports that are 0.9 ms to 1.1 ms old wait for the first tick or the second, so the age varies by a
  // period.
  const DeviceSpec one_clock = with("report_age = \"0.9 ms\"\nreport_age_jitter = \"0.2 ms\"").devices.at(0);
  CHECK(largest_age(one_clock).ns == 900'000 + 1'000'000 + 999);
  DeviceSpec real = plain;
  real.is_real = true;
  CHECK((follows_clock(real) && largest_age(real).ns == 999'999 + 999));

  // Events come only for changes. So an unchanged position is as old as two periods, or as the interval that is given.
  const std::string evdev = "driver = \"evdev\"\nevdev = { travel = [\"1 m\", \"0 m\", \"0 m\"]";
  const DeviceSpec arrival = with(evdev + " }").devices.at(0);
  CHECK_FALSE((follows_clock(arrival) || unchanged_age_of(arrival)));
  const DeviceSpec taken = with(evdev + " }\nsample_time = \"taken\"").devices.at(0);
  CHECK((follows_clock(taken) && unchanged_age_of(taken)->ns == 2'000'000 && largest_age(taken).ns == 2'000'000));
  DeviceSpec wheel = with(evdev + ", report_interval = \"8 ms\" }\nreport_age_jitter = \"1 ms\"").devices.at(0);
  CHECK((unchanged_age_of(wheel)->ns == 9'000'000 && largest_age(wheel).ns == 9'000'000));
  wheel.is_real = true;
  CHECK(largest_age(wheel).ns == 9'000'000);
  const DeviceSpec fast = with(evdev + ", report_interval = \"0.1 ms\" }\nreport_age = \"0.9 ms\"").devices.at(0);
  CHECK((unchanged_age_of(fast)->ns == 1'000'000 && largest_age(fast).ns == 1'000'000 + 999));
}
