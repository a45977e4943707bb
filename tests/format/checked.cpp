#include "checked.h"

#include "catch.h"
#include "support.h"

namespace evenstep::test {

Scenario good(const std::string& text, const ReadOptions& options) {
  ReadResult result = read_text(text, options);
  INFO(errors_of(result));
  REQUIRE(result);
  return *std::move(result);
}

void check_round_trip(const Scenario& scenario) {
  const TemporaryFolder folder;
  const ReadResult again = read_scenario(folder.write("resolved.toml", scenario.resolved_toml));
  INFO(scenario.resolved_toml << errors_of(again));
  REQUIRE(again);
  CHECK(describe(*again) == describe(scenario));
  CHECK(again->resolved_toml == scenario.resolved_toml);
}

std::string changed(std::string base, const std::string& from, const std::string& to) {
  const std::size_t at = base.find(from);
  REQUIRE(at != std::string::npos);
  return base.replace(at, from.size(), to);
}

}  // namespace evenstep::test
