// The file of a recording: what is read from a file that was cut or changed anywhere, or whose writer was killed.

#include <unistd.h>

#include <sys/mman.h>
#include <sys/wait.h>
#include <csignal>
#include <cstring>
#include <thread>

#include "bytes_for.h"
#include "cases.h"
#include "evenstep/harness/recorded_timing.h"
#include "evenstep/recordings/timing_csv.h"
#include "evenstep/scheduler/random.h"
#include "evenstep/text/text_file.h"
#include "recordings.h"
#include "src/live/message_ring.h"
#include "src/log/crc32c.h"
#include "src/log/writer.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

std::uint64_t below(std::uint64_t& state, std::uint64_t limit) {
  return (state = spread(state + 0x9e3779b97f4a7c15ULL)) % limit;
}

}  // namespace

TEST_CASE("the checksum is CRC-32C: the check value of its polynomial, and a vector of RFC 3720") {
  const std::string_view digits = "123456789";
  CHECK(internal::crc32c(std::as_bytes(std::span(digits))) == 0xE3069283U);
  CHECK(internal::crc32c(Bytes(32)) == 0x8A9136AAU);
}

TEST_CASE("messages of any length come out of the ring as they went in, or are refused as a whole, 50,000 times") {
  internal::MessageRing ring(1000);
  std::uint64_t state = 1, pushed = 0, popped = 0, refused = 0;
  const auto message_of = [](std::uint64_t i) {
    std::uint64_t length = i;
    return Bytes(below(length, 300), static_cast<std::byte>(i));
  };
  Bytes message;
  while (popped < 50'000) {
    if (below(state, 2) == 0)
      ++(ring.push(message_of(pushed)) ? pushed : refused);
    else if (ring.pop(message))
      REQUIRE(message == message_of(popped++));
  }
  CHECK(refused > 1000);
  while (ring.pop(message)) REQUIRE(message == message_of(popped++));
  CHECK(popped == pushed);
  CHECK_FALSE(ring.push(Bytes(997)));
  CHECK(ring.push(Bytes(996)));
}

TEST_CASE("messages from another thread come out of the ring as they went in") {
  internal::MessageRing ring(2000);
  const auto wait = [] { std::this_thread::sleep_for(std::chrono::microseconds(50)); };
  std::thread writer([&] {
    for (std::uint64_t i = 0; i < 2000; ++i) {
      while (!ring.push(Bytes(i % 300, static_cast<std::byte>(i)))) wait();
    }
  });
  std::uint64_t wrong = 0;
  Bytes message;
  for (std::uint64_t i = 0; i < 2000; ++i) {
    while (!ring.pop(message)) wait();
    wrong += message != Bytes(i % 300, static_cast<std::byte>(i));
  }
  writer.join();
  CHECK(wrong == 0);
}

TEST_CASE("a recording that is cut at any byte is read up to its last whole block") {
  const MadeUp whole(6);
  REQUIRE(parse_input_log(whole.bytes, "x")->end);
  std::size_t blocks = 0;
  for (std::size_t length = 0; length < whole.bytes.size(); length += testing::kShare) {
    while (blocks < whole.ends.size() && whole.ends[blocks] <= length) ++blocks;
    const InputLogResult read = parse_input_log(std::span(whole.bytes).first(length), "x");
    INFO(length << " of " << whole.bytes.size() << " bytes: " << errors_of(read));
    REQUIRE(read.ok() == (blocks > 0));
    if (!read) continue;
    REQUIRE(read->blocks == static_cast<std::int64_t>(blocks));
    REQUIRE(read->bytes + read->left_bytes == static_cast<std::int64_t>(length));
    REQUIRE_FALSE(read->end);
    REQUIRE_FALSE(read->damaged);
    REQUIRE(read->inputs[0].ticks.size() == 20 * (blocks / 2));
    REQUIRE(read->rows.steps.size() == 9 * ((blocks - 1) / 2));
    REQUIRE(read->until() == RealTime{20'000'000 * static_cast<std::int64_t>((blocks - 1) / 2)});
  }
}

TEST_CASE("a file is read as its bytes are, wherever it was cut") {
  const TemporaryFolder folder;
  const MadeUp whole(6);
  for (std::size_t length = 0; length <= whole.bytes.size(); length += 97) {
    const std::string path = folder / "cut";
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(whole.bytes.data()), static_cast<std::streamsize>(length));
    const InputLogResult of_bytes = parse_input_log(std::span(whole.bytes).first(length), path);
    const InputLogResult of_file = read_input_log(path);
    INFO(length << " bytes");
    REQUIRE(errors_of(of_file) == errors_of(of_bytes));
    REQUIRE(of_file.ok() == of_bytes.ok());
    if (!of_file) continue;
    REQUIRE(of_file->blocks == of_bytes->blocks);
    REQUIRE(of_file->left_bytes == of_bytes->left_bytes);
    REQUIRE(of_file->inputs[0].ticks.size() == of_bytes->inputs[0].ticks.size());
  }
}

TEST_CASE("a device that was away is away in the recording, too") {
  for (const auto& [drivable, away] : {std::pair{true, false}, {false, false}, {false, true}}) {
    DeviceSample sample;
    sample.drivable = drivable;
    sample.away = away;
    const auto read = internal::decode<DeviceSample>(encoded(sample));
    REQUIRE(read);
    CHECK(read->drivable == drivable);
    CHECK(read->away == away);
  }
  Bytes wrong = encoded(DeviceSample{});
  wrong.back() = std::byte{3};
  CHECK_FALSE(internal::decode<DeviceSample>(wrong));
}

namespace {

/// Writes a recording of this many slices of 20 ms, without keeping it in memory.
void write_long(const std::string& path, std::int64_t slices, bool device_too = true) {
  std::ofstream out(path, std::ios::binary);
  std::uint64_t blocks = 0;
  const auto write = [&](const Bytes& bytes) {
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  };
  write(internal::file_begin());
  write(internal::block_bytes(internal::BlockKind::head, blocks++, encoded(made_up_head())));
  for (std::int64_t i = 0; i < slices; ++i) {
    if (device_too) write(internal::block_bytes(internal::BlockKind::device, blocks++, encoded(device_slice(i))));
    write(internal::block_bytes(internal::BlockKind::simulation, blocks++, encoded(simulation_slice(i))));
  }
  REQUIRE(out.flush());
}

std::int64_t bytes_to_read(const std::string& path, const std::string& folder, std::int64_t slices) {
  return bytes_for([&] {
    const InputLogResult read = read_input_log(path, {false, std::make_shared<RowFiles>(folder)});
    return read && read->inputs[0].ticks.size() == static_cast<std::size_t>(20 * slices) &&
           read->inputs[0].ticks.back().sample.sequence == 20 * slices - 1;
  });
}

/// The most memory needed to write the timing as `import` and `replay --timing` do.
std::int64_t bytes_to_write_timing(const std::string& path, const std::string& folder, const std::string& timing) {
  return bytes_for([&] {
    const InputLogResult read = read_input_log(path, {false, std::make_shared<RowFiles>(folder)});
    const auto write = [&](std::ostream& out) { write_recorded_timing(read->rows, out); };
    return read && internal::write_text_file(timing, write).empty();
  });
}

std::int64_t size_of(const std::string& path) { return static_cast<std::int64_t>(std::filesystem::file_size(path)); }

}  // namespace

// Left out with sanitizers, because their allocators keep what was freed.
TEST_CASE("a recording of twenty minutes needs no more memory to be read than one of twenty seconds", "[sweep]") {
  const TemporaryFolder folder;
  constexpr std::int64_t kBrief = 1000, kLong = 60'000;
  write_long(folder / "brief", kBrief);
  write_long(folder / "long", kLong);
  const std::int64_t brief = bytes_to_read(folder / "brief", folder.path(), kBrief);
  const std::int64_t lasting = bytes_to_read(folder / "long", folder.path(), kLong);
  const std::int64_t row_bytes = 20 * kLong * static_cast<std::int64_t>(sizeof(TickInput) + sizeof(LiveTick)),
                     file_bytes = size_of(folder / "long");
  INFO(brief << " bytes for " << kBrief << " slices, " << lasting << " for " << kLong << "; the file has " << file_bytes
             << " bytes, the rows of its ticks have " << row_bytes);
  constexpr std::int64_t kMost = 96 << 20;  // 32 MiB of pages may stay, and what comes until they are given back
  CHECK(row_bytes > kMost);
  CHECK(file_bytes > kMost);
  CHECK(lasting - brief < kMost);
}

TEST_CASE("to write the timing of an hour that was recorded needs no more memory than of twenty seconds", "[sweep]") {
  const TemporaryFolder folder;
  constexpr std::int64_t kBrief = 1000, kLong = 180'000;
  write_long(folder / "brief", kBrief, false);
  write_long(folder / "long", kLong, false);
  const std::int64_t brief = bytes_to_write_timing(folder / "brief", folder.path(), folder / "brief.csv");
  const std::int64_t lasting = bytes_to_write_timing(folder / "long", folder.path(), folder / "long.csv");
  INFO(brief << " bytes for " << kBrief << " slices, " << lasting << " for " << kLong << "; the timing has "
             << size_of(folder / "long.csv"));
  constexpr std::int64_t kMost = 64 << 20;  // 32 MiB of pages may stay, and what comes until they are given back
  CHECK(size_of(folder / "long.csv") > kMost);
  CHECK(lasting - brief < kMost);
  const TimingCsv timing = read_timing_csv(folder / "brief.csv");
  REQUIRE(timing);
  CHECK(timing->size() == kBrief);
}

TEST_CASE("a bit that is changed anywhere is found, with its place, and what stands before it can be read") {
  const MadeUp whole(3);
  std::size_t block = 0;
  for (std::size_t at = 0; at < whole.bytes.size(); at += testing::kShare) {
    while (whole.ends[block] <= at) ++block;
    Bytes changed = whole.bytes;
    changed[at] ^= std::byte{1} << (at % 8);
    const InputLogResult read = parse_input_log(changed, "x"), before = parse_input_log(changed, "x", {true});
    INFO("byte " << at << ": " << errors_of(before));
    REQUIRE_FALSE(read);
    REQUIRE_THAT(read.error().front().file, Catch::StartsWith("x:"));
    REQUIRE(before.ok() == (block > 0));
    if (!before) continue;
    REQUIRE(before->blocks == static_cast<std::int64_t>(block));
    REQUIRE(before->damaged);
  }
}

TEST_CASE("what is no recording, or one of another version, is refused with what to do") {
  const auto error_of = [](const Bytes& bytes) { return errors_of(parse_input_log(bytes, "file")); };
  const MadeUp whole(1);
  CHECK_THAT(error_of({}), Catch::StartsWith("file:0: ") && Catch::Contains("--record FILE"));
  Bytes later = whole.bytes;
  later[16] = std::byte{99};
  CHECK_THAT(error_of(later), Catch::StartsWith("file:16: ") && Catch::Contains("version 99") &&
                                  Catch::Contains("the evenstep that made it"));
  Bytes first = whole.bytes;
  first[16] = std::byte{1};
  CHECK_THAT(error_of(first), Catch::StartsWith("file:16: ") && Catch::Contains("reads versions 2 to 3"));
  Bytes headless = whole.bytes;
  headless.resize(whole.ends[0] - 1);
  CHECK_THAT(error_of(headless), Catch::StartsWith("file:20: ") && Catch::Contains("nothing to replay"));
  Bytes swapped = internal::file_begin();
  append(swapped, internal::block_bytes(internal::BlockKind::head, 1, encoded(made_up_head())));
  CHECK_THAT(error_of(swapped), Catch::Contains("block 1 stands where block 0 should"));
  CHECK_FALSE(is_input_log("/dev/null"));
  CHECK_THAT(errors_of(read_input_log("/dev/zero")), Catch::Contains("is no file"));
}

TEST_CASE("a recording of version 2 is read, and does not say how many steps were due") {
  const auto with_end = [](std::uint8_t version, const Bytes& content) {
    Bytes bytes = internal::file_begin(), head = encoded(made_up_head());
    bytes[16] = std::byte{version};
    if (version == 2) head.resize(head.size() - 4);  // it does not repeat the version
    append(bytes, internal::block_bytes(internal::BlockKind::head, 0, head));
    append(bytes, internal::block_bytes(internal::BlockKind::end, 1, content));
    return parse_input_log(bytes, "x");
  };
  // Hash and digest, two bools, the number of devices, and of each how many counters it has.
  Bytes end(8 + 8 + 2);
  end[0] = std::byte{7};
  append(end, {std::byte{1}, std::byte{0}, std::byte{0}, std::byte{0}});
  append(end, Bytes(4));
  const InputLogResult log = with_end(2, end);
  INFO(errors_of(log));
  REQUIRE(log);
  REQUIRE(log->end);
  CHECK(log->end->trace_hash == 7);
  CHECK_FALSE(log->end->steps_due);
  CHECK_THAT(errors_of(with_end(3, end)), Catch::Contains("its fields do not fill it"));
  end.push_back(std::byte{1});
  end.push_back(std::byte{40});
  end.resize(end.size() + 7);
  CHECK_THAT(errors_of(with_end(2, end)), Catch::Contains("its fields do not fill it"));
  const InputLogResult later = with_end(3, end);
  INFO(errors_of(later));
  REQUIRE(later);
  CHECK(later->end->steps_due == 40);
}

TEST_CASE("a recording whose head has another version than the file begins with is refused") {
  InputLogHead head = made_up_head();
  head.format = 4;
  Bytes bytes = internal::file_begin();
  append(bytes, internal::block_bytes(internal::BlockKind::head, 0, encoded(head)));
  CHECK_THAT(errors_of(parse_input_log(bytes, "x")), Catch::Contains("another version than the file begins with"));
}

TEST_CASE(
    "a recording has no fewer steps due than began, the one that the end cut off included, nor more than any run has") {
  for (const bool cut_off : {false, true}) {
    for (const std::int64_t due : {INT64_C(-1), INT64_C(8), INT64_C(9), INT64_C(10), INT64_MAX}) {
      MadeUp made(1, false);
      if (cut_off) {
        internal::SimulationSlice slice;
        slice.heads = {{9}};
        slice.unfinished = RealTime{20'000'000};
        made.add(internal::BlockKind::simulation, encoded(slice));
      }
      InputLogEnd end;
      end.counters.resize(1);
      end.steps_due = due;
      made.add(internal::BlockKind::end, encoded(end));
      const std::string errors = errors_of(parse_input_log(made.bytes, "x"));
      INFO(due << ": " << errors);
      const bool possible = due >= (cut_off ? 10 : 9) && due < INT64_MAX;  // a slice has nine steps
      CHECK(errors.empty() == possible);
      if (!possible) CHECK_THAT(errors, Catch::Contains("a count of steps"));
    }
  }
}

TEST_CASE("contents that no run can have are refused, though their checksums are right") {
  const auto with = [](const auto& change) {
    MadeUp made(1, false);
    internal::DeviceSlice device = device_slice(1);
    internal::SimulationSlice simulation = simulation_slice(1);
    change(device, simulation);
    made.add(internal::BlockKind::device, encoded(device));
    made.add(internal::BlockKind::simulation, encoded(simulation));
    return errors_of(parse_input_log(made.bytes, "x"));
  };
  CHECK(with([](auto&, auto&) {}).empty());
  CHECK_THAT(with([](auto& d, auto&) { d.tools[0].ticks[3].input.sample.position_m.y = NAN; }), Catch::Contains("finite"));
  CHECK_THAT(with([](auto& d, auto&) { d.tools[0].ticks[3].input.played_at = {INT64_MAX}; }), Catch::Contains("instant"));
  CHECK_THAT(with([](auto& d, auto&) { d.tools[0].ticks[3].input.order = 0; }), Catch::Contains("go back"));
  CHECK_THAT(with([](auto& d, auto&) { d.tools.clear(); }), Catch::Contains("number of devices"));
  CHECK_THAT(with([](auto& d, auto&) { d.check->events = 1; }), Catch::Contains("goes back"));
  CHECK_THAT(with([](auto&, auto& s) { s.steps[2].end = {0}; }), Catch::Contains("instant"));
  CHECK_THAT(with([](auto&, auto& s) { s.steps[2].segment = 7; }), Catch::Contains("go back"));
  CHECK_THAT(with([](auto&, auto& s) { s.heads[0].pop_back(); }), Catch::Contains("read nothing"));
  CHECK_THAT(with([](auto&, auto& s) { s.segments[0].index = 0; }), Catch::Contains("go back"));
}

TEST_CASE("bytes changed at random under right checksums are read or refused, 5,000 times") {
  std::uint64_t state = 20261123;
  for (int round = 0; round < 5000; ++round) {
    const std::vector<Bytes> contents{encoded(made_up_head()), encoded(device_slice(0)), encoded(simulation_slice(0))};
    Bytes bytes = internal::file_begin();
    for (std::size_t i = 0; i < contents.size(); ++i) {
      Bytes content = contents[i];
      for (std::uint64_t changes = below(state, 4); changes > 0; --changes) {
        const std::size_t at = below(state, content.size());
        if (below(state, 8) == 0)
          content.resize(at);
        else
          content[at] = static_cast<std::byte>(below(state, 256));
        if (content.empty()) break;
      }
      append(bytes, internal::block_bytes(static_cast<internal::BlockKind>(1 + i), i, content));
    }
    const InputLogResult read = parse_input_log(bytes, "x");
    REQUIRE(read.ok() == errors_of(read).empty());
  }
}

namespace {

/// What the child process reports, in memory that outlives it.
struct Said {
  std::atomic<std::uint64_t> blocks_kept{0};
};

[[noreturn]] void write_until_killed(const std::string& path, Said& said) {
  auto writer = internal::InputLogWriter::create(path, made_up_head());
  if (!writer) ::_exit(1);
  for (std::int64_t i = 0;; ++i) {
    const Bytes device = encoded(device_slice(i)), simulation = encoded(simulation_slice(i));
    while (!(*writer)->offer(internal::BlockKind::device, device)) said.blocks_kept = (*writer)->blocks_kept();
    while (!(*writer)->offer(internal::BlockKind::simulation, simulation)) said.blocks_kept = (*writer)->blocks_kept();
    said.blocks_kept = (*writer)->blocks_kept();
  }
}

void kill_writers(int times, std::uint64_t seed) {
  const TemporaryFolder folder;
  void* const shared = ::mmap(nullptr, sizeof(Said), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  std::uint64_t state = seed, most = 0;
  for (int i = 0; i < times; ++i) {
    auto& said = *new (shared) Said;
    const std::string path = folder / ("killed-" + std::to_string(i));
    const pid_t child = ::fork();
    if (child == 0) write_until_killed(path, said);
    while (said.blocks_kept == 0) std::this_thread::yield();
    std::this_thread::sleep_for(std::chrono::microseconds(below(state, 60'000)));
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    REQUIRE((WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL));
    const InputLogResult read = read_input_log(path);
    INFO("kill " << i << ": " << errors_of(read));
    REQUIRE(read);
    REQUIRE(read->blocks >= static_cast<std::int64_t>(said.blocks_kept.load()));
    most = std::max(most, said.blocks_kept.load());
    std::filesystem::remove(path);
  }
  ::munmap(shared, sizeof(Said));
  CHECK(most > 4);  // some writers had written slices
}

}  // namespace

TEST_CASE("a writer that is killed at 24 random instants has lost no block that it said the kernel has") {
  kill_writers(24, 1);
}
TEST_CASE("a writer that is killed at 200 random instants has lost no block that it said the kernel has", "[million]") {
  kill_writers(200, 2);
}
