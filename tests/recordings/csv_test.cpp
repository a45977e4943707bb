// How a CSV is written: its header, separators and numbers; and the columns that profilers write.
#include "catch.h"
#include "evenstep/recordings/profile.h"
#include "profile_texts.h"
#include "real_files.h"
#include "support.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

std::string in_us(const ProfileResult& profile) { return intervals_text(profile, 1000); }

std::string rows_in_us(const std::string& bytes, const ProfileOptions& options = {}) {
  return in_us(parse_profile(bytes, "x", options));
}

/// UTF-16 of ASCII, with a byte order mark.
std::string utf16(const std::string& ascii, bool big) {
  std::string all = big ? "\xFE\xFF" : "\xFF\xFE";
  for (const char c : ascii) {
    all += big ? '\0' : c;
    all += big ? c : '\0';
  }
  return all;
}

const std::string kRows = "Name,Start (us),Duration (us)\na,1,2\nb,3.5,1\n";
const std::string kRead = "a 1 3\nb 3 4\n";

}  // namespace

TEST_CASE("A header is found behind notices, tables of another kind, comments and a byte order mark") {
  CHECK(rows_in_us(kRows) == kRead);
  CHECK(rows_in_us("\xEF\xBB\xBF" + kRows) == kRead);
  CHECK(rows_in_us("NOTICE: Existing SQLite export found: x.sqlite\n\nProcessing [x.sqlite] with [trace.py], wait...\n\n" +
                   kRows) == kRead);
  CHECK(rows_in_us("os,cpu,gpu\nLinux,c,g\n\n# a comment, with a comma\n// another, one\n" + kRows) == kRead);
}

TEST_CASE("UTF-16 of both orders is read, also without its mark, and characters of two units") {
  CHECK(rows_in_us(utf16(kRows, false)) == kRead);
  CHECK(rows_in_us(utf16(kRows, true)) == kRead);
  CHECK(rows_in_us(utf16(kRows, false).substr(2)) == kRead);
  CHECK(rows_in_us(utf16("[{\"ph\":\"X\",\"name\":\"a\",\"ts\":1,\"dur\":2}]", false)) == "a 1 3\n");
  std::string row = utf16("Name,Start (us),Duration (us)\n", false);
  row +=
      std::string("\xE4\x00\x3D\xD8\x00\xDE\x00\xD8", 8) + utf16(",1,2\n", false).substr(2);  // ä, a face, half of another
  CHECK(rows_in_us(row) == "\xC3\xA4\xF0\x9F\x98\x80\xEF\xBF\xBD 1 3\n");
}

TEST_CASE("Semicolons and tabs separate cells as commas do, and quotes may hold them and ends of lines") {
  CHECK(rows_in_us("Name;Start (us);Duration (us)\na;1;2\nb;3.5;1\n") == kRead);
  CHECK(rows_in_us("Name\tStart (us)\tDuration (us)\na\t1\t2\nb\t3.5\t1\n") == kRead);
  CHECK(rows_in_us("Name,Start (us),Duration (us)\n\"f<int,\nchar>\",1,2\n\"q\"\"q\",4,1\n") ==
        "f<int, char> 1 3\nq\"q 4 5\n");
  CHECK_THAT(rows_in_us("Name,Start (us),Duration (us)\na,1,2\n\"open,1,2\nb,1,2\n"),
             Contains("line 3: a quote that is opened there is not closed"));
}

TEST_CASE("Decimal commas and separators between thousands are told by the numbers themselves") {
  const std::string head = "Name;Start (us);Duration (us)\n";
  CHECK(rows_in_us(head + "a;1,5;2,5\n") == "a 1 4\n");
  CHECK(rows_in_us(head + "a;1.234,5;2\n") == "a 1234 1236\n");
  CHECK(rows_in_us(head + "a;1,234.5;2\n") == "a 1234 1236\n");
  CHECK(rows_in_us(head + "a;1 234 567;2\nb;1'234'569;1\n") == "a 1234567 1234569\nb 1234569 1234570\n");
  CHECK(rows_in_us(head + "a;1\xC2\xA0"
                          "234;2\nb;2\xE2\x80\xAF"
                          "000;2\n") == "a 1234 1236\nb 2000 2002\n");
  CHECK(rows_in_us(head + "a;1,234;2\n") == "a 1 3\n");  // semicolons: a comma is the decimal sign
  CHECK(rows_in_us(head + "a;1.234.567;2\n") == "a 1234567 1234569\n");
  const std::string commas = "Name,Start (us),Duration (us)\n";
  CHECK(rows_in_us(commas + "a,\"1,234\",2\n") == "a 1234 1236\n");
  CHECK(rows_in_us(commas + "a,\"11,5\",2\n") == "a 11 13\n");
}

TEST_CASE("A spreadsheet in German is read") {
  const ProfileResult profile = read_profile(made_file("excel-de.csv"));
  CHECK(in_us(profile).starts_with("draw 0 11100\nstep 11100 12500\nstep 12550 13950\n"));
  REQUIRE(profile);
  CHECK(profile->time_base == "ms, as the header of its columns says; with decimal commas");
}

TEST_CASE("A CSV whose columns are not known is refused with the line taken for its header, and why") {
  CHECK_THAT(
      rows_in_us("made by a tool\np50;p99\n1,5;2\n"),
      Contains("x:2:1: error: is a CSV whose columns are not known") && Contains("It has 'p50', 'p99'") &&
          Contains("line 2 was taken for the header, split at semicolons, because it is the first one that has as many "
                   "cells (2) as the next") &&
          Contains("--header LINE"));
  CHECK_THAT(rows_in_us("Name,Calls,TotalDurationNs\na,2,3\n"), Contains("has totals of each name, not single intervals"));
}

TEST_CASE("The line of the header can be given where guessing fails, and so can its columns") {
  ProfileOptions options;
  options.columns = {"what", "t0", "t1", "", "", "us"};
  CHECK(rows_in_us("a,b\n1,2\nt0,what,t1\n1.5,x,4\n", options) == "x 1 4\n");
  options.header = 4;
  CHECK(rows_in_us("a,b,c\nd,e,f\nt0,what,t1\nt0,what,t1\n1.5,x,4\n", options) == "x 1 4\n");
  options.header = 9;
  CHECK_THAT(rows_in_us("t0,what,t1\n1.5,x,4\n", options), Contains("there is no column 'what'"));
  options = {};
  options.header = 9;
  CHECK_THAT(rows_in_us("t0,what,t1\n1.5,x,4\n", options), Contains("--header 9: there is no such line"));
  options.header = 1;
  CHECK_THAT(rows_in_us("a,b\nName,ts,dur\nx,1,2\n", options),
             Contains("line 1 was taken for the header") && Contains("because --header says so"));
}

TEST_CASE("rocprofv3's kernel traces of three generations are read, with agents as sources and queues as tracks") {
  const ProfileResult file = read_profile(made_file("rocprofv3.csv"));
  REQUIRE(file);
  CHECK(file->format == "rocprofv3 CSV");
  CHECK(file->names.front().text == "draw(float4*, int)");
  CHECK(file->names.front().category == "kernel");
  CHECK(file->sources == std::vector<std::string>{"Agent 2"});
  REQUIRE(file->tracks.size() == 1);
  CHECK(file->tracks.front().lane == "queue 1");
  CHECK(file->tracks.front().order == TrackOrder::follow);
  CHECK(file->intervals.front().begin.ns == 172'352'210'005'122);
  // The first generation has a number for the agent and no stream, rocpd's a Guid first.
  const ProfileResult first = parse_profile(
      "\"Kind\",\"Agent_Id\",\"Queue_Id\",\"Kernel_Id\",\"Kernel_Name\",\"Correlation_Id\",\"Start_Timestamp\",\"End_"
      "Timestamp\"\n"
      "\"KERNEL_DISPATCH\",2,1,3,\"step\",1,1000,3000\n\"KERNEL_DISPATCH\",2,2,3,\"step\",1,2000,4000\n",
      "x");
  CHECK(in_us(first) == "step 1 3\nstep 2 4\n");
  CHECK(first->sources == std::vector<std::string>{"Agent 2"});
  CHECK(first->tracks.size() == 2);
  CHECK(rows_in_us("\"Guid\",\"Kind\",\"Agent_Id\",\"Queue_Id\",\"Stream_Id\",\"Thread_Id\",\"Dispatch_Id\",\"Kernel_Id\","
                   "\"Kernel_Name\",\"Correlation_Id\",\"Start_Timestamp\",\"End_Timestamp\"\n"
                   "\"00006409-00d1\",\"KERNEL_DISPATCH\",\"Agent 4\",1,0,71,1,3,\"step\",1,1000,3000\n") == "step 1 3\n");
}

TEST_CASE("rocprofv3's markers and copies are read, and rocprof's first CSV") {
  const ProfileResult markers = parse_profile(
      "\"Domain\",\"Function\",\"Process_Id\",\"Thread_Id\",\"Correlation_Id\",\"Start_Timestamp\",\"End_Timestamp\"\n"
      "\"MARKER_CORE_RANGE_API\",\"step\",71,72,1,1000,3000\n",
      "x");
  CHECK(in_us(markers) == "step 1 3\n");
  CHECK(markers->names.front().category == "range");
  CHECK(markers->sources.front() == "process 71");
  CHECK(markers->tracks.front().order == TrackOrder::nest);
  const ProfileResult copies = parse_profile(
      "\"Kind\",\"Direction\",\"Stream_Id\",\"Source_Agent_Id\",\"Destination_Agent_Id\",\"Correlation_Id\","
      "\"Start_Timestamp\",\"End_Timestamp\"\n\"MEMORY_COPY\",\"MEMORY_COPY_HOST_TO_DEVICE\",0,0,2,1,1000,3000\n",
      "x");
  CHECK(in_us(copies) == "MEMORY_COPY_HOST_TO_DEVICE 1 3\n");
  CHECK(copies->names.front().category == "copy");
  CHECK(rows_in_us("\"Index\",\"KernelName\",\"gpu-id\",\"queue-id\",\"queue-index\",\"pid\",\"tid\",\"DispatchNs\","
                   "\"BeginNs\",\"EndNs\"\n"
                   "0,\"step.kd\",1,0,0,71,72,500,1000,3000\n") == "step.kd 1 3\n");
}

TEST_CASE("Intel's unitrace: kernels are its GPU operations") {
  const ProfileResult profile = parse_profile(
      R"([{"ph":"X","name":"step[SIMD16]","pid":1,"tid":2,"ts":1,"dur":2,"cat":"gpu_op"},
          {"ph":"X","name":"zeSubmit","pid":1,"tid":3,"ts":0,"dur":1,"cat":"cpu_op"}])",
      "x");
  REQUIRE(profile);
  CHECK(profile->names[profile->intervals[1].name].category == "kernel");
  CHECK(profile->tracks[profile->intervals[1].track].order == TrackOrder::follow);
}
