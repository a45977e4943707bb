// The check of every OpenCL device, shortened: what it finds is real, and how long anything takes is not judged.
#include "evenstep/campaigns/opencl_check.h"

#include "catch.h"
#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;
using State = OpenClCheckRow::State;

namespace {

OpenClCheckOptions short_check() {
  OpenClCheckOptions options;
  options.read = [](const std::string& file, const std::vector<std::string>& set) {
    return read_scenario(std::string(EVENSTEP_SOURCE_DIR) + "/" + file, {set, std::nullopt, {}, true});
  };
  options.blocks = {{{5, 5, 5}, 120}};
  options.timed = Duration{10'000'000};
  options.recorded = Duration{200'000'000};
  options.live = Duration{1'000'000'000};
  options.overrides = small_tissue("opencl");
  options.overrides.erase(options.overrides.begin() + 3);  // the run's length is the check's
  return options;
}

const OpenClCheckRow& row_of(const OpenClCheck& check, const std::string& begin) {
  for (const OpenClCheckRow& row : check.rows)
    if (row.what.substr(0, begin.size()) == begin) return row;
  FAIL("no row " << begin);
  throw 0;
}

}  // namespace

TEST_CASE(
    "Every OpenCL device of this machine computes the bits of the CPU, and its table has times, recordings, a live run") {
  for (const OpenClListed& device : opencl_devices()) {
    std::vector<std::string> announced;
    OpenClCheckOptions options = short_check();
    options.progress = [&](const std::string& what) { announced.push_back(what); };
    const OpenClCheck check = check_opencl(device, options);
    INFO(check_table({check}, machine_here()));
    CHECK(check.rows.size() == 3 + 1 + 3 + 1);
    CHECK(announced.size() == check.rows.size());
    CHECK(check.description.device == device.device);
    CHECK(check.description.platform == device.platform);
    CHECK_FALSE(check.any(State::differs));
    CHECK_THAT(row_of(check, "bits").text, Contains("18 of 18 equal"));
    CHECK_THAT(row_of(check, "Figure 1").text, Contains(", the same"));
    CHECK_THAT(row_of(check, "steps of 120 particles").text, Contains("6 commands a step") || Contains("7 commands a step"));
    CHECK_THAT(row_of(check, "recording of Figure 1, visualization \"11.1 ms\"").text, Contains("a step p50"));
    CHECK_THAT(row_of(check, "recording of Figure 1, visualization \"burn").text,
               Contains("a kernel kept the compute device"));
    for (const char* drawn : {"recording of Figure 1, visualization \"render", "live run"}) {
      const OpenClCheckRow& row = row_of(check, drawn);  // a machine without OpenGL says why
      if (row.state == State::found) CHECK_THAT(row.text, Contains("the tissue is drawn"));
      if (row.state == State::missing) CHECK_THAT(row.text, Contains("; "));
    }
  }
}

TEST_CASE("What cannot be checked is a row with its reason, what differs is marked, and a driver's words break no table") {
  const OpenClCheck absent = check_opencl({"a platform", "no | such\ndevice", false}, short_check());
  for (const OpenClCheckRow& row : absent.rows) {
    CHECK(row.state == State::missing);
    CHECK_THAT(row.text, Contains("no OpenCL device or platform is called"));
  }
  OpenClCheck wrong = absent;
  wrong.rows.resize(1);
  wrong.rows[0] = {"bits", "17 of 18 equal", State::differs};
  CHECK(wrong.any(State::differs));
  RecordedMachine machine;
  machine.processors = 2;
  machine.processor = "cpu";
  machine.system = "Linux";
  CHECK(check_table({wrong}, machine) ==
        "| no   such device (a platform) | |\n|---|---|\n| host | 2 x cpu, Linux |\n| bits | DIFFERS: 17 of 18 equal |\n\n");
  CHECK_THAT(check_table({absent}, machine), Contains("| missing: no OpenCL device"));
}

TEST_CASE("A device that does not say when its commands ran is said to be one, and no length is 0 because of it") {
  const DeviceCommand timed{"advance", 10'000, 11'000, 12'000, 15'000}, silent{"advance"};
  CHECK(check_text({timed, timed, timed, timed}, 2) == "on the device 2 commands a step, which run for 6.0 us");
  CHECK(check_text({timed, timed, timed, silent}, 2) == "on the device 2 commands a step, whose times it does not say");
  RecordSummary summary;
  summary.host = {1'000'000, 2'000'000, 3'000'000};
  summary.visualization = {11'000'000, 11'000'000, 12'000'000};
  CHECK(check_text(summary) ==
        "a step p50 1.000, p99 2.000, max 3.000 ms, on the device unknown; a visualization p50 11.000, max 12.000 ms");
  summary.steps_on_device = 15;
  summary.span = {500'000, 600'000, 700'000};
  summary.steps_beyond_host = 1;
  CHECK_THAT(check_text(summary),
             Contains("on the device p50 0.500, p99 0.600;") && Contains("; 1 steps longer on the device than on the host"));
}

TEST_CASE("A check that is interrupted ends before its next row") {
  const std::atomic<bool> interrupted{true};
  OpenClCheckOptions options = short_check();
  options.interrupted = &interrupted;
  CHECK(check_opencl({"a platform", "a device", false}, options).rows.empty());
}
