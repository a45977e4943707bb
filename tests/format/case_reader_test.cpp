// [case] in a file: what is read, what is refused, and with which words.
#include "catch.h"
#include "support.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

constexpr const char* kCase = R"(format = 1
name = "a case"
[case]
kind = "oscillator"
methods = ["symplectic-euler", "rk4"]
solvers = ["cpu-double"]
values = [{ from = 1e-4, to = 1, count = 5 }, 1.5]
[[expect]]
signal = "case.rk4.*"
metric = "refused"
max = 0
at = [0.1, 2]
)";

std::string changed(const std::string& from, const std::string& to) {
  std::string text = kCase;
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

}  // namespace

TEST_CASE("A case is read with its defaults, decades spelled out") {
  const ReadResult read = read_text(kCase);
  INFO(errors_of(read));
  REQUIRE(read);
  const CaseSpec& spec = *read->case_spec;
  CHECK(spec.methods == std::vector{Method::symplectic_euler, Method::rk4});
  CHECK(spec.solvers == std::vector{SolverKind::cpu_double});
  CHECK(spec.values == std::vector<double>{1e-4, 1e-3, 1e-2, 0.1, 1, 1.5});
  CHECK(spec.periods == 1000);
  CHECK(read->expectations.at(0).at == std::array<double, 2>{0.1, 2});
  const ReadResult all = read_text(changed("methods = [\"symplectic-euler\", \"rk4\"]\n", ""));
  CHECK(all->case_spec->methods.size() == kAllMethods.size());
}

TEST_CASE("The seed of a case is that of its irregular schedule, from the file or the command line") {
  CHECK(read_text(std::string(kCase) + "[run]\nseed = 7\n")->seed == 7);
  CHECK(read_text(kCase, {{}, 9})->seed == 9);
}

TEST_CASE("Mistakes in a case are named where they stand, with the remedy") {
  struct Mistake {
    const char* from;
    const char* to;
    const char* error;
  };
  for (const Mistake& mistake : std::vector<Mistake>{
           {"kind = \"oscillator\"", "kind = \"oscilator\"", "did you mean 'oscillator'?"},
           {"kind = \"oscillator\"", "", "[case] has no 'kind'; write kind = \"oscillator\""},
           {"values = ", "#", "[case] has no 'values'; write values = [1, 10, 100]"},
           {"values = [{ from = 1e-4, to = 1, count = 5 }, 1.5]", "values = []", "'values' must be"},
           {"1.5]", "0.5]", "scenario.toml:7:10: error: 'values': 0.5 comes after 1; sort them, each once"},
           {"1.5]", "1]", "'values': 1 comes after 1"},
           {"1.5]", "-1]", "'values': -1 is out of range; it must be above 0"},
           {"1.5]", "\"1\"]", "'values': \"1\" must be a number or a table"},
           {"to = 1,", "to = 1e-5,", "'to': 1e-05 is not above from, 0.0001"},
           {"count = 5", "count = 1", "'count': 1 is out of range; it must be at least 2"},
           {"count = 5", "cont = 5", "unknown key 'cont' in case.values; did you mean 'count'?"},
           {"\"rk4\"]", "\"rk5\"]", "did you mean 'rk4'?"},
           {"\"rk4\"]", "\"symplectic-euler\"]", "'methods' names \"symplectic-euler\" twice"},
           {"[\"cpu-double\"]", "[]", "'solvers' is empty; name at least one"},
           {"[[expect]]", "duration = \"1 s\"\n[[expect]]", "'duration' means nothing with kind = \"oscillator\""},
           {"[[expect]]", "[run]\nduration = \"1 s\"\n[[expect]]", "'duration' of [run] does not go with [case]; remove it"},
           {"[[expect]]", "[timing]\nsegment = \"30 Hz\"\n[[expect]]",
            "'timing' does not go with [case], which drives the solver itself; remove one of them"},
           {"[[expect]]", "[scene]\nkind = \"spring\"\n[[expect]]", "'scene' does not go with [case]"},
           {"[[expect]]", "[expect_stop]\nreason = \"diverged\"\n[[expect]]", "'expect_stop' does not go with [case]"},
           {"case.rk4.*", "case.rk5.*", "there is no method 'rk5'; this scenario has: symplectic-euler, rk4"},
           {"case.rk4.*", "case.rk4.opencl", "there is no solver 'opencl'; this scenario has: cpu-double"},
           {"case.rk4.*", "left.force.direct",
            "'left.force.direct' is not a signal of a case; write case.<method>.<solver>"},
           {"[0.1, 2]", "[2, 0.1]", "'at' must be the least and the greatest value"},
           {"[0.1, 2]", "[2]", "'at' must be the least and the greatest value"},
       }) {
    INFO(mistake.from << " -> " << mistake.to);
    const ReadResult read = read_text(changed(mistake.from, mistake.to));
    CHECK_FALSE(read);
    CHECK_THAT(errors_of(read), Contains(mistake.error));
  }
}

TEST_CASE("Cells cannot be picked where there are none") {
  std::string text = kSpring;
  text += "at = [0, 1]\n";
  CHECK_THAT(errors_of(read_text(text)), Contains("'at' picks cells of a [case], and there is none; remove it"));
}

TEST_CASE("A case survives its resolved file") {
  const ReadResult first = read_text(kCase);
  REQUIRE(first);
  const ReadResult again = read_text(first->resolved_toml);
  INFO(first->resolved_toml << errors_of(again));
  REQUIRE(again);
  CHECK(describe(*again) == describe(*first));
}
