#include "evenstep/recordings/profile.h"

#include <fstream>

#include "catch.h"
#include "profile_texts.h"
#include "real_files.h"
#include "src/profiles/decimal_time.h"
#include "support.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

std::string parsed(const std::string& bytes, const ProfileOptions& options = {}) {
  return intervals_text(parse_profile(bytes, "x", options), 1);
}

LeftOut first_left_out(const std::string& bytes) {
  const ProfileResult profile = parse_profile(bytes, "x");
  if (!profile || profile->left_out.empty()) return {"nothing", 0, ""};
  return profile->left_out.front();
}

}  // namespace

TEST_CASE("A decimal time is exact in ns, where a double would not be") {
  using internal::decimal_time_ns;
  CHECK(decimal_time_ns("1712195495505583.25", 1000) == 1712195495505583250);
  CHECK(decimal_time_ns("-0.0005", 1000) == -1);
  CHECK(decimal_time_ns("0.00049", 1000) == 0);
  CHECK(decimal_time_ns("3.013", 1000) == 3013);
  CHECK(decimal_time_ns("2076674276", 100) == 207667427600);
  CHECK(decimal_time_ns("1.5e3", 1) == 1500);
  CHECK(decimal_time_ns("1e-3", 1'000'000'000) == 1'000'000);
  CHECK(decimal_time_ns("4000000000000000000", 1) == 4'000'000'000'000'000'000);
  CHECK(decimal_time_ns("0.000000000000000000000000000000000001", 1) == 0);
  for (const char* const text : {"", "NA", "-", ".", "1e", "1e9999", "4000000000000000001", "1 ", " 1", "0x1", "1e30", "nan",
                                 "99999999999999999999999999999999999999999"})
    CHECK_FALSE(decimal_time_ns(text, 1));
}

TEST_CASE("Nsight's statistics are read by their columns, also where a name has commas in it") {
  CHECK(parsed("Start (ns),End (ns),Duration (ns),Name,PID\n5,9,4,\"f<int, 3>\",1\n1,2,1,g,1\n") ==
        "g 1 2\nf<int, 3> 5 9\n");
  CHECK(parsed("Start (ns),Duration (ns),Strm,Name\n5,4,7,f\n") == "f 5 9\n");
}

TEST_CASE("Enter and Leave nest by name in their stream, what is never left is counted") {
  const std::string rows =
      "Name,streamId,Event Type,Timestamp "
      "(ns)\na,1,Enter,1\na,1,Enter,2\na,1,Leave,3\nb,1,Leave,4\na,1,Leave,5\nc,1,Enter,6\n";
  CHECK(parsed(rows) == "a 1 5\na 2 3\n");
  CHECK(first_left_out(rows).what == "rows that leave what was not entered");
}

TEST_CASE("The CSV of trace_processor and of Tracy are read, and rows that have not ended are left out") {
  CHECK(parsed("\"ts\",\"dur\",\"name\",\"track_id\"\n10,5,\"draw\",1\n20,-1,\"open\",1\n") == "draw 10 15\n");
  CHECK(first_left_out("ts,dur,name\n10,5,draw\n20,-1,open\n").what == "rows that have not ended");
  CHECK(parsed("name,src_file,src_line,ns_since_start,exec_time_ns,thread,value\nzone,a.cpp,3,1000,10,1,\n") ==
        "zone 1000 1010\n");
}

TEST_CASE("Any CSV is read by the columns and the unit that are given") {
  ProfileOptions options;
  options.columns = {"what", "t0", "t1", "", "", "ms"};
  CHECK(parsed("// made by a tool\nt0,what,t1\n1.5,a,2\n", options) == "a 1500000 2000000\n");
  options.columns.end = "t2";
  CHECK_THAT(parsed("t0,what,t1\n1.5,a,2\n", options), Contains("no column 't2'; it has 't0', 'what', 't1'"));
  options.columns = {"", "t0", "", "t1", "", "h"};
  CHECK_THAT(parsed("t0,what,t1\n1.5,a,2\n", options), Contains("'h' is no unit"));
}

TEST_CASE("A CSV with unknown columns is refused with these, and what is no recording with the formats") {
  CHECK_THAT(parsed("p50,p99\n1,2\n"), Contains("columns are not known") && Contains("It has 'p50', 'p99'"));
  CHECK_THAT(parsed("hello"), Contains("is no recording that can be read; the formats are sqlite, capframex, chrome-json"));
  CHECK_THAT(parsed(""), Contains("is no recording"));
  ProfileOptions options;
  options.format = "presentmo";
  CHECK_THAT(parsed("a,b\n", options), Contains("did you mean 'presentmon'"));
}

TEST_CASE("What is known to be no recording says what it is, and what would be one") {
  std::string packets;
  for (int i = 0; i < 3; ++i) packets += "\x0a\x04\x08\x90\x4e\x50";
  CHECK_THAT(parsed(packets), Contains("is a trace of Perfetto (protobuf)") && Contains("traceconv json"));
  CHECK_THAT(parsed("\x0ahello\x0aworld\n"), Contains("is no recording that can be read"));
  CHECK_THAT(parsed("fps=59.94\nfocus=769\nfps=60.01\n"), Contains("mean rates of gamescope") && Contains("MangoHud"));
  CHECK_THAT(parsed("Kernel, Calls, Time (ns), Time (%), Average (ns), Min (ns), Max (ns)\ngemm,2,100,100,50,50,50\n"),
             Contains("it has totals of each name"));
}

TEST_CASE("Trace events: X has a length, B and E nest in their thread, fractions of a microsecond count") {
  CHECK(parsed(R"([{"ph":"X","name":"a","ts":1.5,"dur":0.25,"pid":1,"tid":1},{"ph":"B","name":"b","ts":2,"pid":1,"tid":1},
      {"ph":"B","name":"c","ts":3,"pid":1,"tid":1},{"ph":"E","ts":4,"pid":1,"tid":1},{"ph":"E","ts":6,"pid":1,"tid":1},
      {"ph":"B","name":"open","ts":7,"pid":1,"tid":2}])") == "a 1500 1750\nb 2000 6000\nc 3000 4000\n");
  const LeftOut left = first_left_out(R"([{"ph":"X","name":"a","ts":1,"dur":1},{"ph":"B","name":"open","ts":7}])");
  CHECK(left.what == "begins without an end");
  CHECK(left.first == "open");
}

TEST_CASE("Trace events in an object: only traceEvents counts, and args are not the event's own values") {
  CHECK(parsed(R"({"other":[{"ph":"X","name":"no","ts":1,"dur":1}],"displayTimeUnit":"ns","traceEvents":[
      {"ph":"X","name":"a","args":{"name":"x","ts":99,"deep":{"dur":7}},"ts":1,"dur":2,"pid":"p"}],
      "more":{"traceEvents":3}})") == "a 1000 3000\n");
  CHECK_THAT(parsed("{\"a\": 1}"), Contains("is JSON without \"traceEvents\""));
  CHECK_THAT(parsed("{\"traceEvents\": ["), Contains("there is no interval in it"));
  CHECK_THAT(parsed("[{\"ph\":\"X\",\"ts\":1,\"dur\":2},]x"), Contains("x: error:"));
}

TEST_CASE("A list of trace events that is cut off is read up to there") {
  CHECK(parsed("[{\"ph\":\"X\",\"name\":\"a\",\"ts\":1,\"dur\":2},\n{\"ph\":\"X\",\"na") == "a 1000 3000\n");
}

TEST_CASE("JSON that is nested too deeply is refused") {
  CHECK_THAT(parsed(std::string(1000, '[')), Contains("nested more than"));
}

TEST_CASE("PresentMon's encodings give the GPU's interval of each picture") {
  const std::string head =
      "\xEF\xBB\xBF"
      "Application,ProcessID,SwapChainAddress,";
  CHECK(parsed(head + "FrameType,CPUStartQPC,MsBetweenAppStart,MsGPULatency,MsGPUTime\n"
                      "a,1,0x1,Application,1000000,16,0.5,2\na,1,0x1,Application,1160000,16,NA,NA\n") ==
        "a 100500000 102500000\n");
  CHECK(parsed(head + "CPUStartTime,FrameTime,GPULatency,GPUTime\na,1,0x1,100,16,0.5,2\n") == "a 100500000 102500000\n");
  CHECK(parsed(head + "TimeInSeconds,msUntilRenderStart,msUntilRenderComplete\na,1,0x1,0.1,-5,2\n") ==
        "a 95000000 102000000\n");
  CHECK_THAT(
      parsed(head + "CPUStartQPC,MsBetweenAppStart,MsGPULatency,MsGPUTime\na,1,0x1,1000,16,0,1\na,1,0x1,1016,16,0,1\n"),
      Contains("not those of 10 MHz"));
  CHECK_THAT(parsed(head + "GpuBusyP50,GpuBusyP99\na,1,0x1,1,2\n"), Contains("without the times of each picture"));
}

TEST_CASE("Unreal's pictures follow each other, and columns that turn up late are named in the last header") {
  CHECK(parsed("EVENTS,FrameTime,GameThreadTime\n,10,1\n,20,1,4\n,10,1,5\nEVENTS,FrameTime,GameThreadTime,GPUTime\n"
               "[HasHeaderRowAtEnd],1,[platform],x\n") == "GPU 10000000 14000000\nGPU 30000000 35000000\n");
}

TEST_CASE("Control characters of a name do not reach a terminal") {
  CHECK(parsed(R"([{"ph":"X","name":"a\u001b[31m\u0000b","ts":1,"dur":2}])") == "a [31m b 1000 3000\n");
}

TEST_CASE("A gzip stream that is damaged or cut off is an error") {
  CHECK_THAT(parsed("\x1f\x8b\x08 nothing of the kind"), Contains("is damaged"));
}
