#pragma once
/// A solver that is a program of its own, in lock step over pipes: docs/parts/process-protocol.md. Each solver is a process
/// of its own, started without a shell, in a process group that ends with it. When this program ends, in whatever way, a
/// second small process kills the group.

#include <optional>
#include <string>
#include <vector>

#include "evenstep/sim/foreign_solver.h"

namespace evenstep {

struct ProcessCommand {
  std::vector<std::string> words;         ///< the program and its arguments; at least one
  std::string folder;                     ///< its working directory
  Duration answer_limit{30'000'000'000};  ///< real time that an answer may take; > 0
};

/// The program's file: a first word with a '/' is a path from `folder`, any other is looked for in PATH. nullopt if there is
/// no such file that can be run.
std::optional<std::string> program_of(const ProcessCommand& command);

/// The command as one line, for messages.
std::string text_of(const ProcessCommand& command);

/// Starts a process for each solver. A process that cannot be started, ends, closes its output, exceeds its time limit or
/// breaks the protocol is a SolverError with its exit status and the last line of its standard error. Standard error is also
/// logged, line by line, up to a limit.
SolverFactory process_solver(const ProcessCommand& command);

}  // namespace evenstep
