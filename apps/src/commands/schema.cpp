#include <cstdio>

#include "evenstep/reports/writers.h"
#include "src/commands.h"

namespace evenstep::app {
namespace {

struct SchemaArguments {
  std::string of = "scenario";
};

ExitCode schema(const SchemaArguments& arguments, const std::atomic<bool>&, const Registry& registry) {
  if (arguments.of != "scenario" && arguments.of != "summary") {
    print({{arguments.of, 0, 0, "there is no such schema; there are: scenario, summary"}});
    return ExitCode::usage;
  }
  std::fputs(arguments.of == "summary" ? summary_schema().c_str() : scenario_schema(registry).c_str(), stdout);
  return ExitCode::pass;
}

}  // namespace

void add_schema(Commands& commands) {
  auto [command, arguments] = commands.add<SchemaArguments>(
      "schema", "print the JSON Schema of scenario files, for editors, or of summary.json", schema);
  command.optional_operand("of", arguments.of, "scenario (default) or summary");
}

}  // namespace evenstep::app
