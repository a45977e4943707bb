// [source]
#include <fmt/format.h>

#include "src/field_rows.h"
#include "src/sections.h"

namespace evenstep::internal {
namespace {

constexpr double kMostEntries = 10'000, kMostTaps = 32;

SourceSpec read_travel(ScenarioReading& reading, const Table& source) {
  const Scenario& scenario = reading.scenario;
  const auto span = [&](std::string_view key) { return source.span(key, scenario.nominal, reading.errors); };
  return {.delay = span("delay"),
          .jitter = span("jitter"),
          .lost = source.si("lost"),
          .late = source.si("late"),
          .late_by = span("late_by"),
          .clock_ppm = source.whole_ppm("clock_rate_error", reading.errors)};
}

/// The forces of a source are forces only: nothing on the device's side knows what made them.
void check_rendering(ScenarioReading& reading) {
  for (const DeviceSpec& device : reading.scenario.devices) {
    if (std::holds_alternative<ForceRender>(device.render)) continue;
    reading.errors.add(reading.document.find("source")->place,
                       fmt::format("[source]: its forces are played as they are, and device '{}' renders contacts by "
                                   "itself; write render = {{ kind = \"force\" }} there, or leave [source] out",
                                   device.name));
  }
}

}  // namespace

void read_playing(ScenarioReading& reading) {
  if (!reading.sound("source")) return;
  const Table source = reading.section("source");
  Scenario& scenario = reading.scenario;
  const auto span = [&](std::string_view key) { return source.span(key, scenario.nominal, reading.errors); };
  ResamplerSpec& resampler = scenario.playing.resampler;
  resampler.level = source.number("level");
  resampler.trend = source.number("trend");
  resampler.furthest = span("furthest");
  resampler.taps = static_cast<int>(source.integer("taps"));
  resampler.period = scenario.nominal.slot;
  ChunkSpec& chunk = scenario.playing.chunk;
  const Table chunks = source.table("chunk");
  chunk.entries = static_cast<int>(chunks.integer("entries"));
  chunk.every = chunks.span("every", scenario.nominal, reading.errors);
  chunk.decay = chunks.number("decay");
  if (reading.document.find("source") == nullptr) return;
  scenario.timing.elsewhere = read_travel(reading, source);
  scenario.timing.programmed.seed = scenario.seed;
  check_rendering(reading);
}

// A key is a few full lines.
// clang-format off
const std::vector<Field>& source_fields() {
  static const std::vector<Field> rows{
      {.table = "source", .key = "delay", .forms = kSpan, .default_toml = "\"0 ms\"",
       .meaning = "Least time from the end of a step until its force is at the device.",
       .range = between(0, 10)},
      {.table = "source", .key = "jitter", .forms = kSpan, .default_toml = "\"0 ms\"",
       .meaning = "The force comes later than that by up to this, uniformly distributed.",
       .range = between(0, 10)},
      {.table = "source", .key = "lost", .forms = kQuantity, .default_toml = "\"0 %\"",
       .meaning = "Share of the forces that never come, each independently.",
       .dimension = D::ratio, .range = between(0, 0.9)},
      {.table = "source", .key = "late", .forms = kQuantity, .default_toml = "\"0 %\"",
       .meaning = "Share of the forces that come `late_by` later, and so after others that were made after them.",
       .dimension = D::ratio, .range = between(0, 1)},
      {.table = "source", .key = "late_by", .forms = kSpan, .default_toml = "\"0 ms\"",
       .meaning = "How much later.",
       .range = between(0, 10)},
      {.table = "source", .key = "clock_rate_error", .forms = kQuantity, .default_toml = "\"0 ppm\"",
       .meaning = "The source's clock, which [timing] counts in, is faster than the device's by this (whole ppm).",
       .dimension = D::ratio, .range = between(-0.01, 0.01)},
      {.table = "source", .key = "level", .forms = kNumber, .default_toml = "0.8",
       .meaning = "Strategy `holt_winters`: weight of the newest force in the level.",
       .range = above(0, 1)},
      {.table = "source", .key = "trend", .forms = kNumber, .default_toml = "0.2",
       .meaning = "Strategy `holt_winters`: weight of the newest slope in the trend.",
       .range = above(0, 1)},
      {.table = "source", .key = "furthest", .forms = kSpan, .default_toml = "\"100 ms\"",
       .meaning = "Strategy `holt_winters` continues the line this far past the newest force, then holds.",
       .range = between(0, 10)},
      {.table = "source", .key = "taps", .forms = kInteger, .default_toml = "4",
       .meaning = "Strategy `polyphase`: forces on each side of the time that is played.",
       .range = between(1, kMostTaps)},
      {.table = "source", .key = "chunk", .forms = kTable,
       .meaning = "What a step of the strategies `chunk_replace`, `chunk_append` and `chunk_blend` gives: future forces, on "
                  "the line through its own and that of the step before."},
      {.table = "source.chunk", .key = "entries", .forms = kInteger, .default_toml = "50",
       .meaning = "How many forces, its own included.",
       .range = between(1, kMostEntries)},
      {.table = "source.chunk", .key = "every", .forms = kSpan, .default_toml = "\"20 ms\"",
       .meaning = "Time from one force to the next. Between these times forces are interpolated or held, as the device's "
                  "`emission` says.",
       .range = above(0, 10)},
      {.table = "source.chunk", .key = "decay", .forms = kNumber, .default_toml = "0.01",
       .meaning = "Strategy `chunk_blend`: m of the weights exp(-m i), i = 0 for the oldest chunk.",
       .range = between(0, 100)},
  };
  return rows;
}
// clang-format on

}  // namespace evenstep::internal
