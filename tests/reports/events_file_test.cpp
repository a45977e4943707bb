#include <stdexcept>

#include "catch.h"
#include "evenstep/reports/writers.h"
#include "evenstep/time/digest.h"

#include "synthetic.h"

using namespace evenstep;

namespace {

/// A chained log as the scheduler writes it; `changed` is the index of the event whose payload differs.
StrategyRecord log_of(const std::string& name, std::size_t count, std::size_t changed = SIZE_MAX) {
  StrategyRecord strategy;
  strategy.name = name;
  strategy.event_names = {"tick", "step", "launch"};
  std::uint64_t hash = name_digest(name);
  for (std::size_t i = 0; i < count; ++i) {
    EventRow event;
    event.time = {static_cast<std::int64_t>(i) * 1'000'003};
    event.lane = static_cast<std::uint8_t>(i % 3);
    event.name = static_cast<std::uint16_t>((i / 2) % 3);
    hash = mix(hash, static_cast<std::uint64_t>(i) + (i == changed ? 1u << 20 : 0u));
    event.chained_hash = hash;
    strategy.events.push_back(event);
  }
  strategy.trace_hash = hash;
  return strategy;
}

std::vector<std::byte> bytes_of(const RunRecord& run) {
  const std::string text = synthetic::written(events_bin, run);
  const auto* const first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

EventFile through_bytes(std::vector<StrategyRecord> strategies) {
  RunRecord run;
  run.strategies = std::move(strategies);
  return read_events_bin(bytes_of(run));
}

std::vector<std::byte> small_file() {
  RunRecord run;
  run.strategies = {log_of("direct", 5), log_of("phase_locked", 3), log_of("empty", 0)};
  return bytes_of(run);
}

}  // namespace

TEST_CASE("an event log survives its file") {
  const EventFile file = through_bytes({log_of("direct", 50), log_of("ideal", 0)});
  REQUIRE(file.size() == 2);
  const StrategyRecord expected = log_of("direct", 50);
  CHECK(file[0].name == "direct");
  CHECK(file[0].event_names == expected.event_names);
  CHECK(file[0].trace_hash == expected.trace_hash);
  REQUIRE(file[0].events.size() == 50);
  for (std::size_t i = 0; i < 50; ++i) {
    const EventRow &a = file[0].events[i], &b = expected.events[i];
    CHECK((a.time == b.time && a.lane == b.lane && a.name == b.name && a.chained_hash == b.chained_hash));
  }
}

TEST_CASE("the layout is fixed: little endian, 20 bytes per event") {
  RunRecord run;
  StrategyRecord strategy;
  strategy.name = "ab";
  strategy.trace_hash = 0x0807060504030201;
  strategy.event_names = {"x"};
  strategy.events.push_back({RealTime{-2}, 2, 0, 0x1817161514131211});
  run.strategies.push_back(strategy);
  const std::vector<int> expected{
      'E', 'V',  'S',  'T',  'E',  'P',  '0',  '1',  1,    0,    0,    0,    2,    0,    0,    0,    'a',  'b', 1, 2, 3,
      4,   5,    6,    7,    8,    1,    0,    0,    0,    1,    0,    0,    0,    'x',  1,    0,    0,    0,   0, 0, 0,
      0,   0xFE, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x11, 0x12, 0x13, 0x14, 0x15, 0x16, 0x17, 0x18, 0,   0, 2, 0};
  std::vector<int> bytes;
  for (const std::byte b : bytes_of(run)) bytes.push_back(std::to_integer<int>(b));
  CHECK(bytes == expected);
}

TEST_CASE("a file cut at any byte is refused with an offset inside it") {
  const std::vector<std::byte> whole = small_file();
  for (std::size_t length = 0; length < whole.size(); ++length) {
    CAPTURE(length);
    CHECK_THROWS_WITH(read_events_bin({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length)}),
                      Catch::StartsWith("events.bin: byte "));
  }
  std::vector<std::byte> longer = whole;
  longer.push_back(std::byte{0});
  CHECK_THROWS_WITH(read_events_bin(longer), Catch::Contains("1 bytes after the last strategy"));
}

TEST_CASE("a file with any one byte changed to any other is read or refused, never trusted") {
  const std::vector<std::byte> whole = small_file();
  int refused = 0;
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (int change = 1; change < 256; ++change) {
      std::vector<std::byte> bytes = whole;
      bytes[at] ^= static_cast<std::byte>(change);
      try {
        const EventFile file = read_events_bin(bytes);
        for (const StrategyRecord& strategy : file) {
          for (const EventRow& event : strategy.events) REQUIRE(event.name < strategy.event_names.size());
        }
      } catch (const std::runtime_error& error) {
        ++refused;
        if (std::string(error.what()).rfind("events.bin: byte ", 0) != 0) FAIL(error.what());
      }
    }
  }
  CHECK(refused > 255 * 8);  // at least every change of the magic number
}

TEST_CASE("a count larger than the file is refused before anything is allocated") {
  std::vector<std::byte> bytes = small_file();
  for (std::size_t i = 8; i < 12; ++i) bytes[i] = std::byte{0xFF};
  CHECK_THROWS_WITH(read_events_bin(bytes), Catch::Contains("byte 8: 4294967295 strategies do not fit"));
}

TEST_CASE("a difference planted at any of 1000 events is found there, with both events named") {
  const EventFile a = through_bytes({log_of("direct", 1000)});
  CHECK_FALSE(first_difference(a, a));
  for (std::size_t at = 0; at < 1000; ++at) {
    const EventFile b{{log_of("direct", 1000, at)}};
    const auto difference = first_difference(a, b);
    REQUIRE(difference);
    REQUIRE(difference->strategy == "direct");
    REQUIRE(difference->index == static_cast<std::int64_t>(at));
  }
  const std::string text = first_difference(a, {{log_of("direct", 1000, 7)}})->text;
  CHECK_THAT(text, Catch::Contains("direct: first difference at event 7") &&
                       Catch::Contains("A 0.007000021 s device.tick") && Catch::Contains("B 0.007000021 s device.tick"));
}

TEST_CASE("a shorter log differs where it ends: every length") {
  const EventFile whole{{log_of("direct", 200)}};
  for (std::size_t length = 0; length < 200; ++length) {
    const auto difference = first_difference({{log_of("direct", length)}}, whole);
    REQUIRE(difference);
    CHECK(difference->index == static_cast<std::int64_t>(length));
    CHECK_THAT(difference->text, Catch::Contains("A ends after " + std::to_string(length) + " events"));
    CHECK(first_difference(whole, {{log_of("direct", length)}})->index == static_cast<std::int64_t>(length));
  }
}

TEST_CASE("of several strategies the earliest difference is named, order in the file does not matter") {
  const EventFile a{{log_of("direct", 100), log_of("paper", 100)}};
  const EventFile b{{log_of("paper", 100, 20), log_of("direct", 100, 60)}};
  CHECK(first_difference(a, b)->strategy == "paper");
  CHECK(first_difference(a, {{log_of("paper", 100, 60), log_of("direct", 100, 20)}})->strategy == "direct");
  CHECK_FALSE(first_difference(a, {{log_of("paper", 100), log_of("direct", 100)}}));
}

TEST_CASE("a strategy that only one run has, and a hash that differs behind equal events, are differences") {
  const EventFile both{{log_of("direct", 10), log_of("paper", 10)}}, one{{log_of("direct", 10)}};
  CHECK_THAT(first_difference(both, one)->text, Catch::Contains("only A has"));
  CHECK_THAT(first_difference(one, both)->text, Catch::Contains("only B has"));
  CHECK(first_difference(one, both)->index == -1);
  EventFile other = one;
  other[0].trace_hash ^= 1;
  CHECK_THAT(first_difference(one, other)->text, Catch::Contains("trace hash"));
}
