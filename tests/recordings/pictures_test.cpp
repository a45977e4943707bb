// Recordings of pictures: every combination of columns that PresentMon's options make, and what other tools write.
#include <cstdio>

#include "catch.h"
#include "evenstep/recordings/roles.h"
#include "profile_texts.h"
#include "real_files.h"
#include "support.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

/// PresentMon's options that change its columns (its CsvOutput.cpp and README, 2.5).
struct PresentMonOptions {
  const char* time;  ///< "s", "ms", "qpc", "qpc ms", "date"
  char metrics;      ///< '1', '2' or 'd' for the default
  bool gpu, display, frame_type, others;
};

/// Frame k begins on the CPU at 100 + 20 k ms and is handed over 5 ms later; the GPU draws it from 3 to 11 ms.
constexpr int kFrames = 4;

/// An instant in the unit of its column.
std::string instant(const std::string& unit, int ms) {
  char text[64];
  if (unit == "date")
    std::snprintf(text, sizeof text, "2026-5-1 9:%02d:%02d.%09d", ms / 60'000, ms / 1000 % 60, ms % 1000 * 1'000'000);
  else if (unit == "qpc")
    std::snprintf(text, sizeof text, "%d", ms * 10'000);
  else if (unit == "ms" || unit == "qpc ms")
    std::snprintf(text, sizeof text, "%d.0000", ms);
  else
    std::snprintf(text, sizeof text, "%.6f", ms / 1000.0);
  return text;
}

class WrittenTable {
 public:
  template <class Value>
  void column(const std::string& name, const Value& value) {
    header_ += (header_.empty() ? "" : ",") + name;
    for (int k = 0; k < kFrames; ++k) rows_[k] += (rows_[k].empty() ? "" : ",") + std::string(value(k));
  }
  std::string text() const {
    std::string all = header_ + "\n";
    for (const std::string& row : rows_) all += row + "\n";
    return all;
  }

 private:
  std::string header_, rows_[kFrames];
};

std::string written(const PresentMonOptions& options) {
  WrittenTable table;
  const auto same = [&](const std::string& name, const std::string& value) {
    table.column(name, [&](int) { return value; });
  };
  const auto at = [&](const std::string& name, const std::string& unit, int ms) {
    table.column(name, [&](int k) { return instant(unit, 100 + 20 * k + ms); });
  };
  const std::string time = options.time;
  same("Application", "a.exe");
  same("ProcessID", "7");
  same("SwapChainAddress", "0x1");
  same(options.metrics == '1' ? "Runtime" : "PresentRuntime", "DXGI");
  same("SyncInterval", "1");
  same("PresentFlags", "0");
  if (options.metrics == '1') {
    same("Dropped", "0");
    at("TimeInSeconds", time == "date" ? "date" : "s", 5);
    same("msInPresentAPI", "0.05");
    same("msBetweenPresents", "20.0000");
    if (options.display) {
      same("AllowsTearing", "0");
      same("PresentMode", "Hardware: Legacy Flip");
      same("msUntilRenderComplete", "6.0000");
      same("msUntilDisplayed", "8.0");
      same("msBetweenDisplayChange", "20.0");
    }
    if (options.gpu) {
      same("msUntilRenderStart", "-2.0000");
      same("msGPUActive", "7.5");
    }
    if (time == "qpc") at("QPCTime", "qpc", 5);
    if (time == "qpc ms") at("QPCTime", "s", 5);  // it divides the milliseconds by 1000
    if (options.others) same("FrameId", "3");
    return table.text();
  }
  if (options.display) {
    same("AllowsTearing", "0");
    same("PresentMode", "Composed: Flip");
  }
  if (options.frame_type) table.column("FrameType", [](int k) { return k == 2 ? "Intel XeSS-FG" : "Application"; });
  if (options.others) same("HybridPresent", "0");
  if (options.metrics == 'd') {
    if (time == "ms") at("TimeInMs", "ms", 5);
    if (time == "qpc") at("TimeInQPC", "qpc", 5);
    if (time == "date") at("TimeInDateTime", "date", 5);
    if (time == "s" || time == "qpc ms") at("TimeInSeconds", "s", 5);
    same("MsBetweenSimulationStart", "NA");
    same("MsBetweenPresents", "20.0");
    if (options.display) same("MsBetweenDisplayChange", "20.0");
    same("MsInPresentAPI", "0.05");
    same("MsRenderPresentLatency", "6.0000");
    if (options.display) same("MsUntilDisplayed", "8.0");
    if (time == "ms") at("CPUStartTimeInMs", "ms", 0);
    if (time == "qpc") at("CPUStartQPC", "qpc", 0);
    if (time == "qpc ms") at("CPUStartQPCTimeInMs", "qpc ms", 0);
    if (time == "date") at("CPUStartDateTime", "date", 0);
    if (time == "s") at("CPUStartTimeInSeconds", "s", 0);
    same("MsBetweenAppStart", "20.0");
  } else {
    if (time == "ms" || time == "s") at("CPUStartTime", time, 0);
    if (time == "qpc") at("CPUStartQPC", "qpc", 0);
    if (time == "qpc ms") at("CPUStartQPCTime", "qpc ms", 0);
    if (time == "date") at("CPUStartDateTime", "date", 0);
    same("FrameTime", "20.0");
  }
  const std::string ms = options.metrics == 'd' ? "Ms" : "";
  same(ms + "CPUBusy", "15.0");
  same(ms + "CPUWait", "5.0");
  if (options.gpu) {
    same(ms + "GPULatency", "3.0000");
    same(ms + "GPUTime", "8.0000");
    same(ms + "GPUBusy", "7.5");
    same(ms + "GPUWait", "0.5");
  }
  if (options.others) {
    same("AnimationTime", "NA");
    same("MsFlipDelay", "NA");
    same("DisplayTimeAbs", "NA");
    same("EtwBufferFillPct", "1.0");
  }
  return table.text();
}

}  // namespace

TEST_CASE("Every combination of columns that PresentMon's options make is read, with the same pictures") {
  int combinations = 0;
  for (const char* const time : {"s", "ms", "qpc", "qpc ms", "date"}) {
    for (const char metrics : {'1', '2', 'd'}) {
      for (int bits = 0; bits < 16; ++bits) {
        const PresentMonOptions options{time, metrics, (bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0, (bits & 8) != 0};
        const std::string bytes = written(options);
        INFO(bytes);
        const Profile profile = profile_of(bytes);
        ++combinations;
        CHECK(profile.only_visualizations);
        // What the file says of the GPU: begin and end of a picture after the CPU began it.
        const bool v1 = metrics == '1';
        const bool present = v1 ? options.display : metrics == 'd' && !options.gpu;
        const bool begin_known = v1 ? options.display && options.gpu : options.gpu;
        const bool whole = v1 ? !options.display : metrics == '2' && !options.gpu;
        const std::int64_t begin = begin_known ? 3 : present ? 5 : v1 ? -15 : 0;
        const std::int64_t end = begin_known || present ? 11 : begin + 20;
        CHECK(profile.whole_frames == whole);
        const bool made_up = options.frame_type && !v1;
        REQUIRE(profile.intervals.size() == (made_up ? 3 : 4));
        CHECK(profile.left_out.size() == (made_up ? 1 : 0));
        for (std::size_t i = 0; i < profile.intervals.size(); ++i) {
          const ProfileInterval& one = profile.intervals[i];
          const std::int64_t frame = made_up && i == 2 ? 3 : static_cast<std::int64_t>(i);
          CHECK((one.begin - profile.intervals.front().begin).ns == frame * 20'000'000);
          CHECK((one.end - one.begin).ns == (end - begin) * 1'000'000);
        }
        const std::int64_t day = std::string(time) == "date" ? 1'777'626'000'000'000'000 : 0;  // 1 May 2026, 9:00
        CHECK(profile.intervals.front().begin.ns == day + (100 + begin) * 1'000'000);
      }
    }
  }
  CHECK(combinations == 5 * 3 * 16);
}

TEST_CASE("PresentMon 2.5's default is read: milliseconds since the begin of the recording") {
  const ProfileResult profile = read_profile(made_file("presentmon-2.5.1.csv"));
  REQUIRE(profile);
  CHECK(profile->intervals.front().begin.ns == 4'100'000 + 3'200'000);
  CHECK(profile->intervals.front().end.ns == 4'100'000 + 3'200'000 + 7'180'000);
  CHECK(profile->time_base.starts_with("ms and ms; "));
}

TEST_CASE("QPC ticks of another frequency than 10 MHz are refused, unless seconds are there, too") {
  const std::string head = "Application,ProcessID,SwapChainAddress,";
  CHECK_THAT(
      refusal(head + "CPUStartQPC,MsBetweenAppStart,MsGPULatency,MsGPUTime\na,1,0x1,1000,16,0,1\na,1,0x1,49000,16,0,1\n"),
      Contains("--qpc_time_ms"));
  const Profile both = profile_of(head +
                                  "TimeInSeconds,QPCTime,msBetweenPresents,msUntilRenderComplete\na,1,0x1,1.000,3000,16,2\n"
                                  "a,1,0x1,1.016,51000,16,2\na,1,0x1,1.032,99000,16,2\n");
  CHECK(both.intervals[0].begin.ns == 1'000'000'000);
}

TEST_CASE("A recording in which the GPU's time is 0 throughout names the options that PresentMon needs") {
  CHECK_THAT(refusal("Application,SwapChainAddress,TimeInSeconds,MsBetweenPresents,MsRenderPresentLatency\na,0x1,1,20,0\n"
                     "a,0x1,1.02,20,0\n"),
             Contains("record without --no_track_gpu and --no_track_display"));
}

TEST_CASE("FrameView and OCAT are read: the GPU's work ends as they say, and begins at the present") {
  const Profile frameview = profile_of(
      "Application,GPU,CPU,Resolution,Runtime,AllowsTearing,ProcessID,SwapChainAddress,SyncInterval,PresentFlags,"
      "PresentMode,"
      "PresentModeNumeric,TimeInSeconds,MsBetweenPresents,MsBetweenDisplayChange,MsInPresentAPI,MsRenderPresentLatency,"
      "MsUntilDisplayed,Render Queue Depth,MsPCLatency\n"
      "a,g,c,1x1,DXGI,0,7,0x1,0,0,Other,4,1.00,20,20,0.1,6,8,2,NA\na,g,c,1x1,DXGI,0,7,0x1,0,0,Other,4,1.02,20,20,0.1,6,8,2,"
      "NA\n");
  REQUIRE(frameview.intervals.size() == 2);
  CHECK(frameview.intervals[1].begin.ns == 1'020'000'000);
  CHECK(frameview.intervals[1].end.ns == 1'026'000'000);
  const Profile ocat = profile_of(
      "Application,ProcessID,SwapChainAddress,Runtime,SyncInterval,PresentFlags,AllowsTearing,PresentMode,WasBatched,"
      "DwmNotified,Dropped,TimeInSeconds,MsBetweenPresents,MsBetweenDisplayChange,MsInPresentAPI,MsUntilRenderComplete,"
      "MsUntilDisplayed\na,7,0x1,DXGI,0,0,0,Other,0,0,0,1.00,20,20,0.1,6,8\na,7,0x1,DXGI,0,0,0,Other,0,0,0,1.02,20,20,0.1,"
      "25,8\n");
  CHECK(ocat.intervals[1].end.ns == 1'045'000'000);
}

TEST_CASE("A log of MangoHud gives whole frames that end at 'elapsed', also behind the lines of log_versioning") {
  const ProfileResult profile = read_profile(made_file("mangohud.csv"));
  REQUIRE(profile);
  CHECK(profile->format == "MangoHud log");
  CHECK(profile->only_visualizations);
  CHECK(profile->whole_frames);
  CHECK(profile->intervals.front().end.ns == 57'387'251);
  CHECK(profile->intervals.front().begin.ns == 57'387'251 - 17'395'900);
  const std::string rows = "fps,frametime,cpu_load,elapsed\n50,20,3,1020000000\n50,20,3,1040000000\n50,20,3,1060000000\n";
  const std::string versioned =
      "v1\n0.8.2\n---------------------SYSTEM INFO---------------------\nos,cpu,gpu,ram\nLinux,c,g,1\n"
      "--------------------FRAME METRICS--------------------\n" +
      rows;
  CHECK(profile_of(versioned).intervals.size() == 3);
}

TEST_CASE("Frame times in microseconds, as MangoHud wrote them up to 0.6, are told by the times between its rows") {
  const Profile old = profile_of("fps,frametime,elapsed\n50,20000,1020000000\n50,20000,1040000000\n50,20000,1060000000\n");
  CHECK(old.intervals.front().begin.ns == 1'000'000'000);
  CHECK(old.time_base.find("frame times in us") != std::string::npos);
}

TEST_CASE("A log with a row every 100 ms is no recording of pictures, and one with several rows a picture is none") {
  std::string slow = "fps,frametime,elapsed\n", fast = slow;
  for (std::int64_t i = 0; i < 20; ++i) {
    slow += "60,16.6667," + std::to_string(1'000'000'000 + 100'000'000 * i) + "\n";
    fast += "60,16.6667," + std::to_string(1'000'000'000 + 5'000'000 * i) + "\n";
  }
  CHECK_THAT(refusal(slow), Contains("is a log of samples, one about every 100 ms") && Contains("log_interval=0"));
  CHECK_THAT(refusal(fast), Contains("is a log of samples, one about every 5 ms"));
  CHECK_THAT(refusal("00, 23-12-2024 16:38:32, Hardware monitoring log v1.6\n01, 23-12-2024 16:38:32, Some GPU\n"
                     "02, 23-12-2024 16:38:32, GPU temperature     ,Framerate   ,Frametime\n"),
             Contains("it is a log of samples") && Contains("line 1 was taken for the header"));
  CHECK_THAT(refusal("0.1% Min FPS,1% Min FPS,97% Percentile FPS,Average FPS\n1,2,3,4\n"), Contains("MangoHud's summary"));
}

TEST_CASE("Steps that are put into whole frames are at their end, and the picture has the rest") {
  const Profile profile =
      profile_of("fps,frametime,elapsed\n50,20,1020000000\n50,20,1040000000\n50,20,1060000000\n100,5,1065000000\n");
  Roles roles;
  roles.visualization = ".";
  roles.steps = 3;
  roles.step_time = {2'000'000};
  const AssignedRolesResult assigned = assign_roles(profile, roles);
  REQUIRE(assigned);
  REQUIRE(assigned->segments.size() == 3);
  const SegmentTiming& first = assigned->segments.front();
  CHECK(first.visualization->end.ns == 14'000'000);
  REQUIRE(first.steps.size() == 3);
  CHECK(first.steps.front().begin.ns == 14'000'000);
  CHECK(first.steps.back().end.ns == 20'000'000);
}

TEST_CASE("A capture of CapFrameX has the pictures that its columns have as rows of PresentMon") {
  const std::string rows =
      "TimeInSeconds,MsBetweenPresents,MsUntilRenderComplete\n0.1,20,6\n0.12,20,7.5\n0.14,20,NA\n0.16,20,5\n";
  const std::string columns =
      R"({"TimeInSeconds":[0.1,0.12,0.14,0.16],"MsBetweenPresents":[20,20.0,20,20],"Dropped":[true,false,false,false],)"
      R"("MsUntilRenderComplete":[6,7.5,null,5],"PresentMode":[1,1,1,1]})";
  const auto capture = [](const std::string& run, const std::string& more = "") {
    return R"({"Hash":"a","Info":{"AppVersion":"1.7.3"},"Runs":[{"CaptureData":)" + run + "}" + more + "]}";
  };
  const Profile profile = profile_of(capture(columns));
  CHECK(profile.format == "CapFrameX capture");
  CHECK(profile.only_visualizations);
  CHECK(intervals_text(profile, 1000) == "picture 100000 106000\npicture 120000 127500\npicture 160000 165000\n");
  CHECK(intervals_text(profile, 1) == intervals_text(profile_of(rows), 1));
  const Profile two = profile_of(capture(columns, R"(,{"CaptureData":{}})"));
  CHECK(two.left_out.back().what == "further runs of the capture, each with a time of its own");
  CHECK(two.intervals.size() == 3);
  CHECK_THAT(refusal(capture(columns).substr(0, 200)), Contains("is it cut off?"));
  CHECK_THAT(refusal(capture(R"({"TimeInSeconds":[0.1,0.2],"MsBetweenPresents":[20]})")), Contains("not of one length"));
  CHECK_THAT(refusal(capture("{}")), Contains("without the times of each picture"));
  CHECK_THAT(refusal(R"({"Runs":[],"CaptureData":1})"), Contains("without a run"));
}
