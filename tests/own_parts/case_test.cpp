// Cases of the catalogue on a solver that the program adds.
#include <glm/geometric.hpp>

#include "support.h"

using namespace evenstep;
using namespace own_parts;
using Catch::Contains;

namespace {

/// Symplectic Euler for the particles that a case hands over.
class Springs final : public ForeignSolver {
 public:
  explicit Springs(const SolverRequest& request) : given_(nlohmann::json::parse(request.options).at("particles")) {
    reset();
  }
  ToolResponse step(std::span<const glm::dvec3>, double step_s) override {
    const double k = given_.at("stiffness"), m = given_.at("mass");
    std::vector<glm::dvec3> force_N(rest_m_.size());
    for (const auto& spring : given_.at("springs")) {
      const std::size_t a = spring.at(0), b = spring.at(1);
      const glm::dvec3 rest_m = rest_m_[b] - rest_m_[a];
      const glm::dvec3 now_m = rest_m + state_.displacement_m[b] - state_.displacement_m[a];
      const double length_m = glm::length(now_m);
      const glm::dvec3 pull_N = now_m / length_m * (k * (length_m - glm::length(rest_m)));
      force_N[a] += pull_N;
      force_N[b] -= pull_N;
    }
    for (const std::size_t fixed : given_.at("fixed")) force_N[fixed] = {};
    for (std::size_t n = 0; n < force_N.size(); ++n) {
      state_.velocity_m_per_s[n] += force_N[n] * (step_s / m);
      state_.displacement_m[n] += state_.velocity_m_per_s[n] * step_s;
    }
    return {};
  }
  SolverCapabilities capabilities() const override { return {.particles = true, .reset = true}; }
  ParticleState particles() override { return state_; }
  void reset() override {
    rest_m_ = vectors("rest");
    state_ = {vectors("displacement"), std::vector<glm::dvec3>(rest_m_.size())};
  }

 private:
  std::vector<glm::dvec3> vectors(const char* key) const {
    std::vector<glm::dvec3> all;
    for (const auto& v : given_.at(key)) all.emplace_back(v.at(0), v.at(1), v.at(2));
    return all;
  }
  nlohmann::json given_;
  std::vector<glm::dvec3> rest_m_;
  ParticleState state_;
};

Registry with_springs() {
  Registry mine = registry();
  mine.add_solver("springs", [](const SolverRequest& request) { return std::make_unique<Springs>(request); });
  return mine;
}

ReadResult read_case(const std::string& file, std::vector<std::string> set) {
  return read_scenario(std::string(EVENSTEP_SOURCE_DIR) + "/scenarios/stiff/" + file,
                       {std::move(set), std::nullopt, with_springs()});
}

RunOutcome run_case(const std::string& file, std::vector<std::string> set) {
  set.insert(set.begin(), {"expect=[]", R"(case.foreign={ name = "springs" })"});
  const ReadResult scenario = read_case(file, std::move(set));
  INFO(text_of(scenario.error_or({})));
  REQUIRE(scenario);
  RunOptions options;
  options.allow_no_expectations = true;
  options.repeat = true;
  return run_scenario(*scenario, options);
}

}  // namespace

TEST_CASE("A case of the catalogue finds the method of a solver of the program, its edge and its order", "[sweep]") {
  const RunOutcome oscillator = run_case("s1-oscillator.toml", {"case.periods=10"});
  REQUIRE(oscillator.exit == ExitCode::pass);
  const Metrics& metrics = oscillator.metrics;
  CHECK(metrics.at("case.symplectic-euler.springs").at("ok") == 5);
  CHECK(metrics.at("case.symplectic-euler.springs").at("closed_form_error") < 1e-11);
  CHECK(metrics.at("case.symplectic-euler.springs").at("schedule_difference") == 0);

  const RunOutcome edge = run_case("s4-stability-edge.toml", {"case.particles=3", "case.values=[0.9, 0.99, 1.01, 1.1]"});

  CHECK(edge.metrics.at("case.symplectic-euler.springs").at("ok") == 2);
  CHECK(edge.metrics.at("case.symplectic-euler.springs").at("diverged") == 2);
}

TEST_CASE("A solver that does not show its particles is unavailable to a case, and says why") {
  const RunOutcome outcome =
      run_case("s1-oscillator.toml", {R"(case.foreign={ name = "my-spring", options = { stiffness = 200 } })"});
  const CaseCell& cell = outcome.case_record->rows.at(0).cells.at(0);
  CHECK(cell.status == CellStatus::unavailable);
  CHECK_THAT(cell.detail, Contains("does not show its particles"));
}

TEST_CASE("A case takes a solver of the program or solvers of evenstep's own, for scenes that can be handed over") {
  const auto errors = [](const std::string& file, const std::vector<std::string>& set) {
    return text_of(read_case(file, set).error_or({}));
  };
  CHECK_THAT(errors("s1-oscillator.toml", {R"(case.foreign={ name = "springs" })", R"(case.solvers=["cpu"])"}),
             Contains("'solvers' does not go with 'foreign'"));
  CHECK_THAT(errors("s12-hanging-chain.toml", {R"(case.foreign={ name = "springs" })"}),
             Contains("'foreign' means nothing with kind = \"hanging-chain\""));
  CHECK_THAT(errors("s1-oscillator.toml", {R"(case.foreign={ name = "sprigs" })"}), Contains("did you mean 'springs'"));
}
