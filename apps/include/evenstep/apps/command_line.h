#pragma once
/// The program `evenstep` as a function: it parses the arguments, runs the command that they name and returns its exit code.
/// With parts of your own in the registry (evenstep/format/registry.h) it is `evenstep` for your solver, device, map and
/// timing source.

#include "evenstep/format/registry.h"

namespace evenstep {

/// Exit codes: 0 all expectations hold, 1 an expectation failed or there is no verdict, 2 usage or scenario error, 3 the run
/// failed, 4 not reproducible, 130 interrupted. It takes over SIGINT, SIGTERM, SIGHUP and SIGPIPE of the process, and the
/// default logger of spdlog, so call it only once per process.
int command_line(int argc, char** argv, const Registry& registry = builtin());

}  // namespace evenstep
