// [timing] governor
#include "governor.h"

#include <fmt/format.h>

#include <algorithm>

namespace evenstep::internal {
namespace {

constexpr std::string_view kOverBudget[] = {"skip", "hold", "merge"};
constexpr Duration kShortestPace{10'000}, kLongestPace{9'000'000'000};  // as a segment

/// Adds an error if no drawing makes a pause that could be shorter.
void check_pauses(ScenarioReading& reading, const Table& governor) {
  const TimingSpec& timing = reading.scenario.timing;
  const auto has_clock = [](const SegmentTiming& segment) { return !segment.simulated.empty(); };
  if (timing.programmed.accumulator)
    reading.errors.add(
        governor.place("split"),
        "'governor': the steps of a game's frame are those that are due when it begins, so they come in a burst whenever "
        "the frame comes, and how many they are depends on when that is; remove it. A loop that begins each step when it is "
        "due has no accumulator: instead of 'loop' write e.g. segment = \"30 Hz\", steps = 3, governor = { steps = "
        "\"spread\" }");
  if (std::any_of(timing.trace.begin(), timing.trace.end(), has_clock))
    reading.errors.add(governor.place("split"),
                       "'governor': the recording is of a game's loop, whose frames have the steps that are due when they "
                       "begin; were they moved, others would be due; remove it");
  const auto overlaps = [](const SegmentTiming& segment) { return segment.overlaps(); };
  const bool beside = timing.trace.empty() ? timing.programmed.order == SegmentOrder::concurrent
                                           : std::any_of(timing.trace.begin(), timing.trace.end(), overlaps);
  if (beside)
    reading.errors.add(governor.place("split"),
                       "'governor': the visualizations have a lane of their own and stop no step, so there is no pause to "
                       "shorten; remove it");
}

/// Adds an error for a key that has no meaning beside the others.
void check_budget(const Table& governor, Errors& errors) {
  for (const char* key : {"over_budget", "forecast"}) {
    if (governor.has(key) && !governor.has("budget"))
      errors.add(governor.place(key),
                 fmt::format("'{}' is about a 'budget', and there is none; write budget = \"20 ms\"", key));
  }
  if (governor.has("forecast") && governor.has("budget") && governor.text("over_budget") == "merge")
    errors.add(
        governor.place("forecast"),
        "'forecast': \"merge\" cuts a drawing off where the budget ends, and needs none; remove it, or write over_budget = "
        "\"hold\"");
}

}  // namespace

void read_governor(ScenarioReading& reading, const Table& governor) {
  FrameGovernor out;
  out.spread = governor.text("steps") == "spread";
  out.split = static_cast<int>(governor.integer("split"));
  if (governor.has("budget")) out.budget = governor.duration("budget");
  const auto over = std::find(std::begin(kOverBudget), std::end(kOverBudget), governor.text("over_budget"));
  out.over_budget = static_cast<OverBudget>(over - std::begin(kOverBudget));
  out.forecast = static_cast<int>(governor.integer("forecast"));
  if (governor.has("pace")) {
    const std::string text = governor.text("pace");
    const Result<Rate> rate = parse_rate(text);
    out.pace = rate ? Duration{instant_ns(*rate, 1)} : *parse_duration(text);
    if (*out.pace < kShortestPace || *out.pace > kLongestPace)
      reading.errors.add(governor.place("pace"),
                         fmt::format("'pace': \"{}\" is out of range; it must be between 10 us and 9 s", text));
  }
  check_budget(governor, reading.errors);
  check_pauses(reading, governor);
  reading.scenario.timing.governor = out;
}

// A key is a few full lines.
// clang-format off
const std::vector<Field>& governor_fields() {
  static const std::vector<Field> rows{
      {.table = "timing", .key = "governor", .forms = kTable,
       .meaning = "A frame governor: what the simulator does so that pauses are shorter (docs/choose/pauses.md)."},
      {.table = "timing.governor", .key = "steps", .forms = kWord, .default_toml = "\"burst\"",
       .meaning =
           "`spread`: step i of N begins no earlier than i T/N after its segment's turn; a late one follows at once. T and "
           "N of a recording are what was usual in its last 8 segments. `burst`: steps wait for nothing.",
       .words = "burst|spread"},
      {.table = "timing.governor", .key = "split", .forms = kInteger, .default_toml = "1",
       .meaning = "Each drawing is made in this many parts, with the steps shared out between them.",
       .range = between(1, 1000)},
      {.table = "timing.governor", .key = "budget", .forms = kDuration,
       .meaning = "The frame budget: what a pause for a drawing, or for a part of it, may take at most.",
       .range = above(0, 9), .example = "\"20 ms\""},
      {.table = "timing.governor", .key = "over_budget", .forms = kWord, .default_toml = "\"merge\"",
       .meaning =
           "What becomes of a drawing that would take longer. `merge`: the rest is drawn in the next pauses, in place of "
           "the drawings that would begin there. `skip`: it is not made, and the steps follow at once. `hold`: it is not "
           "made, and the steps keep their place.",
       .words = "merge|skip|hold"},
      {.table = "timing.governor", .key = "forecast", .forms = kInteger, .default_toml = "2",
       .meaning = "n, for `skip` and `hold`: a drawing is expected to take as long as the longest of the last n, and after "
                  "n that were not made the next one is made.",
       .range = between(1, 1000)},
      {.table = "timing.governor", .key = "pace", .forms = kRate | kDuration,
       .meaning = "Segments wait for this grid (with `split`, their parts wait for a grid that many times as fine), and "
                  "idle until then.",
       .range = above(0), .example = "\"30 Hz\""},
  };
  return rows;
}
// clang-format on

}  // namespace evenstep::internal
