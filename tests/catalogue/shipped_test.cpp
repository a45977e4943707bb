// The catalogue as it is shipped.
#include <filesystem>
#include <set>

#include "catch.h"
#include "evenstep/catalogue/trial.h"
#include "evenstep/format/fields.h"
#include "evenstep/harness/run.h"
#include "evenstep/reports/measures.h"
#include "support.h"

using namespace evenstep;
using namespace evenstep::internal;

namespace {

std::vector<Scenario> shipped_cases() {
  std::vector<Scenario> cases;
  for (const char* folder : {"/scenarios/stiff", "/scenarios/extreme"}) {
    const std::string path = std::string(EVENSTEP_SOURCE_DIR) + folder;
    if (!std::filesystem::is_directory(path)) continue;
    for (const auto& entry : std::filesystem::directory_iterator(path)) {
      if (entry.path().extension() != ".toml") continue;
      const ReadResult read = read_scenario(entry.path().string());
      INFO(entry.path() << "\n" << test::errors_of(read));
      REQUIRE(read);
      if (read->case_spec) cases.push_back(*read);
    }
  }
  return cases;
}

}  // namespace

TEST_CASE("Every kind of case that a file can name exists, and is shipped in a file") {
  std::set<std::string> words, kinds, shipped;
  for (const Field& field : fields()) {
    if (field.table != "case" || field.key != "kind") continue;
    for (const std::string_view word : split_words(field.words)) words.insert(std::string(word));
  }
  for (const CaseKind& kind : case_kinds()) kinds.insert(std::string(kind.name));
  for (const Scenario& scenario : shipped_cases()) shipped.insert(scenario.case_spec->kind);
  CHECK(words == kinds);
  CHECK(shipped == kinds);
}

TEST_CASE("Every case asserts that no schedule changes a bit, and says why it exists") {
  for (const Scenario& scenario : shipped_cases()) {
    INFO(scenario.file);
    CHECK_FALSE(scenario.because.empty());
    CHECK(check_expectations(scenario).empty());
    bool asserted = false;
    for (const Expectation& expectation : scenario.expectations) {
      asserted = asserted || (expectation.metric == "schedule_difference" && expectation.signal.starts_with("case.") &&
                              !expectation.at && expectation.max && expectation.max->number == 0);
    }
    CHECK(asserted);
  }
}

TEST_CASE("Every metric that a cell of a shipped case has is one that an expectation can name", "[sweep]") {
  const auto known = *metrics_of_signal("case.rk4.cpu");
  for (Scenario scenario : shipped_cases()) {
    INFO(scenario.file);
    CaseSpec& spec = *scenario.case_spec;
    spec.methods = {Method::symplectic_euler};
    spec.solvers = {SolverKind::cpu_double};
    if (spec.values.size() > 2) spec.values.resize(2);
    spec.most_steps = std::min<std::int64_t>(spec.most_steps, 100);
    scenario.expectations.clear();
    for (const auto& [signal, values] : run_scenario(scenario, {}).metrics) {
      for (const auto& [metric, value] : values) {
        INFO(metric);
        CHECK(std::find(known.begin(), known.end(), metric) != known.end());
      }
    }
  }
}
