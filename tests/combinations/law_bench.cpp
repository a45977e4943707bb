#include "law_bench.h"

#include <filesystem>
#include <iostream>

namespace evenstep::testing {
namespace {

/// The scenario with this root, if the reader takes it.
GeneratedScenario rewritten(ScenarioTable root, const Bench& bench) {
  GeneratedScenario scenario;
  scenario.root = std::move(root);
  scenario.toml = to_text(scenario.root).toml;
  std::ofstream(bench.scenario()) << scenario.toml;
  scenario.is_valid = static_cast<bool>(read_scenario(bench.scenario(), {.registry = bench.registry()}));
  return scenario;
}

/// Leaves the line out that `place` is about: a value, or a table with all that is in it.
void leave_out(const ScenarioPlace& place) {
  ScenarioTable::Entry& entry = *place.table->find(place.key);
  if (entry.tables.size() > 1) {
    entry.tables.erase(entry.tables.begin() + static_cast<std::ptrdiff_t>(place.element));
  } else {
    place.table->erase(place.key);
  }
}

}  // namespace

GeneratedScenario shrunk(GeneratedScenario scenario, const Bench& bench, std::uint64_t seed, const Judge& judge) {
  for (std::size_t line = 0; line < to_text(scenario.root).places.size();) {
    ScenarioTable root = scenario.root;
    leave_out(to_text(root).places[line]);
    GeneratedScenario less = rewritten(std::move(root), bench);
    Law law(bench, seed);
    if (less.is_valid) judge(law, less);
    if (law.broken().empty()) {
      ++line;
    } else {
      scenario = std::move(less);  // the line has another entry now
    }
  }
  return scenario;
}

void judge_drawn(std::uint64_t usual, const Judge& judge) {
  const Bench bench;
  const auto [first, end] = seeds(usual);
  std::cout << "seeds " << first << " to " << end - 1 << std::endl;
  std::uint64_t judged = 0;
  for (std::uint64_t seed = first; seed < end; ++seed) {
    const GeneratedScenario drawn = bench.draw(seed);
    if (!drawn.is_valid) continue;
    Law law(bench, seed);
    judged += judge(law, drawn);
    if (law.broken().empty()) continue;
    const GeneratedScenario small = shrunk(drawn, bench, seed, judge);
    const std::string again = fmt::format("EVENSTEP_SEED={} test_combinations", seed);
    std::filesystem::create_directories("broken");
    const std::string file = std::filesystem::absolute(fmt::format("broken/{}.toml", seed)).string();
    std::ofstream(file) << "# " << again << '\n' << small.toml;
    FAIL_CHECK(law.broken() << '\n'
                            << again << "\nthe fewest lines that break this law are in " << file << ":\n"
                            << small.toml << "\nas drawn:\n"
                            << drawn.toml);
  }
  std::cout << judged << " of " << end - first << " scenarios judged\n";
  CHECK((judged > 0 || kSanitized || end - first == 1));
}

}  // namespace evenstep::testing
