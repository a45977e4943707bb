// What the parts of a run cost: intervals, pairs with the same bits, libraries that are opened in other processes, and every
// part named once.

#include "evenstep/campaigns/cost.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "evenstep/clock/wall_clock.h"
#include "scenarios.h"
#include "src/cost/pairs.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

CostOptions quick() {
  CostOptions options;
  options.step_pairs = options.run_pairs = 6;
  options.steps_seconds = 1e-4;
  options.run_seconds = 0.01;
  return options;
}

std::map<std::string, PartCost> by_name(const CostReport& report) {
  std::map<std::string, PartCost> parts;
  for (const PartCost& part : report.parts) {
    INFO(part.part);
    CHECK(parts.emplace(part.part, part).second);  // each once
  }
  return parts;
}

/// The chance that the true median lies below the (k + 1)-th of n values: at most k heads of n fair coins.
double chance_of_at_most(int k, int n) {
  double sum = 0;
  for (int heads = 0; heads <= k; ++heads)
    sum += std::exp(std::lgamma(n + 1) - std::lgamma(heads + 1) - std::lgamma(n - heads + 1) - n * std::log(2.0));
  return sum;
}

bool has_loaded(const std::string& library) {
  std::ostringstream maps;
  maps << std::ifstream("/proc/self/maps").rdbuf();
  return maps.str().find(library) != std::string::npos;
}

}  // namespace

TEST_CASE("An interval of pairs is the narrowest that holds the median with 95 %, for any number of pairs up to 200") {
  for (int n = 6; n <= 200; ++n) {
    std::vector<double> values;
    for (int i = 0; i < n; ++i) values.push_back((i * 7919) % n);  // shuffled where n is no multiple of 7919
    const Measured found = measured(values);
    const int k = static_cast<int>(found.low);
    INFO(n << " values, the " << k << "-th");
    CHECK(found.high == n - 1 - k);
    CHECK(found.median == (n - 1) / 2.0);
    CHECK(2 * chance_of_at_most(k, n) <= 0.05);
    CHECK(2 * chance_of_at_most(k + 1, n) > 0.05);
  }
  CHECK(measured({3, 1, 2}).low == 1);
  CHECK(measured({3, 1, 2}).high == 3);
  CHECK(measured({-1, 1}).contains_0());
  CHECK_FALSE(measured({1, 2}).contains_0());
}

TEST_CASE("What opening takes is measured in another process, and this one is left as it was") {
  std::vector<char> touched;
  const auto opened = internal::opened_in_children(
      [&] {
        touched.assign(16 << 20, 'x');
        for (const double until_s = process_cpu_seconds() + 0.02; process_cpu_seconds() < until_s;) {
        }
      },
      6);
  CHECK(opened.error.empty());
  CHECK(opened.cpu_ms.low >= 20);
  CHECK(opened.resident_MiB.low >= 16);
  CHECK(opened.resident_MiB.high < 8 * 16);  // a sanitizer keeps several bytes for each byte
  CHECK(touched.empty());
  CHECK(internal::opened_in_children([] { throw std::runtime_error("no such library"); }, 3).error == "no such library");
  CHECK_FALSE(internal::opened_in_children([] { _exit(0); }, 3).error.empty());
}

TEST_CASE("A pair that differs by a bit says so") {
  const Scenario scenario = read("paper/figure-1-spring.toml");
  Scene other = scenario.scene;
  std::get<SpringScene>(other.body).stiffness_N_per_m *= 1 + 1e-15;
  internal::ToolPath path(50);
  for (std::size_t n = 0; n < path.size(); ++n) path[n][0] = {1e-3 * static_cast<double>(n), 0, 0};
  const auto pair = [&](const Scene& b) {
    internal::Side with{make_solver(SolverKind::cpu_double, scenario.scene), scenario.scene};
    internal::Side without{make_solver(SolverKind::cpu_double, b), b};
    return step_pairs(with, without, path, quick());
  };
  CHECK(pair(scenario.scene).same_bits);
  CHECK_FALSE(pair(other).same_bits);
  CostReport report;
  CHECK(report.same_bits());
  report.parts.push_back({.part = "x", .bits = PartCost::Bits::differ});
  CHECK_FALSE(report.same_bits());
}

TEST_CASE("A spring's run names every part once, keeps its bits, and loads no library to know what one would cost") {
  const Scenario scenario = read("paper/figure-1-spring.toml");
  const CostReport report = measure_costs(scenario, quick());
  const auto parts = by_name(report);
  CHECK(report.same_bits());
  for (const char* kept : {"strategy ideal", "strategy direct", "strategy paper", "strategy phase_locked", "metrics",
                           "figures", "other files", "events", "threads"}) {
    INFO(kept);
    REQUIRE(parts.count(kept) == 1);
    CHECK(parts.at(kept).is_kept);
    CHECK(parts.at(kept).percent.has_value());
    CHECK_FALSE(parts.at(kept).why.empty());
  }
  for (const char* strategy : {"strategy ideal", "strategy direct", "events", "threads"})
    CHECK(parts.at(strategy).bits == PartCost::Bits::equal);
  for (const std::string& absent : left_out(scenario.scene)) {
    CHECK_FALSE(parts.at(absent).is_kept);
    CHECK(parts.at(absent).why == "a scene of this kind has none");
  }
  for (const char* library : {"OpenCL", "hidapi"}) {
    CHECK_FALSE(parts.at(library).is_kept);
    CHECK_THAT(parts.at(library).why, Catch::StartsWith("not loaded"));
  }
  CHECK_FALSE(has_loaded("libOpenCL"));
  CHECK_FALSE(has_loaded("libhidapi"));
}

TEST_CASE("A tissue's run: what is asked for is kept, everything else is left out, and no part changes a bit", "[sweep]") {
  std::vector<std::string> set = small_tissue("cpu");
  const Scenario scenario = read("paper/figure-1.toml", set);
  const CostReport report = measure_costs(scenario, quick());
  const auto parts = by_name(report);
  for (const PartCost& part : report.parts) {
    INFO(part.part << ": " << part.compared);
    CHECK(part.bits != PartCost::Bits::differ);
  }
  CHECK(parts.at("energy").is_kept);
  CHECK_THAT(parts.at("energy").why, Catch::Contains("energy_growth of solver.*"));
  CHECK(parts.at("state digest").why == "the trace hash");
  CHECK_THAT(parts.at("energy").compared, Catch::Contains("forces and particles"));
  CHECK_THAT(parts.at("state digest").compared, Catch::StartsWith("forces of"));
  CHECK(parts.at("ideal twins").is_kept);
  std::size_t measured_here = 0;
  for (const std::string& absent : left_out(scenario.scene)) {
    CHECK_FALSE(parts.at(absent).is_kept);
    measured_here += parts.at(absent).percent.has_value();
    CHECK(parts.at(absent).percent.has_value() == parts.at(absent).why.empty());
  }
  CHECK(measured_here == left_out(scenario.scene).size());
  const nlohmann::json json = nlohmann::json::parse(cost_json(report));
  CHECK(json.at("parts").size() == report.parts.size());
  const std::string text = cost_text(report);
  for (const PartCost& part : report.parts) CHECK_THAT(text, Catch::Contains("\n    " + part.part + " "));
  // Without the expectation nothing computes an energy.
  set.push_back("expect=[]");
  const auto without = by_name(measure_costs(read("paper/figure-1.toml", set), quick()));
  CHECK_FALSE(without.at("energy").is_kept);
  CHECK(without.count("ideal twins") == 0);
}

TEST_CASE("An interrupted measurement ends early") {
  const std::atomic<bool> interrupted{true};
  CostOptions options = quick();
  options.interrupted = &interrupted;
  CHECK_FALSE(measure_costs(read("paper/figure-1.toml", small_tissue("cpu")), options).parts.empty());
}
