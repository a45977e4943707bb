// The field table: the top of the file, and all sections' rows joined.
#include "field_rows.h"

namespace evenstep::internal {
namespace {

// A key is a few full lines.
// clang-format off
const std::vector<Field>& top_fields() {
  static const std::vector<Field> rows{
      {.table = "", .key = "format", .forms = kInteger,
       .meaning = "Version of this format: 1. Obligatory in every file.",
       .required = true, .range = between(1, 1), .example = "1"},
      {.table = "", .key = "name", .forms = kText, .default_toml = "\"\"", .meaning = "What the scenario is, in one line."},
      {.table = "", .key = "because", .forms = kText, .default_toml = "\"\"", .meaning = "Why it exists."},
      {.table = "", .key = "tags", .forms = kText, .shape = Shape::list, .default_toml = "[]",
       .meaning = "For picking scenarios.",
       .example = "[\"paper\", \"ci\"]"},
      {.table = "", .key = "extends", .forms = kFile, .shape = Shape::list, .default_toml = "[]",
       .meaning = "Files to start from; later ones win, this file over all. Tables merge, lists replace. At most 16 deep.",
       .example = "[\"base.toml\"]"},
      {.table = "", .key = "case", .forms = kTable,
       .meaning = "An entry of the catalogue of stiff and extreme cases, which drives the solver itself. Of all that "
                  "follows, only `[[expect]]` and, in `[run]`, `seed` go with it."},
      {.table = "", .key = "run", .forms = kTable, .meaning = "How long, how often, with which strategies."},
      {.table = "", .key = "timing", .forms = kTable, .meaning = "What the GPU costs.", .kinds = "loop", .required = true},
      {.table = "", .key = "scene", .forms = kTable,
       .meaning = "What is simulated. Only what is named here exists in the run.",
       .kinds = "loop", .required = true},
      {.table = "", .key = "device", .forms = kTable, .shape = Shape::list,
       .meaning = "The hands: one or two.",
       .kinds = "loop", .required = true},
      {.table = "", .key = "remap", .forms = kTable,
       .meaning = "The map between real time and simulation time.",
       .kinds = "loop"},
      {.table = "", .key = "source", .forms = kTable,
       .meaning = "The steps are made elsewhere: how their forces come to the device (docs/choose/sources.md).",
       .kinds = "loop"},
      {.table = "", .key = "study", .forms = kTable,
       .meaning = "What `evenstep study` compares or looks for. A run ignores it.",
       .kinds = "loop"},
      {.table = "", .key = "sweep", .forms = kTable,
       .meaning = "What `evenstep sweep` runs: seeds times a grid of values (docs/timings/sweep.md). A run ignores it.",
       .kinds = "loop"},
      {.table = "", .key = "recovery", .forms = kTable,
       .meaning = "What counts as recovered from the programmed faults (docs/timings/recovery.md).",
       .kinds = "loop"},
      {.table = "", .key = "expect", .forms = kTable, .shape = Shape::list,
       .meaning = "What must hold; each entry is judged on its own."},
      {.table = "", .key = "expect_append", .forms = kTable, .shape = Shape::list,
       .meaning = "Expectations added to `expect`; those of all files in `extends` stay."},
      {.table = "", .key = "sometimes", .forms = kTable, .shape = Shape::list,
       .meaning = "What must hold at one or more points of a sweep (docs/timings/sweep.md). A run ignores it.",
       .kinds = "loop"},
      {.table = "", .key = "expect_stop", .forms = kTable,
       .meaning = "The run must stop early, for this reason; anything else fails.",
       .kinds = "loop"},
  };
  return rows;
}
// clang-format on

}  // namespace

std::string_view strategy_words() {
  static const std::string words = words_of(kAllStrategies, [](const StrategyTraits& strategy) { return strategy.name; });
  return words;
}

std::string_view method_words() {
  static const std::string words = words_of(kAllMethods, [](Method method) { return name_of(method); });
  return words;
}

const std::vector<Field>& fields() {
  static const std::vector<Field> all = [] {
    std::vector<Field> joined;
    for (const auto& section :
         {top_fields, case_fields, run_fields, timing_fields, scene_fields, device_fields, driver_fields, motion_fields,
          remap_fields, source_fields, study_fields, sweep_fields, recovery_fields, expect_fields}) {
      const std::vector<Field>& rows = section();
      joined.insert(joined.end(), rows.begin(), rows.end());
    }
    return joined;
  }();
  return all;
}

}  // namespace evenstep::internal
