// A recording contains the files that its scenario names.

#include "src/log/embedded_files.h"

#include <fmt/format.h>

#include <cstring>

#include "evenstep/harness/run.h"
#include "evenstep/text/text_file.h"
#include "recordings.h"
#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;
using internal::append_piece;
using internal::FilePiece;
using internal::pieces_of;

namespace {

/// Reads a recording that contains one file, "trace.csv", in these pieces.
InputLogResult read_with(const std::vector<FilePiece>& pieces, std::uint64_t digest = 0, bool behind_lanes = false) {
  MadeUp file(0, false);
  InputLogHead head = made_up_head();
  head.files.push_back({"trace.csv", digest});
  file.bytes = internal::file_begin();
  file.ends.clear();
  file.add(internal::BlockKind::head, encoded(head));
  if (behind_lanes) file.add(internal::BlockKind::device, encoded(device_slice(0)));
  for (const FilePiece& piece : pieces) file.add(internal::BlockKind::file, encoded(piece));
  return parse_input_log(file.bytes, "made up");
}

std::string refusal_of(const FilePiece& piece) { return errors_of(read_with({piece})); }

std::string error_of(const InputLog& log) {
  const ReadResult scenario = scenario_of(log);
  std::string all;
  for (const Diagnostic& error : scenario.error_or({})) all += text(error) + "\n";
  return all;
}

std::string spring_with_trace_and_motion(const TemporaryFolder& folder) {
  std::string trace = "segment,kind,index,begin_ns,end_ns\n";
  for (int s = 0; s < 40; ++s) {
    const int begin = s * 33'000'000;
    trace += fmt::format("{},visualization,0,{},{}\n", s, begin, begin + 11'000'000);
    for (int n = 0; n < 10; ++n)
      trace +=
          fmt::format("{},step,{},{},{}\n", s, n, begin + 11'000'000 + n * 2'000'000, begin + 13'000'000 + n * 2'000'000);
  }
  std::ofstream(folder / "timing of mine.csv") << trace;
  std::ofstream(folder / "motion.csv") << "t_s,x_m,y_m,z_m\n0,0,0,0\n1,0.1,0,0\n2,0,0.05,0\n";
  return folder / "timing of mine.csv";
}

}  // namespace

TEST_CASE("a file comes out of its pieces as it went in, whatever its length, and is smaller in them where it can be") {
  for (const std::size_t length : {std::size_t{0}, std::size_t{1}, std::size_t{1000}, std::size_t{internal::kMostPieceBytes},
                                   std::size_t{internal::kMostPieceBytes} + 1}) {
    std::string content(length, 'x');
    for (std::size_t i = 0; i < length; i += 7) content[i] = static_cast<char>(i * i >> 3);
    std::string again;
    std::size_t bytes = 0;
    for (const FilePiece& piece : pieces_of(3, content)) {
      REQUIRE(append_piece(piece, again).empty());
      CHECK(piece.file == 3);
      bytes += piece.bytes.size();
    }
    CHECK(again == content);
    CHECK(bytes <= length);
    if (length > 100) CHECK(bytes < length);
  }
}

TEST_CASE("pieces that cannot be are refused with their place: gaps, lengths, what does not unpack, what stands elsewhere") {
  const FilePiece good = pieces_of(0, std::string(1000, 'a')).at(0);
  REQUIRE(good.packed);
  CHECK(read_with({good}).ok());
  const auto changed = [&](auto change) {
    FilePiece piece = good;
    change(piece);
    return refusal_of(piece);
  };
  using Catch::Contains;
  CHECK_THAT(changed([](FilePiece& piece) { piece.file = 1; }), Contains("block 1") && Contains("does not belong"));
  CHECK_THAT(changed([](FilePiece& piece) { piece.offset = 1; }), Contains("does not fit"));
  CHECK_THAT(changed([](FilePiece& piece) { piece.length = 999; }), Contains("does not unpack"));
  CHECK_THAT(changed([](FilePiece& piece) { piece.size = 999; }), Contains("does not fit"));
  CHECK_THAT(changed([](FilePiece& piece) {
               piece.length = 1001;
               piece.size = 1001;
             }),
             Contains("does not unpack"));
  CHECK_THAT(changed([](FilePiece& piece) { piece.length = internal::kMostPieceBytes + 1; }), Contains("does not fit"));
  CHECK_THAT(changed([](FilePiece& piece) { piece.size = kMostEmbeddedBytes + 1; }), Contains("does not fit"));
  CHECK_THAT(changed([](FilePiece& piece) { piece.size = piece.offset = UINT64_MAX; }), Contains("does not fit"));
  CHECK_THAT(changed([](FilePiece& piece) { piece.bytes[piece.bytes.size() / 2] ^= 0x55; }), Contains("does not unpack"));
  CHECK_THAT(changed([](FilePiece& piece) { piece.bytes.resize(5); }), Contains("does not unpack"));
  CHECK_THAT(changed([](FilePiece& piece) { piece.packed = false; }), Contains("another length"));
  CHECK_THAT(errors_of(read_with({good, good})), Contains("block 2") && Contains("does not fit"));
  CHECK_THAT(errors_of(read_with({good}, 0, true)), Contains("block 2") && Contains("does not belong"));
}

TEST_CASE("names of files in a recording have no folder, and nothing that a shell or a disk could take for something else") {
  CHECK(internal::plain_name("/home/somebody/my traces/timing of mine.csv") == "timing_of_mine.csv");
  CHECK(internal::plain_name("../../etc/passwd") == "passwd");
  CHECK(internal::plain_name("/x/..") == "_..");
  CHECK(internal::plain_name("") == "_");
  CHECK(internal::plain_name("a\nb$(c)") == "a_b__c_");
  CHECK(internal::plain_name(std::string(300, 'a') + ".csv").size() == 100);
}

TEST_CASE("a recording replays where the files that its scenario names are gone, and names no folder of the machine") {
  const TemporaryFolder folder;
  const std::string trace = spring_with_trace_and_motion(folder);
  const std::vector<std::string> set{
      "timing={ trace = \"" + trace + "\" }",
      "device.left.motion={ kind = \"recorded\", file = \"" + (folder / "motion.csv") + "\" }",
      "remap.latency=\"60 ms\"",
      "remap.lead=\"20 ms\"",
      "run.duration=\"0.4 s\"",
      "run.warmup=\"0 s\"",
      "run.strategies=[\"direct\", \"phase_locked\"]",
      "expect=[]"};
  RunOptions options;
  options.clock = ClockKind::wall;
  options.allow_no_expectations = true;
  options.record_to = folder / "x";
  const RunOutcome live = run_scenario(read("paper/figure-1-spring.toml", set), options);
  INFO(live.failure << live.repeat_difference);
  REQUIRE(live.exit == ExitCode::pass);
  std::filesystem::remove(trace);
  std::ofstream(folder / "motion.csv") << "something else\n";

  const InputLogResult log = read_input_log(folder / "x");
  INFO(errors_of(log));
  REQUIRE(log);
  CHECK(log->head.files.size() == 2);
  CHECK(log->files.size() == 2);
  CHECK(log->head.scenario_text.find(folder.path().string()) == std::string::npos);
  CHECK(log->head.scenario_file.find('/') != 0);
  const ReadResult scenario = scenario_of(*log);
  for (const Diagnostic& error : scenario.error_or({})) UNSCOPED_INFO(text(error));
  REQUIRE(scenario);
  CHECK(scenario->resolved_toml == log->head.scenario_text);
  RunOptions again;
  again.clock = ClockKind::wall;
  again.allow_no_expectations = true;
  again.replayed = &*log;
  const RunOutcome replayed = run_scenario(*scenario, again);
  INFO(replayed.failure << replayed.repeat_difference);
  CHECK(replayed.exit == ExitCode::pass);
  CHECK(replayed.record.trace_hash == live.record.trace_hash);

  InputLog cut = *log;
  cut.files.begin()->second.pop_back();
  CHECK_THAT(error_of(cut), Catch::Contains("is not whole in the recording"));
}

TEST_CASE("a file that is not in a recording must be what it was, and so must a plug-in, which never is") {
  const TemporaryFolder folder;
  const std::string trace = spring_with_trace_and_motion(folder);
  MadeUp file(1);
  InputLogResult log = parse_input_log(file.bytes, "made up");
  REQUIRE(log);
  log->head.scenario_text = "format = 1\n[timing]\ntrace = \"" + trace + "\"\n";
  log->head.files = {{trace, 5}};
  CHECK_THAT(error_of(*log), Catch::Contains("is not what it was") && Catch::Contains("not in the recording"));
  log->head.scenario_text = "format = 1\n[scene]\nlibrary = \"/no/libmine.so\"\n";
  log->head.files = {{"/no/libmine.so", 5}};
  CHECK_THAT(error_of(*log), Catch::Contains("the plug-in '/no/libmine.so' is not there") &&
                                 Catch::Contains("plug-ins are not part of a recording"));
}
