// What must not change when a scenario is written or run in another way, and what must change in proportion.
#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

#include <algorithm>
#include <iostream>
#include <regex>

#include "catch.h"
#include "evenstep/reports/measures.h"
#include "law_bench.h"

using namespace evenstep;
using namespace evenstep::testing;

namespace {

/// The metrics but for seconds of the processor.
Json metrics_of(const Json& summary) {
  Json metrics = summary.at("metrics");
  for (auto& [signal, values] : metrics.items()) values.erase("solver_seconds");
  return metrics;
}
std::vector<std::string> strategies_of(const Json& summary) {
  std::vector<std::string> names;
  for (const auto& [name, one] : summary.at("strategies").items()) names.push_back(name);
  return names;
}
std::string list_of(const std::vector<std::string>& names) { return fmt::format("[\"{}\"]", fmt::join(names, "\", \"")); }

std::string renamed(std::string text, const std::vector<std::pair<std::string, std::string>>& names) {
  for (const auto& [from, to] : names) {
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
      text.replace(at, from.size(), to);
  }
  return text;
}

/// The first metric that differs, with both values; empty: none. `only_common` compares what both have.
std::string difference(const Json& a, const Json& b, bool only_common = false) {
  for (const auto& [signal, values] : a.items()) {
    if (!b.contains(signal)) {
      if (!only_common) return signal + " is missing";
      continue;
    }
    for (const auto& [metric, value] : values.items()) {
      if (!b.at(signal).contains(metric)) {
        if (!only_common) return signal + ' ' + metric + " is missing";
      } else if (b.at(signal).at(metric) != value) {
        return fmt::format("{} {}: {} and {}", signal, metric, value.dump(), b.at(signal).at(metric).dump());
      }
    }
  }
  return !only_common && a.size() != b.size() ? "one has more signals" : "";
}

}  // namespace

TEST_CASE("Neither what is kept, nor threads, nor the other strategies and their order change what a strategy does") {
  judge_drawn(12, [](Law& law, GeneratedScenario drawn) {
    const Bench& bench = law.bench;
    const std::uint64_t seed = law.seed;
    if (drawn.root.has("case")) return false;
    const Bench::Run run = bench.run(drawn.toml, "run");
    if (run.ended.exit_code > 1 || !run.summary.is_object()) return false;
    std::vector<std::string> names = strategies_of(run.summary);
    if (names.empty()) return false;  // it was stopped before the first
    const Json metrics = metrics_of(run.summary);

    const Bench::Run kept = bench.run(drawn.toml, "kept", {"--set", "run.keep=\"summary\""});
    law.shows(kept.ended.text());
    if (!MUST(kept.summary.is_object())) return true;
    MUST(kept.summary.at("trace_hash") == run.summary.at("trace_hash"));
    law.nothing(difference(metrics_of(kept.summary), metrics, true));
    for (const auto& [signal, values] : metrics.items())  // events are counted in the rows
      MUST((kept.summary.at("metrics").contains(signal) || signal.starts_with("events.")));

    std::rotate(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(seed % names.size()), names.end());
    std::reverse(names.begin(), names.end());
    const Bench::Run turned =
        bench.run(drawn.toml, "turned", {"--threads", "3", "--set", "run.strategies=" + list_of(names)});
    law.shows(turned.ended.text());
    if (!MUST(turned.summary.is_object())) return true;
    law.nothing(difference(metrics, metrics_of(turned.summary)));

    // An expectation may be about a strategy that is not there then.
    // The reference takes the latency of phase_locked, if that is there.
    if (names.front() == "ideal") std::rotate(names.begin(), names.begin() + 1, names.end());
    const std::string& one = names.front();
    const Bench::Run alone =
        bench.run(drawn.toml, "alone", {"--set", "run.strategies=" + list_of({one}), "--set", "expect=[]"});
    law.shows(alone.ended.text());
    if (alone.ended.exit_code == 2) return false;  // the strategies of a sweep's or study's own
    if (!MUST(alone.summary.is_object())) return true;
    MUST(alone.summary.at("strategies").at(one).at("trace_hash") == run.summary.at("strategies").at(one).at("trace_hash"));
    Json others = metrics_of(alone.summary);
    others.erase("run");
    for (auto entry = others.begin(); entry != others.end();)
      entry = entry.key().ends_with('.' + one) ? std::next(entry) : others.erase(entry);
    MUST(!others.empty());
    law.nothing(difference(others, metrics, true));
    return true;
  });
}

TEST_CASE("The names of devices change nothing but the names of their signals") {
  judge_drawn(12, [](Law& law, GeneratedScenario drawn) {
    const Bench& bench = law.bench;
    if (drawn.root.has("case") || drawn.root.has("sweep")) return false;
    const Bench::Run run = bench.run(drawn.toml, "run");
    if (run.ended.exit_code > 1 || !run.summary.is_object()) return false;
    const Bench::Run other = bench.run(renamed(drawn.toml, {{"name = \"left\"", "name = \"zeta\""},
                                                            {"name = \"right\"", "name = \"alpha\""},
                                                            {"\"left.", "\"zeta."},
                                                            {"\"right.", "\"alpha."}}),
                                       "other");
    law.shows(other.ended.text());
    if (!MUST(other.summary.is_object())) return true;
    Json expected;
    const Json metrics = metrics_of(run.summary);
    for (const auto& [signal, values] : metrics.items()) {
      const std::string name = renamed('.' + signal, {{".left.", ".zeta."}, {".right.", ".alpha."}});
      expected[name.substr(1)] = values;
    }
    law.nothing(difference(expected, metrics_of(other.summary)));
    MUST(other.ended.exit_code == run.ended.exit_code);
    return true;
  });
}

TEST_CASE("With nothing lost, the least latency and lead miss nothing, and one nanosecond less does") {
  judge_drawn(20, [](Law& law, GeneratedScenario drawn) {
    const Bench& bench = law.bench;
    for (const char* const key : {"case", "sweep", "expect_stop"})
      if (drawn.root.has(key)) return false;
    if (loses(drawn.toml)) return false;
    const std::vector<std::string> least{
        "--set", "run.strategies=[\"phase_locked\"]", "--set", "remap.latency=\"minimal-this-phase\"",
        "--set", "remap.lead=\"minimal-this-phase\"", "--set", "expect=[]"};
    const Bench::Run run = bench.run(drawn.toml, "run", least);
    if (run.ended.exit_code > 1 || !run.summary.is_object()) return false;
    law.shows(run.ended.text());
    std::int64_t late = 0, missing = 0, latency_ns = 0, lead_ns = 0;
    const auto count = [&](const Json& summary) {
      late = missing = 0;
      for (const auto& [signal, metrics] : summary.at("metrics").items()) {
        if (signal.find(".buffers.") == std::string::npos) continue;
        late += metrics.at("force_underruns").get<std::int64_t>();
        missing += metrics.at("interaction_underruns").get<std::int64_t>();
        latency_ns = std::llround(metrics.at("latency").get<double>() * 1e9);
        lead_ns = std::llround(metrics.at("lead").get<double>() * 1e9);
      }
    };
    count(run.summary);
    MUST(late == 0);
    MUST(missing == 0);
    const std::int64_t least_latency_ns = latency_ns, least_lead_ns = lead_ns;
    const auto with = [&](std::int64_t latency, std::int64_t lead) {
      std::vector<std::string> more{least};
      more[3] = fmt::format("remap.latency=\"{} ns\"", latency);
      more[5] = fmt::format("remap.lead=\"{} ns\"", lead);
      const Bench::Run one = bench.run(drawn.toml, "less", more);
      law.shows(one.ended.text());
      if (one.ended.exit_code == 2) return false;  // a latency of less than nothing
      if (!MUST(one.summary.is_object())) return true;
      count(one.summary);
      return true;
    };
    if (ages_vary(drawn.toml)) return true;  // it is not sure that the oldest sample is the one that is needed
    const std::int64_t less_ns = stamped(drawn.toml) ? 1000 : 1;
    if (with(least_latency_ns + 1'000'000, least_lead_ns - less_ns)) MUST(missing > 0);
    if (!with(least_latency_ns - 1, least_lead_ns)) return false;
    MUST(late > 0);
    return true;
  });
}

TEST_CASE("Constant velocity and constant timing give a straight line, whatever else is set that loses nothing") {
  judge_drawn(30, [](Law& law, GeneratedScenario drawn) {
    ScenarioTable& root = drawn.root;
    // A device that is simulated down to its sensor has a count of its own, and what cuts a force off ends the line.
    for (const char* const key : {"case", "expect_stop", "sweep", "source", "guard"})
      if (root.has(key)) return false;
    for (const char* const key : {"expect", "timing"}) root.erase(key);
    ScenarioTable timing;
    timing.set("segment", "\"30 Hz\"");
    timing.set("visualization", "\"11.1 ms\"");
    timing.set("steps", "15");
    root.entries.push_back({"timing", "", {timing}, false});
    for (ScenarioTable* device : tables_at(root, "device")) {
      for (const char* const key : {"driver", "pid", "evdev", "inverse3", "foreign", "guard", "unplug", "returns"})
        device->erase(key);
      device->set("motion", "{ kind = \"constant-velocity\", velocity = [\"0.05 m/s\", \"0 m/s\", \"0 m/s\"] }");
    }
    drawn.toml = to_text(root).toml;
    if (loses(drawn.toml) || ages_vary(drawn.toml) || stamped(drawn.toml)) return false;
    const Bench::Run run =
        law.bench.run(drawn.toml, "run",
                      {"--set", "run.strategies=[\"phase_locked\"]", "--set", "remap.latency=\"minimal\"", "--set",
                       "remap.lead=\"minimal\"", "--set", "run.duration=\"2 s\"", "--set", "run.warmup=\"8 segments\""});
    if (run.ended.exit_code > 1 || !run.summary.is_object()) return false;
    bool is_judged = false;
    for (const auto& [signal, metrics] : run.summary.at("metrics").items()) {
      if (!signal.ends_with(".interaction.phase_locked") || !metrics.contains("velocity_jump")) continue;
      is_judged = true;
      law.shows(signal + ' ' + metrics.dump() + '\n' + run.ended.text());
      // Times are stamped in microseconds, two of them make a jump. Unmapped it would be 0.05 m/s times 11.1 ms, 0.6 mm.
      MUST(metrics.at("velocity_jump").get<double>() < 1.01e-7);
    }
    return is_judged;
  });
}

TEST_CASE("A recording that begins at another time is the same recording") {
  judge_drawn(8, [](Law& law, GeneratedScenario drawn) {
    const Bench& bench = law.bench;
    if (!drawn.root.has("timing")) return false;
    if (bench.run(drawn.toml, "run").ended.exit_code > 1) return false;
    std::istringstream rows(content_of(bench.path() + "/run/timing.csv"));
    std::string line, moved;
    while (std::getline(rows, line)) {
      std::smatch cells;
      if (!std::regex_match(line, cells, std::regex("([^,]*,[^,]*,[^,]*),(-?[0-9]+),(-?[0-9]+)(,.*)?"))) {
        moved += line + '\n';
        continue;
      }
      constexpr std::int64_t kBy_ns = 1'234'567'891;
      moved += fmt::format("{},{},{}{}\n", cells[1].str(), std::stoll(cells[2]) + kBy_ns, std::stoll(cells[3]) + kBy_ns,
                           cells[4].str());
    }
    if (std::count(moved.begin(), moved.end(), '\n') < 3) return false;
    std::ofstream(bench.path() + "/here.csv") << content_of(bench.path() + "/run/timing.csv");
    std::ofstream(bench.path() + "/there.csv") << moved;
    const std::string scene = "\"\n[scene]\nkind = \"spring\"\n[[device]]\nname = \"left\"\n";
    const Bench::Run here = bench.run("format = 1\n[timing]\ntrace = \"here.csv" + scene, "here");
    const Bench::Run there = bench.run("format = 1\n[timing]\ntrace = \"there.csv" + scene, "there");
    law.shows(here.ended.text() + there.ended.text());
    MUST(here.ended.exit_code == there.ended.exit_code);
    if (!here.summary.is_object()) return false;
    law.nothing(difference(metrics_of(here.summary), metrics_of(there.summary)));
    return true;
  });
}

TEST_CASE("A spring of twice the stiffness gives twice the force, and a mirrored hand the same metrics, bit for bit") {
  judge_drawn(16, [](Law& law, GeneratedScenario drawn) {
    const Bench& bench = law.bench;
    if (!drawn.root.has("scene")) return false;
    ScenarioTable& scene = drawn.root.find("scene")->tables.front();
    // A limit, a motor or a wall does not know that the forces are meant to be twice as large.
    const ScenarioTable::Entry* const kind = scene.find("kind");
    const bool is_spring = kind && kind->toml == "\"spring\"";
    if (!is_spring || drawn.root.has("expect_stop") || drawn.root.has("source") || drawn.root.has("guard")) return false;
    for (ScenarioTable* device : tables_at(drawn.root, "device")) {
      for (const char* const key : {"render", "force_limit", "slew_limit", "unplug", "returns", "faults", "events", "pid",
                                    "evdev", "inverse3", "foreign", "driver", "guard"})
        device->erase(key);
      device->erase("motion");
      device->set("motion", "{ kind = \"constant-velocity\", velocity = [\"0.005 m/s\", \"-0.002 m/s\", \"0 m/s\"] }");
    }
    drawn.root.erase("expect");
    scene.set("stiffness", "\"150 N/m\"");
    const std::string toml = to_text(drawn.root).toml;
    scene.set("stiffness", "\"300 N/m\"");
    const std::string doubled = to_text(drawn.root).toml;
    const std::string mirrored = renamed(toml, {{"\"0.005 m/s\", \"-0.002 m/s\"", "\"-0.005 m/s\", \"0.002 m/s\""}});
    const Bench::Run run = bench.run(toml, "run");
    if (run.ended.exit_code != 0 || !run.summary.is_object()) return false;
    law.shows(toml);
    const Bench::Run other = bench.run(mirrored, "mirrored"), twice = bench.run(doubled, "doubled");
    if (!MUST(other.summary.is_object())) return true;
    law.nothing(difference(metrics_of(run.summary), metrics_of(other.summary)));
    if (!MUST(twice.summary.is_object())) return true;
    Json expected = metrics_of(run.summary), seen = metrics_of(twice.summary);
    for (Json* metrics : {&expected, &seen}) {
      for (auto entry = metrics->begin(); entry != metrics->end();) {
        const bool is_signal =
            entry.key().find(".force.") != std::string::npos || entry.key().find(".interaction.") != std::string::npos;
        entry = is_signal ? std::next(entry) : metrics->erase(entry);
      }
      for (auto& [signal, values] : metrics->items()) {
        if (signal.find(".force.") == std::string::npos) continue;
        for (auto value = values.begin(); value != values.end();) {
          // A growth is judged against the error's own spread, motors have a report's digits, and cuts a limit in N.
          const std::string& metric = value.key();
          const bool left_out = metric.find("growth") != std::string::npos || metric.starts_with("motors") ||
                                metric.starts_with("clamped") || metric.starts_with("slewed") ||
                                metric.starts_with("saturated") || metric == "straight" || metric == "felt";
          if (left_out) {
            value = values.erase(value);
            continue;
          }
          if (metrics == &expected && base_unit(signal, metric) == "N") *value = 2 * value->get<double>();
          ++value;
        }
      }
    }
    law.nothing(difference(expected, seen));
    return true;
  });
}
