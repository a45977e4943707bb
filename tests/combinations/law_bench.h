#pragma once
/// What tests of laws over drawn scenarios share.

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "../own_parts/parts.h"
#include "cases.h"
#include "catch.h"
#include "program.h"
#include "scenario_generator.h"
#include "temporary_folder.h"

namespace evenstep::testing {

using Json = nlohmann::json;

inline std::string content_of(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// The date, of which tests draw what they try today.
inline std::chrono::sys_days today() { return std::chrono::floor<std::chrono::days>(std::chrono::system_clock::now()); }

/// Seeds for tests of laws: EVENSTEP_SEED=7 is that one, EVENSTEP_SEEDS=20000 so many from 0 on. Otherwise the date is the
/// seed, so that every day tries others: `usual` ones from 20261128000 on.
struct Seeds {
  std::uint64_t first = 0, end = 0;
};
inline Seeds seeds(std::uint64_t usual) {
  if (const char* const one = std::getenv("EVENSTEP_SEED")) {
    const std::uint64_t seed = std::stoull(one);
    return {seed, seed + 1};
  }
  if (const char* const count = std::getenv("EVENSTEP_SEEDS")) return {0, std::stoull(count)};
  const std::chrono::year_month_day day(today());
  const std::uint64_t first =
      1000 * ((static_cast<std::uint64_t>(static_cast<int>(day.year())) * 100 + static_cast<unsigned>(day.month())) * 100 +
              static_cast<unsigned>(day.day()));
  return {first, first + share_of(usual)};
}

inline bool says(const std::string& toml, std::initializer_list<std::string_view> parts) {
  return std::any_of(parts.begin(), parts.end(),
                     [&](std::string_view part) { return toml.find(part) != std::string::npos; });
}
/// Reports that are lost, or events that come only for a change, miss more than the schedule alone does.
inline bool loses(const std::string& toml) {
  return says(toml,
              {"[[device.faults]]", "unplug", "_at = ", "report_interval", "[[device.events]]", "interrupt", "rings = "});
}
/// The sizing pass takes each sample to be as old as the oldest.
inline bool ages_vary(const std::string& toml) { return says(toml, {"report_age_jitter", "clock_rate"}); }
/// A time stamp has whole microseconds, rounded up, so a sample that is stamped seems newer by less than one.
inline bool stamped(const std::string& toml) { return says(toml, {"sample_time = \"taken\"", "report_age", "clock_rate"}); }

constexpr double kRichness = 0.05;

/// Nearly all drawn scenarios run for some tenths of a second. One whose first command is interrupted, such as a case with
/// every method, is mostly not judged; what is compared with that command has a minute.
constexpr int kInterruptAfter_s = kSanitized ? 60 : 5;

/// Runs in a folder of its own.
class Bench {
 public:
  Bench() { write_recordings(folder_.path().string()); }
  /// The next command is the first one of a scenario.
  void begin_scenario() const { is_first_ = true; }
  const Registry& registry() const { return registry_; }
  std::string path() const { return folder_.path().string(); }
  std::string scenario() const { return folder_.path().string() + "/scenario.toml"; }
  GeneratedScenario draw(std::uint64_t seed) const {
    ScenarioGenerator generator(seed, folder_.path().string(), registry_);
    GeneratedScenario drawn;
    for (int attempt = 0; attempt < 8 && !drawn.is_valid; ++attempt) drawn = generator.scenario(kRichness);
    return drawn;
  }
  Ended program(const std::vector<std::string>& arguments) const {
    return run_program(arguments, folder_.path().string(), registry_,
                       {.interrupt_after_s = std::exchange(is_first_, false) ? kInterruptAfter_s : 60, .end_after_s = 20});
  }
  /// `evenstep run` of a scenario text; `summary` is null if there is none.
  struct Run {
    Ended ended;
    Json summary;
  };
  Run run(const std::string& toml, const std::string& out, std::vector<std::string> more = {}) const {
    std::ofstream(scenario()) << toml;
    std::vector<std::string> arguments{"run", "scenario.toml", "--out", out, "--allow-no-expectations"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    Run run{program(arguments), nullptr};
    run.summary = Json::parse(content_of(folder_.path().string() + '/' + out + "/summary.json"), nullptr, false);
    return run;
  }

 private:
  mutable bool is_first_ = false;
  TemporaryFolder folder_;
  Registry registry_ = own_parts::registry();
};

/// What a law says of one scenario.
class Law {
 public:
  Law(const Bench& used, std::uint64_t drawn_from) : bench(used), seed(drawn_from) { used.begin_scenario(); }
  const Bench& bench;
  const std::uint64_t seed;

  /// What is shown if the law is broken from here on.
  void shows(std::string text) { shown_ = std::move(text); }
  bool must(bool holds, std::string_view what) {
    if (!holds && broken_.empty()) broken_ = fmt::format("{}\n{}", what, shown_);
    return holds;
  }
  /// `found` is what is wrong, or empty.
  bool nothing(const std::string& found) { return must(found.empty(), found); }
  const std::string& broken() const { return broken_; }

 private:
  std::string shown_, broken_;
};
#define MUST(...) law.must(static_cast<bool>(__VA_ARGS__), #__VA_ARGS__)

/// Says whether this law could judge the scenario.
using Judge = std::function<bool(Law& law, GeneratedScenario drawn)>;

/// With the fewest lines that break the law: entries and tables go one after the other while what is left is valid and
/// breaks it.
GeneratedScenario shrunk(GeneratedScenario scenario, const Bench& bench, std::uint64_t seed, const Judge& judge);

/// Draws a scenario for each seed and judges it. One that breaks the law is shrunk and left in the folder "broken". At least
/// one must be judged, but for a single seed and the few of a sanitized build.
void judge_drawn(std::uint64_t usual, const Judge& judge);

}  // namespace evenstep::testing
