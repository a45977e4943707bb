// Parts that the program registers are read and kept. They are refused where they are not registered.
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "catch.h"
#include "evenstep/format/scenario.h"
#include "support.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

Registry registry_with(bool arm) {
  Registry registry;
  registry.add_solver("my-tissue", [](const SolverRequest&) { return nullptr; });
  if (arm) registry.add_device("my-arm", [](const DeviceRequest&) { return nullptr; });
  registry.add_map("my-pacer", [](const MapRequest&) { return nullptr; });
  return registry;
}

}  // namespace

TEST_CASE("A part that the program registers is kept with its options as JSON, and its name is all that evenstep reads") {
  const std::string text = R"(format = 1
[run]
duration = "1 s"
strategies = ["direct", "foreign"]
[timing]
segment = "30 Hz"
visualization = "11.1 ms"
steps = 15
[scene]
kind = "foreign"
name = "my-tissue"
options = { mesh = "liver.obj", depth = [1, 2.5, true], inner = { text = "a \"b\" \u00fc" } }
[[device]]
name = "left"
driver = "foreign"
foreign = { name = "my-arm", options = { port = 3 } }
[remap]
foreign = { name = "my-pacer" }
)";
  const ReadResult read = read_text(text, {{}, std::nullopt, registry_with(true)});
  INFO(errors_of(read));
  REQUIRE(read);
  const auto& scene = std::get<ForeignScene>(read->scene.body);
  CHECK(scene.name == "my-tissue");
  CHECK(scene.options == R"({"depth":[1,2.5,true],"inner":{"text":"a \"b\" ü"},"mesh":"liver.obj"})");
  const auto& driver = std::get<ForeignDriverSpec>(read->devices.at(0).driver);
  CHECK(driver.part.name == "my-arm");
  CHECK(driver.part.options == R"({"port":3})");
  REQUIRE(read->remap.foreign);
  CHECK(read->remap.foreign->name == "my-pacer");
  CHECK(read->remap.foreign->options == "{}");
  CHECK(std::count(read->strategies.begin(), read->strategies.end(), StrategyKind::foreign) == 1);
  // The resolved form is the same scenario.
  const ReadResult again = read_text(read->resolved_toml, {{}, std::nullopt, registry_with(true)});
  INFO(errors_of(again));
  REQUIRE(again);
  CHECK(describe(*again) == describe(*read));

  CHECK(errors_of(read_text(text)) ==
        "scenario.toml:11:8: error: the solver 'my-tissue' is not registered; this needs a program that registers it\n"
        "scenario.toml:16:20: error: the driver 'my-arm' is not registered; this needs a program that registers it\n"
        "scenario.toml:18:20: error: the map 'my-pacer' is not registered; this needs a program that registers it\n");
  CHECK(errors_of(read_text(text, {{}, std::nullopt, registry_with(false)})).find("'my-arm'") != std::string::npos);
}

TEST_CASE("A foreign part needs its name, options that are a table without dates, and a strategy that names a map") {
  for (const auto& [from, to, error] : std::vector<std::array<std::string, 3>>{
           {"kind = \"spring\"\nstiffness = \"200 N/m\"", "kind = \"foreign\"",
            "[scene] has no 'name'; write name = \"mine\""},
           {"kind = \"spring\"\nstiffness = \"200 N/m\"", "kind = \"foreign\"\nname = \"a\"\noptions = 3",
            "scenario.toml:15:11: error: 'options': must be a table, not 3"},
           {"kind = \"spring\"\nstiffness = \"200 N/m\"",
            "kind = \"foreign\"\nname = \"a\"\noptions = { at = [2020-01-01] }",
            "scenario.toml:15:19: error: 'options': a date cannot be passed on as JSON; write it as text"},
           {"kind = \"spring\"\nstiffness = \"200 N/m\"", "kind = \"spring\"\nname = \"a\"",
            "'name' means nothing with kind = \"spring\""},
           {"name = \"left\"", "name = \"left\"\ndriver = \"foreign\"", "has no 'foreign'"},
           {"[timing]", "strategies = [\"foreign\"]\n[timing]", "[remap] does not say which map that is"},
       }) {
    INFO(from << " -> " << to);
    std::string text = kSpring;
    REQUIRE(text.find(from) != std::string::npos);
    const ReadResult result = read_text(text.replace(text.find(from), from.size(), to));
    CHECK_FALSE(result);
    CHECK_THAT(errors_of(result), Contains(error));
  }
}
