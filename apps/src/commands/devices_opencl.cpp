// evenstep devices --opencl
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "evenstep/campaigns/opencl_check.h"
#include "src/commands.h"
#include "src/opencl_lines.h"
#include "src/progress.h"

namespace evenstep::app {
namespace {

OpenClDescription described(const OpenClListed& one) { return describe_opencl({opencl_text({one}, 0)}); }

void print_json(const std::vector<OpenClListed>& there) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  const std::size_t usual = choose_opencl(there, "", false), recorded = choose_opencl(there, "", true);
  for (std::size_t n = 0; n < there.size(); ++n) {
    const OpenClDescription said = described(there[n]);
    list.push_back({{"device", there[n].device},
                    {"platform", there[n].platform},
                    {"gpu", there[n].is_gpu},
                    {"driver", said.driver},
                    {"version", said.version},
                    {"compute_units", said.compute_units},
                    {"clock_MHz", said.clock_MHz},
                    {"timer_resolution_ns", said.timer_resolution_ns},
                    {"memory_bytes", said.memory_bytes},
                    {"used_by_run", n == usual},
                    {"used_by_record", n == recorded}});
  }
  fmt::print("{}\n", list.dump(1, ' ', false, nlohmann::json::error_handler_t::replace));
}

void print_list(const std::vector<OpenClListed>& there) {
  const std::size_t usual = choose_opencl(there, "", false), recorded = choose_opencl(there, "", true);
  for (std::size_t n = 0; n < there.size(); ++n) {
    const OpenClDescription said = described(there[n]);
    fmt::print("OpenCL: {}\n    {}, driver {}, {} compute units{}{}\n", opencl_text({there[n]}, 0),
               there[n].is_gpu ? "GPU" : "processor", said.driver, said.compute_units, n == usual ? "; runs use it" : "",
               n == recorded ? "; `record` uses it" : "");
  }
  if (there.size() > 1)
    fmt::print("another one: [scene] opencl_device = \"a part of its name\"; the results are the same\n");
}

ExitCode check_all(const std::vector<OpenClListed>& there, const std::atomic<bool>& interrupted, const Registry& registry) {
  OpenClCheckOptions usual;
  usual.interrupted = &interrupted;
  usual.read = [&](const std::string& file, const std::vector<std::string>& set) {
    return read_scenario(here_or_installed(file), {set, std::nullopt, registry, true});
  };
  CountProgress progress(isatty(STDERR_FILENO));
  std::vector<OpenClCheck> checks;
  const RecordedMachine machine = machine_here();
  for (const OpenClListed& one : there) {
    OpenClCheckOptions options = usual;
    if (one.is_gpu)
      options.blocks.insert(options.blocks.end(), {{{100, 100, 100}, 1'000'000}, {{160, 160, 157}, 4'000'000}});
    options.progress = [&, done = 0](const std::string& what) mutable {
      progress.update(++done, 0, one.device + ": " + what);
    };
    checks.push_back(check_opencl(one, options));
  }
  fmt::print("{}", check_table(checks, machine));
  if (interrupted) return ExitCode::interrupted;
  const auto any = [&](OpenClCheckRow::State state) {
    return std::any_of(checks.begin(), checks.end(), [&](const OpenClCheck& check) { return check.any(state); });
  };
  if (any(OpenClCheckRow::State::differs)) return ExitCode::not_reproducible;
  return any(OpenClCheckRow::State::missing) ? ExitCode::run_failed : ExitCode::pass;
}

}  // namespace

void print_opencl_devices() {
  try {
    print_list(opencl_devices());
  } catch (const SolverError& error) {
    fmt::print("OpenCL: none: {}; {}\n", error.what(), error.remedy());
  }
}

ExitCode opencl_devices_command(bool check, bool json, const std::atomic<bool>& interrupted, const Registry& registry) {
  try {
    const std::vector<OpenClListed>& there = opencl_devices();
    if (check) return check_all(there, interrupted, registry);
    json ? print_json(there) : print_list(there);
    return ExitCode::pass;
  } catch (const SolverError& error) {
    spdlog::error("error: {}\nremedy: {}", error.what(), error.remedy());
    return built_with_opencl() ? ExitCode::run_failed : ExitCode::usage;
  }
}

}  // namespace evenstep::app
