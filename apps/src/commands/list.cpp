#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "evenstep/format/fields.h"
#include "evenstep/reports/measures.h"
#include "src/commands.h"

namespace evenstep::app {

namespace {

using Json = nlohmann::ordered_json;

struct ListArguments {
  std::vector<std::string> paths;
  bool json = false;
};

/// The kinds of motion, from the table of keys.
std::vector<std::string_view> motions() {
  const std::vector<internal::Field>& rows = internal::fields();
  const auto kind = std::find_if(rows.begin(), rows.end(), [](const internal::Field& row) {
    return row.table == "device.motion" && row.key == "kind";
  });
  return internal::split_words(kind->words);
}

/// What a scenario can name.
Json names(const Registry& registry) {
  Json out = {{"strategies", Json::array()}, {"solvers", Json::array()}, {"methods", Json::array()}};
  for (const StrategyTraits& strategy : kAllStrategies) out["strategies"].push_back(strategy.name);
  for (const SolverKind solver : kAllSolvers) out["solvers"].push_back(name_of(solver));
  for (const Method method : kAllMethods) out["methods"].push_back(name_of(method));
  out["motions"] = motions();
  const auto registered = [&](const char* kind, const auto& parts) {
    for (const auto& [name, make] : parts) out["foreign"][kind].push_back(name);
  };
  registered("solvers", registry.solvers());
  registered("devices", registry.devices());
  registered("maps", registry.maps());
  registered("timings", registry.timings());
  for (const char* signal :
       {"DEVICE.interaction.STRATEGY", "DEVICE.force.STRATEGY", "DEVICE.buffers.STRATEGY", "closed_loop.DEVICE.STRATEGY",
        "solver.STRATEGY", "events.device.tick", "run", "case.METHOD.SOLVER"}) {
    for (const std::string& metric : metrics_of_signal(signal).value_or(std::vector<std::string>{}))
      out["metrics"][signal][metric] = base_unit(signal, metric);
  }
  return out;
}

/// The scenarios in these files; prints what is wrong with others.
Json scenarios(const std::vector<std::string>& files, const Registry& registry, ExitCode& code) {
  Json out = Json::array();
  for (const std::string& file : files) {
    const ReadResult read = read_scenario(file, {{}, std::nullopt, registry});
    if (read)
      out.push_back({{"file", file}, {"name", read->name}, {"tags", read->tags}});
    else
      code = ExitCode::usage;
    print(read.error_or({}));
  }
  return out;
}

void print_tables(const Json& listed) {
  for (const Json& scenario : listed["scenarios"])
    fmt::print("{:<48} {}\n", scenario["file"].get<std::string>(), scenario["name"].get<std::string>());
  if (!listed["scenarios"].empty()) fmt::print("\n");
  for (const char* table : {"strategies", "solvers", "methods", "motions"})
    fmt::print("{:<11} {}\n", table, fmt::join(listed[table].get<std::vector<std::string>>(), " "));
  if (listed.contains("foreign")) {
    for (const auto& [kind, names] : listed["foreign"].items())
      fmt::print("foreign {}: {}\n", kind, fmt::join(names.get<std::vector<std::string>>(), " "));
  }
  for (const auto& [signal, metrics] : listed["metrics"].items()) {
    fmt::print("{:<28}", signal);
    for (const auto& [metric, unit] : metrics.items()) fmt::print(" {}", metric);
    fmt::print("\n");
  }
}

ExitCode list(const ListArguments& arguments, const std::atomic<bool>&, const Registry& registry) {
  std::vector<std::string> folders = arguments.paths;
  const std::string usual = here_or_installed("scenarios");
  if (folders.empty() && std::filesystem::is_directory(usual)) folders.push_back(usual);
  const std::optional<std::vector<std::string>> files = scenario_files(folders);
  if (!files) return ExitCode::usage;
  ExitCode code = ExitCode::pass;
  Json listed = {{"scenarios", scenarios(*files, registry, code)}};
  listed.update(names(registry));
  if (arguments.json)
    fmt::print("{}\n", listed.dump(2));
  else
    print_tables(listed);
  return code;
}

}  // namespace

void add_list(Commands& commands) {
  auto [command, arguments] =
      commands.add<ListArguments>("list", "what a scenario can name: scenarios found, strategies, solvers, metrics", list);
  command.optional_operands("folder", arguments.paths, "where to look for scenarios (default: scenarios)");
  command.flag("--json", arguments.json, "print the same as one JSON document, with the tags and the metrics' units");
}

}  // namespace evenstep::app
