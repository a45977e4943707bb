#include <fmt/format.h>

#include <filesystem>

#include "commands.h"
#include "evenstep/reports/measures.h"

namespace evenstep::app {

namespace {

struct ListArguments {
  std::vector<std::string> paths;
};

ExitCode list(const ListArguments& arguments, const std::atomic<bool>&) {
  const std::vector<std::string> folders = !arguments.paths.empty() ? arguments.paths
                                           : std::filesystem::is_directory("scenarios")
                                               ? std::vector<std::string>{"scenarios"}
                                               : std::vector<std::string>{};
  const std::optional<std::vector<std::string>> files = scenario_files(folders);
  if (!files) return ExitCode::usage;
  ExitCode code = ExitCode::pass;
  for (const std::string& file : *files) {
    const ReadResult read = read_scenario(file);
    if (read)
      fmt::print("{:<48} {}\n", file, read->name);
    else
      code = ExitCode::usage;
    print(read.error_or({}));
  }
  if (!files->empty()) fmt::print("\n");
  fmt::print("strategies ");
  for (const StrategyTraits& strategy : kAllStrategies) fmt::print(" {}", strategy.name);
  fmt::print("\n");
  fmt::print("solvers     opencl cpu cpu-double\n");
  fmt::print("methods    ");
  for (const Method method : kAllMethods) fmt::print(" {}", name_of(method));
  fmt::print("\n");
  fmt::print("motions     still constant-velocity sine ramp-stop stick-slip recorded minimum-jerk hand\n");
  for (const char* signal :
       {"DEVICE.interaction.STRATEGY", "DEVICE.force.STRATEGY", "DEVICE.buffers.STRATEGY", "closed_loop.DEVICE.STRATEGY",
        "solver.STRATEGY", "events.device.tick", "run", "case.METHOD.SOLVER"}) {
    const auto metrics = metrics_of_signal(signal);
    if (metrics) fmt::print("{:<28} {}\n", signal, fmt::join(*metrics, " "));
  }
  return code;
}

}  // namespace

void add_list(Commands& commands) {
  auto [command, arguments] =
      commands.add<ListArguments>("list", "what a scenario can name: scenarios found, strategies, solvers, metrics", list);
  command.optional_operands("folder", arguments.paths, "where to look for scenarios (default: scenarios)");
}

}  // namespace evenstep::app
