#include <cstdio>

#include "commands.h"

namespace evenstep::app {
namespace {

struct SchemaArguments {};

ExitCode schema(const SchemaArguments&, const std::atomic<bool>&, const Registry& registry) {
  std::fputs(scenario_schema(registry).c_str(), stdout);
  return ExitCode::pass;
}

}  // namespace

void add_schema(Commands& commands) {
  commands.add<SchemaArguments>("schema", "print the JSON Schema of scenario files, for editors", schema);
}

}  // namespace evenstep::app
