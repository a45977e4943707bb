
#include "catch.h"
#include "checked.h"
#include "evenstep/format/scenario.h"
#include "support.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

struct Mistake {
  const char* from;
  const char* to;
  const char* error;  ///< with its place: "scenario.toml:10:17: error: …"
};

void check_each(const char* base, const std::vector<Mistake>& mistakes) {
  for (const Mistake& mistake : mistakes) {
    INFO(mistake.from << " -> " << mistake.to);
    const ReadResult result = read_text(changed(base, mistake.from, mistake.to));
    CHECK_FALSE(result);
    CHECK_THAT(errors_of(result), Contains(mistake.error));
  }
}

}  // namespace

TEST_CASE("A key, a word or a form that does not exist is named where it stands, with what was meant") {
  check_each(
      kSpring,
      {
          {"steps = 15", "vsi = 15",
           "scenario.toml:11:1: error: unknown key 'vsi' in [timing]; did you mean 'visualization'?"},
          {"steps = 15", "steps = 15\nqqq = 1",
           "scenario.toml:12:1: error: unknown key 'qqq' in [timing]; known: segment, visualization"},
          {"steps = 15", "", "scenario.toml:8:1: error: [timing] has no 'steps'; write steps = 15"},
          {"[timing]", "[tming]",
           "scenario.toml:8:2: error: unknown key 'tming' in the top of the file; did you mean 'timing'?"},
          {"kind = \"spring\"", "kind = \"sprang\"",
           "scenario.toml:13:8: error: 'kind': \"sprang\" must be \"spring\", \"wall\", \"mode\", \"tissue\" or "
           "\"foreign\"; did "
           "you mean 'spring'?"},
          {"kind = \"spring\"", "", "[scene] has no 'kind'; write kind = \"spring\""},
          {"stiffness = \"200 N/m\"", "lattice = [1, 1, 1]",
           "scenario.toml:14:1: error: 'lattice' means nothing with kind = \"spring\"; remove it, or write kind = "
           "\"tissue\""},
          {"kind = \"constant-velocity\"", "kind = \"still\"",
           "'velocity' means nothing with kind = \"still\"; remove it, or write kind = \"constant-velocity\" or "
           "\"back-and-forth\" or \"ramp-stop\" or \"stick-slip\""},
          {"kind = \"constant-velocity\"", "kind = \"back-and-forth\", turn = \"0.1 s\"",
           "device.motion has no 'straight'; write straight = \"4 s\""},
          {"kind = \"constant-velocity\"", "kind = \"back-and-forth\", straight = \"1 s\"",
           "device.motion has no 'turn'; write turn = \"0.2 s\""},
          {"kind = \"constant-velocity\"", "kind = \"back-and-forth\", straight = \"1 s\", turn = \"0 s\"",
           "'turn': \"0 s\" is out of range; it must be above 0 s"},
          {"kind = \"constant-velocity\"", "kind = \"back-and-forth\", straight = \"0 s\", turn = \"1 s\"",
           "'straight': \"0 s\" is out of range; it must be above 0 s"},
          {"motion = ", "driver = \"evdev\"\nmotion = ",
           "[[device]] has no 'evdev'; write evdev = { travel = [\"200 mm\", \"200 mm\", \"0 mm\"] }"},
          {"motion = ", "driver = \"inverse3\"\nmotion = ",
           "[[device]] has no 'inverse3'; write inverse3 = { origin = [\"0 mm\", \"-120 mm\", \"150 mm\"] }"},
          {"motion = ", "saturation = \"fine\"\nmotion = ", "'saturation': \"fine\" must be \"error\" or \"expected\""},
          {"kind = \"constant-velocity\"", "kind = \"stick-slip\", stick = \"1 ms\", slip = \"1 ms\"",
           "'start' means nothing with kind = \"stick-slip\""},
          {"steps = 15", "steps = 15.0",
           "scenario.toml:11:9: error: 'steps': must be a whole number, or a list of them, not 15"},
          {"steps = 15", "steps = \"15\"", "'steps': \"15\" must be a whole number, or a list of them, without quotes"},
          {"steps = 15", "steps = []", "'steps' must be a whole number, or a list of them, such as 15"},
          {"steps = 15", "steps = [14, 0]",
           "scenario.toml:11:14: error: 'steps': 0 is out of range; it must be at least 1 and at most 1000000"},
          {"tags = [\"ci\"]", "tags = \"ci\"", "'tags' must be a list, each a string"},
          {"tags = [\"ci\"]", "tags = [1]", "'tags': must be a list, each a string, not 1"},
          {"name = \"spring\"", "name = 2020-01-01", "not a date or time of day"},
          {"[run]", "[[run]]", "'run': must be a table, not a list"},
          {"[[device]]", "[device]", "'device' must be a list, each a table; write [[device]]"},
          {"[\"0.1 m/s\", \"0 m/s\", \"0 m/s\"]", "[\"0.1 m/s\"]",
           "'velocity' must be a list of three (x, y, z), each a velocity, such as [\"0.1 m/s\""},
          {"smooth 0.2 s", "quick", "'start': \"quick\" must be \"smooth <time>\", such as \"smooth 0.2 s\""},
          {"smooth 0.2 s", "smooth -1 s", "'start': \"smooth -1 s\" is out of range; it must be at least 0 s"},
      });
}

TEST_CASE("A value without a unit, with a wrong one or out of range is named with the remedy") {
  check_each(
      kSpring,
      {
          {"visualization = \"11.1 ms\"", "visualization = 11.1",
           "scenario.toml:10:17: error: 'visualization': 11.1 has no unit; write \"render\", a time, \"render <time>\" or "
           "\"burn "
           "<time>\" such as \"11.1 ms\""},
          {"segment = \"30 Hz\"", "segment = 30", "'segment': 30 has no unit; write a time or a rate such as \"30 Hz\""},
          {"200 N/m", "200", "'stiffness': '200' has no unit; write a stiffness such as \"200 N/m\""},
          {"11.1 ms", "11.1 msec",
           "scenario.toml:10:17: error: 'visualization': 'msec' is not a unit of time; did you mean 'ms'?"},
          {"11.1 ms", "30 Hz", "'visualization': 'Hz' is a unit of rate, not of time"},
          {"11.1 ms", "-1 ms", "'visualization': \"-1 ms\" is out of range; it must be at least 0 s"},
          {"11.1 ms", "nan ms",
           "'visualization': \"nan ms\" must be \"render\", a time, \"render <time>\" or \"burn <time>\""},
          {"11.1 ms", "1 segment", "'segment' is not known here: [timing] itself defines it"},
          {"visualization = \"11.1 ms\"", "visualization = nan", "'visualization': nan is not a number a scenario can use"},
          {"visualization = \"11.1 ms\"", "visualization = inf", "'visualization': inf is not a number a scenario can use"},
          {"duration = \"4 s\"", "duration = \"0 s\"",
           "scenario.toml:6:12: error: 'duration': \"0 s\" is out of range; it must be above 0 s and at most 1000000 s"},
          {"duration = \"4 s\"", "duration = \"-4 s\"", "'duration': \"-4 s\" is out of range"},
          {"duration = \"4 s\"", "duration = \"1000001 s\"", "'1000001 s' is longer than 1e6 s"},
          {"duration = \"4 s\"", "duration = \"1e9 segments\"", "'1e9 segments' is longer than 1e6 s"},
          {"duration = \"4 s\"", "", "scenario.toml:5:1: error: [run] has no 'duration'; write duration = \"4 s\""},
          {"8 segments", "121 segments",
           "scenario.toml:7:10: error: 'warmup': 4033.333293 ms of 4000 ms leave nothing to judge"},
          {"steps = 15", "steps = 0", "'steps': 0 is out of range"},
          {"steps = 15", "steps = 1000000001",
           "'steps': 1000000001 is out of range; it must be at least 1 and at most 1000000"},
          {"warmup = \"8 segments\"", "seed = -1", "'seed': -1 is out of range"},
          {"name = \"left\"", "name = \"left\"\nrate = \"0 Hz\"", "'rate': '0 Hz' is not above 0 Hz"},
          {"name = \"left\"", "name = \"left\"\nforce_limit = \"1e13 N\"",
           "'force_limit': \"1e13 N\" is out of range; it must be above 0 N and at most 1000000000000 N"},
          {"name = \"left\"", "name = \"left\"\nforce_limit = \"0 N\"",
           "'force_limit': \"0 N\" is out of range; it must be above 0 N"},
          {"name = \"left\"", "name = \"left\"\nphase = \"-1 ms\"", "'phase': \"-1 ms\" is out of range"},
          {"name = \"left\"", "name = \"left\"\nphase = \"1 ms\"",
           "'phase': 1 ms is a period of 1 ms or more; write the rest"},
          {"[[expect]]", "[remap]\nestimate = { weight = 0 }\n[[expect]]",
           "'weight': 0 is out of range; it must be above 0 and at most 1"},
          {"[[expect]]", "[remap]\nestimate = { weight = nan }\n[[expect]]", "'weight': nan is not a number"},
          {"[[expect]]", "[remap]\nlatency = \"-1 ms\"\n[[expect]]", "'latency': \"-1 ms\" is out of range"},
          {"[[expect]]", "[remap]\nlatency = \"minmal\"\n[[expect]]", "did you mean 'minimal'?"},
          {"[[expect]]", "[remap]\nunderrun = { force = \"zero\" }\n[[expect]]", "'force': \"zero\" must be \"hold\""},
          {"[[expect]]", "[remap]\npredict_window = \"0 ms\"\n[[expect]]", "'predict_window': \"0 ms\" is out of range"},
      });
}

TEST_CASE("An adaptive latency that cannot be, or that nobody has, is refused with the remedy") {
  const std::string adaptive = "[remap]\nlatency = \"adaptive\"\n";
  const auto refused = [](std::string text, const std::string& error) {
    const ReadResult result = read_text(text);
    INFO(text);
    CHECK_FALSE(result);
    CHECK_THAT(errors_of(result), Contains(error));
  };
  const auto with = [&](const std::string& adapt) {
    return changed(kSpring, "[[expect]]", adaptive + adapt + "\n[[expect]]");
  };
  refused(with("adapt = { start = \"5 ms\", min = \"6 ms\" }"),
          "'adapt': min 6 ms, start 5 ms and max 100 ms must not decrease");
  refused(with("adapt = { start = \"101 ms\" }"), "start 101 ms and max 100 ms must not decrease");
  refused(with("adapt = { min = \"6 ms\", max = \"5 ms\" }"), "min 6 ms, start 6 ms and max 5 ms must not decrease");
  refused(with("adapt = { slew = \"51 %\" }"), "'slew': \"51 %\" is out of range");
  refused(with("adapt = { slew = \"0.00005 %\" }"), "'slew': \"0.00005 %\" is finer than 1 ppm");
  refused(with("adapt = { window = \"0 s\" }"), "'window': \"0 s\" is out of range");
  refused(with("adapt = { margin = \"-1 ms\" }"), "'margin'");
  refused(with("adapt = { maximum = \"5 ms\" }"), "unknown key 'maximum'");
  refused(changed(with(""), "[run]", "[run]\nstrategies = [\"ideal\", \"direct\"]"),
          "'latency': only strategies that map have one that can adapt");
  refused(changed(with(""), "name = \"left\"",
                  "name = \"left\"\nrender = { kind = \"local\", alpha = \"auto\", emission = \"linear\" }"),
          "'latency': device 'left' takes its alpha from the latency");
  refused(changed(kSpring, "[[expect]]",
                  adaptive + "[[expect]]\nsignal = \"left.force.paper\"\nmetric = \"underrun_rate\"\nmax = \"1 %\"\n"
                             "confidence = \"95 %\"\n[[expect]]"),
          "'confidence' judges a latency that stays as it is");
}

TEST_CASE("A force that is held cannot be extrapolated, and a filter must leave something of its signal") {
  check_each(kSpring, {{"name = \"left\"",
                        "name = \"left\"\nrender = { kind = \"force\", emission = \"hold\" }\n[remap]\nunderrun = { force = "
                        "\"extrapolate\" }\n[[device]]\nname = \"right\"",
                        "'force': \"extrapolate\" continues a line, and device 'left' has emission = \"hold\""}});
  const std::string filtered = "[run]\nstrategies = [\"filtered\"]";
  const auto with = [&](const std::string& filter) {
    return changed(changed(kSpring, "[run]", filtered), "[[expect]]", "[remap.filter]\n" + filter + "\n[[expect]]");
  };
  for (const auto& [filter, error] : std::vector<std::pair<std::string, std::string>>{
           {"cutoff = \"500 Hz\"", "'cutoff': \"500 Hz\" cannot be filtered out of a signal of 1000 Hz"},
           {"on = \"interaction\"\ncutoff = \"225 Hz\"", "cannot be filtered out of a signal of 450 Hz"},
           {"kind = \"moving-average\"\nwindow = \"200 s\"", "'window': more than 100000 samples of 1000 Hz"},
           {"kind = \"moving-average\"\ncutoff = \"5 Hz\"",
            "'cutoff' means nothing with kind = \"moving-average\"; remove it, or write kind = \"butterworth\""},
           {"kind = \"one-euro\"\nbeta = -1", "'beta': -1 is out of range"}}) {
    INFO(filter);
    const ReadResult result = read_text(with(filter));
    CHECK_FALSE(result);
    CHECK_THAT(errors_of(result), Contains(error));
  }
  // Without the strategy `filtered` nothing is filtered, so any rate of the device will do.
  const ReadResult unused = read_text(changed(kSpring, "name = \"left\"", "name = \"left\"\nrate = \"15 Hz\""));
  INFO(errors_of(unused));
  CHECK(unused);
}

TEST_CASE("What a device renders must go together, and with its scene") {
  const auto render = [](const std::string& keys) { return "name = \"left\"\nrender = { " + keys + " }"; };
  for (const auto& [keys, error] : std::vector<std::pair<std::string, std::string>>{
           {"alpha = 1.1",
            "scenario.toml:17:12: error: 'alpha' means nothing with kind = \"force\"; remove it, or write kind = \"local\""},
           {"kind = \"damped\"", "'kind': \"damped\" must be \"force\", \"local\", \"device_spring\" or \"smith\""},
           {"kind = \"local\", alpha = 0", "'alpha': 0 is out of range; it must be above 0 and at most 4"},
           {"kind = \"local\", alpha = 4.01", "'alpha': 4.01 is out of range"},
           {"kind = \"local\", alpha = \"most\"", "'alpha': \"most\" must be \"auto\" or a number"},
           {"kind = \"local\", stiffness = \"none\"", "'stiffness': \"none\" must be \"instantaneous\" or \"settled\""},
           {"kind = \"local\", gap = \"no\"", "'gap'"},
           {"kind = \"local\", frequency = \"7 Hz\"",
            "'frequency' means nothing with kind = \"local\"; remove it, or write kind = \"smith\""},
           {"kind = \"local\", cap = \"laws\"", "'cap': \"laws\" must be \"law\" or a stiffness"},
           {"kind = \"local\", cap = \"0 N/m\"", "'cap': \"0 N/m\" is out of range"},
           {"kind = \"local\", cap = \"law\"", "'cap': \"law\" follows from the mass and damping of a hand"},
           {"kind = \"device_spring\"",
            "scenario.toml:17:19: error: 'kind': \"device_spring\" is for devices that render springs by "
            "themselves; write driver = \"pid\" or \"evdev\", or kind = \"local\""},
           {"kind = \"device_spring\" }\ndriver = \"pid\"\npid = { travel = [\"400 mm\", \"400 mm\", \"0 mm\"]",
            "write full_scale in its 'pid'"},
           {"kind = \"device_spring\" }\ndriver = \"pid\"\npid = { travel = [\"400 mm\", \"400 mm\", \"0 mm\"], full_scale "
            "= "
            "\"5 N\"",
            "scenario.toml:17:19: error: 'render': the device has no spring whose sign is known; measure it "
            "(docs/devices/hid.md) and write springs = [\"x\"]"},
           {"kind = \"local\" }\ndriver = \"pid\"\npid = { travel = [\"400 mm\", \"400 mm\", \"0 mm\"], full_slope = \"0 "
            "N/m\"",
            "'full_slope': \"0 N/m\" is out of range"},
           {"kind = \"local\" }\ndriver = \"pid\"\npid = { travel = [\"400 mm\", \"400 mm\", \"0 mm\"], firmware_rate = "
            "\"99 Hz\"",
            "'firmware_rate': \"99 Hz\" is out of range"},
           {"kind = \"smith\", gap = false",
            "'gap' means nothing with kind = \"smith\"; remove it, or write kind = \"local\""},
           {"kind = \"smith\", frequency = \"1001 Hz\"", "'frequency': \"1001 Hz\" is out of range"},
           {"kind = \"smith\", factor = 0", "'factor': 0 is out of range"},
           {"kind = \"smith\", frequency = \"7 Hz\", damping_ratio = 0.1",
            "device 'left' renders \"smith\", a model of one mode, and a scene of this kind does not say which; write "
            "frequency"}}) {
    INFO(keys);
    const ReadResult result = read_text(changed(kSpring, "name = \"left\"", render(keys)));
    CHECK_FALSE(result);
    CHECK_THAT(errors_of(result), Contains(error));
  }
  check_each(
      kSpring,
      {{"name = \"left\"",
        "name = \"left\"\nrender = { kind = \"local\" }\n[[device]]\nname = \"right\"\nrender = { kind = \"local\", "
        "stiffness = \"settled\" }",
        "device 'right' renders with stiffness = \"settled\" and one before it with \"instantaneous\""},
       {"name = \"left\"",
        "name = \"left\"\nrender = { kind = \"local\" }\n[remap]\nunderrun = { force = \"extrapolate\" }\n[[device]]\nname "
        "= \"right\"",
        "'force': \"extrapolate\" continues a line of forces, and device 'left' makes its forces of records"}});
  const ReadResult clash =
      read_text(changed(changed(kTissue, "particles = 800", "particles = 800\nlocal_model = \"settled\""),
                        "radius = \"6 mm\" }", "radius = \"6 mm\" }\nrender = { kind = \"local\" }"));
  CHECK_FALSE(clash);
  CHECK_THAT(errors_of(clash),
             Contains("'local_model': \"settled\", but a device renders with stiffness = \"instantaneous\"; remove"));
}

TEST_CASE("Timings that cannot be are named with the numbers that clash") {
  check_each(
      kSpring,
      {
          {"11.1 ms", "33.4 ms",
           "scenario.toml:10:17: error: 'visualization': V = 33.4 ms of a segment of T = 33.333333 ms leaves no time for "
           "steps"},
          {"11.1 ms", "33.333333 ms", "leaves no time for steps"},  // a third of a nanosecond for 15 steps
          {"steps = 15", "steps = 15\nstep = \"1.5 ms\"",
           "scenario.toml:12:8: error: 'step': V + N s = 33.6 ms is longer than the segment of 33.333333 ms"},
          {"steps = 15", "steps = 15\nstep = \"40 ms\"", "'step': 40 ms is longer than the segment of 33.333333 ms"},
          {"steps = 15", "steps = 15\nstep = \"0 s\"", "'step': \"0 s\" is out of range"},
          {"steps = 15", "steps = 15\nstep = \"fil\"",
           "'step': \"fil\" must be \"fill\", \"real\" or a time; did you mean 'fill'?"},
          {"segment = \"30 Hz\"", "", "scenario.toml:8:1: error: [timing] has no 'segment', which step = \"fill\" needs"},
          {"segment = \"30 Hz\"", "segment = \"1 us\"",
           "'segment': \"1 us\" is out of range; it must be between 10 us and 9 s"},
          {"segment = \"30 Hz\"", "segment = \"9.000000001 s\"", "'segment': \"9.000000001 s\" is out of range"},
          {"segment = \"30 Hz\"", "step = \"10 s\"",
           "scenario.toml:9:8: error: 'step': V + N s is out of range; it must be between 10 us and 9 s"},
          {"segment = \"30 Hz\"", "segment = \"-1 s\"", "'segment': \"-1 s\" is out of range"},
          {"steps = 15", "steps = 15\njitter = { step = \"gaussian 3 %\" }",
           "'step': \"gaussian 3 %\" must be \"lognormal <ratio>\" or \"uniform <ratio>\", such as \"lognormal 10 %\""},
          {"steps = 15", "steps = 15\njitter = { step = \"lognormal -3 %\" }", "is out of range"},
          {"steps = 15", "steps = 15\njitter = { step = \"lognormal 3 ms\" }", "'ms' is a unit of time, not of ratio"},
          {"steps = 15", "steps = 15\njitter = { step = 10 }", "'step': 10 has no unit"},
          {"steps = 15", "steps = 15\ntrace = \"x.csv\"",
           "scenario.toml:9:1: error: 'segment' does not go with 'trace': the recording says it all"},
      });
  std::string many = "steps = [1";
  for (int i = 0; i < 1000; ++i) many += ", 1";
  CHECK_THAT(errors_of(read_text(changed(kSpring, "steps = 15", many + "]"))), Contains("lists more than 1000 values"));
}

TEST_CASE("Strategies, devices and expectations must fit each other") {
  check_each(
      kSpring,
      {
          {"warmup = \"8 segments\"", "strategies = [\"direct\", \"direct\"]",
           "scenario.toml:7:25: error: 'strategies' names \"direct\" twice"},
          {"warmup = \"8 segments\"", "strategies = []", "'strategies' is empty; name at least one"},
          {"warmup = \"8 segments\"", "strategies = [\"phaselocked\"]", "did you mean 'phase_locked'?"},
          {"warmup = \"8 segments\"", "live = \"ideal\"",
           "'live': \"ideal\" must be \"direct\", \"paper\", \"phase_locked\" or \"clocked\""},
          {"warmup = \"8 segments\"", "strategies = [\"ideal\"]",
           "scenario.toml:19:10: error: 'signal': there is no strategy 'direct'; this scenario has: ideal"},
          {"name = \"left\"", "name = \"le ft\"", "'name': \"le ft\" must be letters, digits, _ and -"},
          {"name = \"left\"", "name = \"\"", "'name': \"\" must be letters, digits, _ and -"},
          {"name = \"left\"", "name = \"solver\"", "is a signal of its own"},
          {"name = \"left\"", "name = \"left\"\n[[device]]\nname = \"left\"",
           "scenario.toml:18:8: error: 'name': there is a device \"left\" already"},
          {"name = \"left\"", "name = \"left\"\n[[device]]\nname = \"b\"\n[[device]]\nname = \"c\"",
           "scenario.toml:19:1: error: more than 2 devices"},
          {"name = \"left\"", "name = \"left\"\ngrab = { center = [\"0 m\", \"0 m\", \"0 m\"], radius = \"1 mm\" }",
           "'grab' means nothing without a tissue"},
          {"left.interaction.direct", "right.interaction.direct",
           "scenario.toml:19:10: error: 'signal': there is no device 'right'; this scenario has: left"},
          {"left.interaction.direct", "left.interactoin.direct",
           "'interactoin' is not a signal of a device; did you mean 'interaction'?"},
          {"left.interaction.direct", "left.interaction",
           "'left.interaction' is not a signal; write <device>.interaction.<strategy>"},
          {"left.interaction.direct", "left..direct", "is not a signal"},
          {"left.interaction.direct", "", "'' is not a signal"},
          {"left.interaction.direct", "solver.warp", "there is no strategy 'warp'"},
          {"min = \"4 step\"", "", "scenario.toml:18:1: error: [[expect]] has no limit; write min, max or equals"},
          {"min = \"4 step\"", "min = \"4 stip\"", "'min': 'stip' is not a unit; did you mean 'step'?"},
          {"min = \"4 step\"", "min = \"4 step\"\nmax = \"3 step\"",
           "scenario.toml:21:7: error: 'min': 4 step is above max, 3 step; nothing can hold"},
          {"min = \"4 step\"", "min = \"1 ms\"\nmax = \"999 us\"", "nothing can hold"},
          {"min = \"4 step\"", "min = \"2 segments\"\nmax = \"60 ms\"", "nothing can hold"},
          {"min = \"4 step\"", "min = 1\nequals = 1", "'equals' is min and max in one; remove the other"},
          {"min = \"4 step\"", "min = nan", "'min': nan is not a number"},
          {"min = \"4 step\"", "min = true", "'min': must be a limit, not true"},
          {"metric = \"velocity_jump\"", "", "[[expect]] has no 'metric'"},
          {"metric = \"velocity_jump\"", "metric = \"\"", "'metric' is empty"},
          {"[[expect]]", "[expect_stop]\nreason = \"tired\"\n[[expect]]",
           "'reason': \"tired\" must be \"unstable-step\", \"diverged\", \"bad-input\", \"device\" or \"interrupted\""},
      });
  for (const char* signal : {"run", "solver.*", "*.*", "events.device.tick", "*.interaction.direct", "left.*.*",
                             "left.buffers.paper", "events.*.*"}) {
    INFO(signal);
    CHECK(errors_of(read_text(changed(kSpring, "left.interaction.direct", signal))) == "");
  }
}

TEST_CASE("A fault, a pool or a stop that cannot be is named where it stands") {
  check_each(
      kPid,
      {
          {"interrupt = \"3 s\"", "interrupt = \"4 s\"",
           "scenario.toml:4:13: error: 'interrupt': the run has ended by 4000 ms; interrupt it earlier, or run longer"},
          {"interrupt = \"3 s\"", "interrupt = \"-1 s\"", "'interrupt': \"-1 s\" is out of range"},
          {"driver = \"pid\"", "driver = \"pid\"\nsample_time = \"taken\"",
           "scenario.toml:15:15: error: 'sample_time': \"taken\" needs reports that say when they were taken"},
          {"driver = \"pid\"", "driver = \"pid\"\nclock_rate_error = \"2000 ppm\"", "'clock_rate_error': \"2000 ppm\""},
          {"driver = \"pid\"", "driver = \"pid\"\nclock_rate_error = \"-100.5 ppm\"",
           "'clock_rate_error': \"-100.5 ppm\" is finer than 1 ppm; write whole millionths, such as \"-100 ppm\""},
          {"driver = \"pid\"", "driver = \"pid\"\nreport_age = \"-1 ms\"", "'report_age': \"-1 ms\" is out of range"},
          {"pool = 3", "pool = 41", "'pool': 41 is out of range; it must be at least 0 and at most 40"},
          {"pool = 3", "pool = -1", "'pool': -1 is out of range"},
          {"block_load_error = 2", "block_load_error = 0",
           "'block_load_error': 0 is out of range; it must be at least 1 and at most 40"},
          {"\"unread\"", "\"unreed\"", "did you mean 'unread'?"},
          {"driver = \"pid\"", "driver = \"reference\"", "'pid' means nothing with driver = \"reference\""},
          {"at_least_step = 1300", "at_least_step = 1401",
           "scenario.toml:35:17: error: 'at_least_step': 1401 is above at_most_step, 1400; nothing can hold"},
          {"message = \"at 3 s\"", "message = 3", "'message': must be a string, not 3"},
      });
  CHECK(errors_of(read_text(changed(kPid, "at_least_step = 1300", "at_least_step = 1400"))) == "");
  CHECK(errors_of(read_text(changed(kPid, "interrupt = \"3 s\"", "interrupt = \"3.999999999 s\""))) == "");
}

TEST_CASE("A tissue must fit its lattice and its devices") {
  check_each(
      kTissue,
      {
          {"particles = 800", "particles = 811",
           "scenario.toml:13:13: error: 'particles': 811 do not fit the 810 sites of the lattice; write at most 810"},
          {"particles = 800", "particles = 729",
           "'particles': 729 of 810 sites would cut more than the top layer of 81; write a smaller lattice"},
          {"lattice = [9, 9, 10]", "lattice = [9, 0, 10]", "'lattice': 0 is out of range"},
          {"lattice = [9, 9, 10]", "lattice = [9, 9]",
           "'lattice' must be a list of three (x, y, z), each a whole number, such as [27, 27, 28]"},
          {"lattice = [9, 9, 10]\nparticles = 800", "lattice = [1000, 1000, 101]",
           "101000000 particles are more than the limit of 100000000"},
          {"particles = 800", "spacing = \"0 m\"", "'spacing': \"0 m\" is out of range"},
          {"particles = 800", "mass = \"0 g\"", "'mass': \"0 g\" is out of range"},
          {"particles = 800", "substeps = 0", "'substeps': 0 is out of range"},
          {"particles = 800", "substeps = \"many\"", "'substeps': \"many\" must be \"auto\" or a whole number"},
          {"particles = 800", "fixed = \"floor\"",
           "scenario.toml:13:9: error: 'fixed': \"floor\" must be \"left\", \"right\", \"front\", \"back\", \"bottom\", "
           "\"top\" or \"none\", or a list of them"},
          {"particles = 800", "fixed = []", "'fixed' must be"},
          {"particles = 800", "fixed = [\"left\", \"none\"]",
           "scenario.toml:13:18: error: 'fixed': \"none\" stands among faces; write \"none\" alone, or the faces alone"},
          {"particles = 800", "fixed = [\"left\", \"left\"]", "scenario.toml:13:18: error: 'fixed' names \"left\" twice"},
          {"particles = 800", "method = \"verlet\"", "'method': \"verlet\" must be \"symplectic-euler\""},
          {"particles = 800", "iterations = 5",
           "scenario.toml:13:14: error: 'iterations' means nothing with method = \"symplectic-euler\"; remove it, or write "
           "method = \"implicit-euler\" or"},
          {"particles = 800", "method = \"rk4\"\niterations = 5", "'iterations' means nothing with method = \"rk4\""},
          {"particles = 800", "method = \"implicit-euler\"\niterations = 0", "'iterations': 0 is out of range"},
          {"particles = 800", "gravity = \"9.81 m/s2\"",
           "'gravity' must be a list of three (x, y, z), each an acceleration"},
          {"particles = 800", "gravity = [\"0 m/s2\", \"0 m/s2\", \"-9.81 m/s\"]",
           "scenario.toml:13:32: error: 'gravity': 'm/s' is a unit of velocity, not of acceleration"},
          {"particles = 800", "gravity = [\"0 m/s2\", \"0 m/s2\", \"-9.81 m/s^2\"]", "did you mean 'm/s2'?"},
          {"particles = 800", "axial_damping = \"-1 N s/m\"", "'axial_damping': \"-1 N s/m\" is out of range"},
          {"particles = 800", "local_model = \"rest\"",
           "'local_model': \"rest\" must be \"none\", \"instantaneous\" or \"settled\""},
          {"particles = 800", "regions = [{ min = [\"0 m\", \"0 m\", \"0 m\"], stiffness = \"1 N/m\" }]",
           "scenario.toml:13:12: error: scene.regions has no 'max'; write max = [\"10 mm\", \"10 mm\", \"10 mm\"]"},
          {"particles = 800", "regions = [{ min = [\"0 m\", \"0 m\", \"0 m\"], max = [\"1 m\", \"1 m\", \"1 m\"] }]",
           "a region without 'stiffness' and 'mass' is no other material; write one of them"},
          {"particles = 800",
           "regions = [{ min = [\"0 m\", \"9 mm\", \"0 m\"], max = [\"1 m\", \"8 mm\", \"1 m\"], mass = \"1 g\" }]",
           "'max': 8 mm along y is below min, 9 mm; exchange them"},
          {"particles = 800",
           "regions = [{ min = [\"0 m\", \"0 m\", \"46 mm\"], max = [\"1 m\", \"1 m\", \"1 m\"], mass = \"1 g\" }]",
           "'regions': no particle is inside: along z they stand at 0 mm to 45 mm, 5 mm apart"},
          {"particles = 800",
           "regions = [{ min = [\"0 m\", \"1 mm\", \"0 m\"], max = [\"1 m\", \"4 mm\", \"1 m\"], mass = \"1 g\" }]",
           "no particle is inside: along y they stand at 0 mm to 40 mm, 5 mm apart"},
          {"radius = \"6 mm\"", "radius = \"6 mm\", coupling = \"glue\"",
           "'coupling': \"glue\" must be \"grab\", \"spring\" or \"probe\""},
          {"radius = \"6 mm\"", "radius = \"6 mm\", coupling = \"spring\"",
           "device.grab has no 'stiffness'; write stiffness = \"200 N/m\""},
          {"radius = \"6 mm\"", "radius = \"6 mm\", coupling = \"probe\"", "device.grab has no 'stiffness'"},
          {"radius = \"6 mm\"", "radius = \"6 mm\", stiffness = \"1 N/m\"",
           "'stiffness' means nothing with coupling = \"grab\"; remove it, or write coupling = \"spring\" or \"probe\""},
          {"radius = \"6 mm\"", "radius = \"6 mm\", coupling = \"probe\", stiffness = \"1 N/m\", damping = \"1 N s/m\"",
           "'damping' means nothing with coupling = \"probe\"; remove it, or write coupling = \"spring\""},
          {"radius = \"6 mm\"", "radius = \"6 mm\", coupling = \"probe\", stiffness = \"0 N/m\"",
           "'stiffness': \"0 N/m\" is out of range; it must be above 0 N/m"},
          {"grab = { center = [\"20 mm\", \"20 mm\", \"45 mm\"], radius = \"6 mm\" }", "",
           "scenario.toml:15:1: error: [[device]] has no 'grab', which kind = \"tissue\" needs"},
          {", radius = \"6 mm\"", "", "device.grab has no 'radius'; write radius = \"6 mm\""},
          {"stop = \"0.5 s\"", "stop = \"0.05 s\"", "'stop': 50 ms is within the smooth start of 100 ms; stop later"},
          {", stop = \"0.5 s\"", "", "device.motion has no 'stop'; write stop = \"1 s\""},
          {"\"ramp-stop\"", "\"stick-slip\"", "device.motion has no 'stick'; write stick = \"90 ms\""},
          {"\"ramp-stop\"", "\"stick-slip\", stick = \"0 s\"", "device.motion has no 'slip'; write slip = \"10 ms\""},
          {"\"ramp-stop\"", "\"stick-slip\", slip = \"0 s\"", "'slip': \"0 s\" is out of range; it must be above 0 s"},
          {"\"ramp-stop\"", "\"stick-slip\", stick = \"-1 ms\"", "it must be at least 0 s"},
          {"frequency = \"1/3 Hz\"", "frequency = \"1/0 Hz\"", "divides by zero"},
          {"queue = \"libusb\"", "queue = \"usb\"", "'queue': \"usb\" must be \"hidraw\" or \"libusb\""},
      });
}

TEST_CASE("A study must name steps that meet, and a scene that has steps") {
  const auto with = [](const std::string& keys) {
    return errors_of(read_text(std::string(kTissue) + "[study]\n" + keys + "\nerror = \"state\"\n"));
  };
  CHECK(with("") == "");
  struct {
    const char *keys, *error;
  } const rows[] = {
      {"methods = []", "scenario.toml:40:11: error: 'methods' is empty; name at least one"},
      {"methods = [\"rk4\", \"rk4\"]", "scenario.toml:40:19: error: 'methods' names \"rk4\" twice"},
      {"methods = [\"euler\"]", "'methods': \"euler\" must be a list, each \"symplectic-euler\""},
      {"solvers = [\"gpu\"]",
       "'solvers': \"gpu\" must be a list, each \"opencl\", \"cpu\" or \"cpu-double\"; did you mean 'cpu'?"},
      {"iterations = [0]", "'iterations': 0 is out of range"},
      {"repeats = 0", "'repeats': 0 is out of range"},
      {"duration = \"2 ms\"", "'duration': 2 ms is less than one step of the scene, 2.22222 ms"},
      {"step_sizes = []", "'step_sizes' is empty; name at least one, or leave it out"},
      {"step_sizes = [\"450 Hz\", \"1 ms\"]",
       "scenario.toml:40:25: error: 'step_sizes': \"1 ms\" is no whole part of the scene's step of 2.22222 ms and no "
       "multiple of it; "
       "write one, or another [scene] step_size"},
      {"step_sizes = [\"450 Hz\", \"450 Hz\"]", "scenario.toml:40:25: error: 'step_sizes': \"450 Hz\" is there already"},
      {"step_sizes = [\"10 Hz\"]", "'step_sizes': \"10 Hz\" is longer than the study"},
      {"step_sizes = [\"90 MHz\"]", "'MHz' is not a unit"},
      {"step_sizes = [\"90000 kHz\"]", "cuts the scene's step of 2.22222 ms into more than 100000"},
      {"step_sizes = [\"150 Hz\", \"90 Hz\", \"450/7 Hz\"]",
       "these steps never end at the same instant within the duration"},
  };
  for (const auto& row : rows) {
    INFO(row.keys);
    CHECK_THAT(with(row.keys), Contains(row.error));
  }
  CHECK_THAT(errors_of(read_text(std::string(kSpring) + "[study]\nerror = \"state\"\n")),
             Contains("error = \"state\" compares the steps of a tissue, and this scene has none"));
}

TEST_CASE("A study of the felt force takes the run's own steps and judged time, and of a scene without steps nothing more") {
  const auto with = [](const char* scene, const std::string& keys) {
    return errors_of(read_text(std::string(scene) + "[study]\n" + keys + "\n"));
  };
  CHECK(with(kTissue, "") == "");
  CHECK(with(kSpring, "") == "");
  CHECK(with(kSpring, "error = \"felt-force\"\nrepeats = 2") == "");
  CHECK_THAT(with(kTissue, "error = \"felt\""), Contains("'error': \"felt\" must be \"felt-force\" or \"state\""));
  CHECK_THAT(with(kTissue, "duration = \"1000 s\""), Contains("'duration': 1000000 ms is more than the"));
  CHECK_THAT(with(kTissue, "duration = \"2 ms\""), Contains("is less than one step of the scene"));
  CHECK_THAT(with(kTissue, "step_sizes = [\"450 Hz\", \"225 Hz\"]"),
             Contains("longer than the scene's does not fit the [timing]"));
  CHECK_THAT(with(kSpring, "methods = [\"rk4\"]"), Contains("'methods' is that of a tissue"));
  CHECK_THAT(with(kSpring, "solvers = [\"cpu\"]"), Contains("'solvers' is that of a tissue"));
}

TEST_CASE("A hand that cannot be integrated, or that no strategy or study can use, is refused with the remedy") {
  const char* const hand = "kind = \"hand\", mass = \"0.2 kg\"";
  std::string base = changed(kSpring, "warmup = \"8 segments\"", "strategies = [\"direct\"]");
  base = changed(
      base, "kind = \"constant-velocity\", velocity = [\"0.1 m/s\", \"0 m/s\", \"0 m/s\"], start = \"smooth 0.2 s\"", hand);
  base = changed(base, "4 step", "1 mm");
  REQUIRE(errors_of(read_text(base)).empty());
  check_each(
      base.c_str(),
      {
          {", mass = \"0.2 kg\"", "", "device.motion has no 'mass'; write mass = \"0.2 kg\""},
          {"0.2 kg", "0 kg", "'mass': \"0 kg\" is out of range; it must be above 0 kg"},
          {"0.2 kg\"", "0.2 kg\", damping = \"-1 N s/m\"", "'damping': \"-1 N s/m\" is out of range"},
          {"0.2 kg\"", "1 g\", stiffness = \"20 N/mm\"",
           "'mass': on its springs the hand swings with 4472 /s, and 4000 /s is the most; write more mass or less "
           "stiffness"},
          {"0.2 kg\"", "1 g\", damping = \"5 N s/m\"", "'mass': the damping stops the hand with 5000 /s"},
          {"0.2 kg\"", "0.2 kg\", arm = { damping = \"1 N s/m\" }", "device.motion.arm has no 'mass'"},
          {"0.2 kg\"", "0.2 kg\", offset = [\"3 m\", \"0 m\", \"0 m\"]", "'offset': \"3 m\" is out of range"},
          {"0.2 kg\"", "0.2 kg\", path = { kind = \"hand\", mass = \"1 kg\" }", "'kind': \"hand\" must be \"still\""},
          {"0.2 kg\"", "0.2 kg\", path = { kind = \"minimum-jerk\", moves = [] }", "'moves' is empty; write [{ to = "},
          {"0.2 kg\"", "0.2 kg\", path = { kind = \"minimum-jerk\", moves = [{ duration = \"1 s\" }] }",
           "device.motion.path.moves has no 'to'"},
          {"0.2 kg\"", "0.2 kg\", amplitude = [\"1 mm\", \"0 m\", \"0 m\"]",
           "'amplitude' means nothing with kind = \"hand\"; remove it, or write kind = \"sine\""},
          {"[\"direct\"]", "[\"direct\", \"ideal\"]",
           "scenario.toml:7:14: error: 'strategies': \"ideal\" reads the programmed motion, and a hand that feels the force "
           "has none"},
          {"name = \"left\"", "name = \"left\"\ndelay = \"2 s\"", "'delay': \"2 s\" is out of range"},
      });
  const auto study = [&](const std::string& text, const std::string& keys) {
    return errors_of(read_text(text + "[study]\n" + keys + "\n"));
  };
  CHECK(study(base, "stiffness_limit = { from = \"20 N/m\", to = \"1 kN/m\" }").empty());
  CHECK_THAT(study(base, "stiffness_limit = { from = \"20 N/m\", to = \"20 N/m\" }"), Contains("'to' is not above 'from'"));
  CHECK_THAT(study(base, "stiffness_limit = { from = \"20 N/m\" }"), Contains("study.stiffness_limit has no 'to'"));
  CHECK_THAT(study(base, "stiffness_limit = { from = \"20 N/m\", to = \"1 kN/m\", mass = \"in-proportion\" }"),
             Contains("'mass' is that of a tissue's particles"));
  CHECK_THAT(study(base, "repeats = 3\nstiffness_limit = { from = \"20 N/m\", to = \"30 N/m\" }"),
             Contains("'repeats' does not go with 'stiffness_limit'"));
  CHECK_THAT(study(kSpring, "stiffness_limit = { from = \"20 N/m\", to = \"30 N/m\" }"),
             Contains("needs a hand that feels the force"));
}

TEST_CASE("A surface without a direction, and a mode that pulls as it pushes and yet has a surface, are refused") {
  const auto scene = [](const std::string& keys) {
    return errors_of(read_text(changed(kSpring, "kind = \"spring\"\nstiffness = \"200 N/m\"", keys)));
  };
  CHECK_THAT(scene("kind = \"wall\"\nnormal = [0, 0, 0]"), Contains("'normal': [0, 0, 0] points nowhere; write [1, 0, 0]"));
  CHECK_THAT(scene("kind = \"wall\"\nhardening = \"0 mm\""), Contains("'hardening': \"0 mm\" is out of range"));
  CHECK_THAT(scene("kind = \"wall\"\nfrequency = \"30 Hz\""), Contains("'frequency' means nothing with kind = \"wall\""));
  CHECK_THAT(scene("kind = \"mode\""), Contains("[scene] has no 'frequency'; write frequency = \"30 Hz\""));
  CHECK_THAT(scene("kind = \"mode\"\nfrequency = \"2 kHz\""), Contains("'frequency': \"2 kHz\" is out of range"));
  CHECK_THAT(scene("kind = \"mode\"\nfrequency = \"30 Hz\"\nsurface = \"1 mm\""),
             Contains("'surface' means nothing where the mode pulls as it pushes; remove it, or write one_sided = true"));
}

TEST_CASE("A tissue has at most 60 regions") {
  const auto with = [](int count) {
    std::string regions = "regions = [";
    for (int i = 0; i < count; ++i)
      regions += "\n{ min = [\"0 m\", \"0 m\", \"0 m\"], max = [\"1 m\", \"1 m\", \"1 m\"], mass = \"1 g\" },";
    return errors_of(read_text(changed(kTissue, "particles = 800", regions + "]")));
  };
  CHECK(with(60) == "");
  CHECK_THAT(with(61), Contains("scenario.toml:13:11: error: 'regions' lists 61 boxes; there can be 60 materials besides"));
}

TEST_CASE("All mistakes of a file are reported at once, by position") {
  std::string text = changed(kSpring, "11.1 ms", "11.1 msec");
  text = changed(text, "200 N/m", "200 N");
  text = changed(text, "left.interaction.direct", "x.interaction.direct");
  text = changed(text, "duration = \"4 s\"", "durration = \"4 s\"");
  const std::string errors = errors_of(read_text(text));
  CHECK(errors ==
        "scenario.toml:6:1: error: unknown key 'durration' in [run]; did you mean 'duration'?\n"
        "scenario.toml:10:17: error: 'visualization': 'msec' is not a unit of time; did you mean 'ms'?\n"
        "scenario.toml:14:13: error: 'stiffness': 'N' is a unit of force, not of stiffness\n");
  // The signal was not checked against [run] because that had an error itself. Without that error, it is checked.
  CHECK_THAT(errors_of(read_text(changed(text, "durration", "duration"))),
             Contains("scenario.toml:19:10: error: 'signal': there is no device 'x'"));
}

TEST_CASE("A file of an unknown format, with a syntax error or a duplicate key is refused with its place") {
  check_each(kSpring, {
                          {"format = 1\n", "", "scenario.toml:1:1: error: no 'format'; write format = 1 at the top"},
                          {"format = 1", "format = 2",
                           "scenario.toml:1:10: error: format = 2 is not known to this version, which reads format = 1"},
                          {"format = 1", "format = \"1\"", "format = \"1\" is not known"},
                          {"steps = 15", "steps = 15\nsteps = 16", "scenario.toml:12:"},
                          {"steps = 15", "steps = 15 Hz", "scenario.toml:11:"},
                          {"steps = 15", "steps = ", "scenario.toml:11:"},
                          {"because = \"the", "because = \"\xff\xfe", "scenario.toml:3:"},
                          {"steps = 15", "a.b.c.d.e.f.g.h.i.j.k.l.m.n.o.p.q.r.s.t.u.v.w.x.y.z.a.b.c.d.e.f.g.h.i.j = 1",
                           "scenario.toml:11:1: error: more than 32 dots in one line"},
                      });
}

TEST_CASE("The limit of an underrun rate with a confidence is a share: another unit is refused where it is written") {
  const std::string expectation =
      "[[expect]]\nsignal = \"*.force.*\"\nmetric = \"underrun_rate\"\nmax = \"1 ms\"\nconfidence = \"95 %\"\n";
  const ReadResult result = read_text(std::string(kSpring) + expectation);
  CHECK_FALSE(result);
  CHECK_THAT(errors_of(result), Contains("'max': ") && Contains("'ms' is a unit of time"));
}
