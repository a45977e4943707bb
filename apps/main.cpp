/// evenstep: the command line. Exit codes: 0 all expectations hold, 1 an expectation failed, 2 usage or scenario error,
/// 3 the run failed, 4 not reproducible, 130 interrupted.

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>

#include "commands.h"
#include "evenstep/harness/version.h"

namespace {

std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

/// The first signal asks the run to end in order; a second one ends the process.
void on_signal(int signal) {
  if (interrupted.exchange(true)) std::signal(signal, SIG_DFL), std::raise(signal);
}

}  // namespace

int main(int argc, char** argv) {
  using namespace evenstep;
  spdlog::set_default_logger(spdlog::stderr_logger_mt("evenstep"));
  spdlog::set_pattern("%v");
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  std::signal(SIGHUP, on_signal);
  std::signal(SIGPIPE, SIG_IGN);

  CLI::App cli{"Deterministic tests of haptic interaction under irregular simulation steps."};
  cli.name("evenstep");
  cli.set_version_flag("--version", std::string("evenstep ") + kVersion);
  cli.require_subcommand(1);
  cli.footer(
      "Exit: 0 pass, 1 expectation failed, 2 usage or scenario error, 3 run failed, 4 not reproducible, 130 interrupted.");

  app::RunArguments run;
  CLI::App* run_command = cli.add_subcommand("run", "run scenarios and judge their expectations");
  run_command->add_option("scenario", run.paths, "scenario files, or folders of them")->required();
  run_command->add_option("--clock", run.clock, "virtual (default) or wall")->check(CLI::IsMember({"virtual", "wall"}));
  run_command->add_option("--seed", run.seed, "instead of [run] seed");
  run_command->add_option("--set", run.set, "path=value, overrides the file: --set timing.visualization=\"20 ms\"")
      ->expected(1)
      ->allow_extra_args(false)
      ->take_all();
  run_command->add_option("--out", run.out,
                          "run folder (one scenario) or folder of run folders (several); default runs/<name>");
  run_command->add_flag("--repeat", run.repeat, "run twice; exit 4 and name the first differing event if the traces differ");
  run_command->add_option("--permute-ties", run.permute_ties,
                          "shuffle the order of simultaneous events of one lane with this seed");
  run_command
      ->add_option("--threads", run.threads, "strategies side by side; 0 = one per core (results do not depend on it)")
      ->check(CLI::Range(0, 1024));
  run_command->add_option("--device", run.devices,
                          "with --clock wall: drive the real device /dev/hidrawN instead of the simulated one; NAME=PATH names the "
                          "[[device]], default the first")
      ->expected(1)
      ->allow_extra_args(false)
      ->take_all();
  run_command->add_flag("--forces", run.forces, "let forces reach the real device; without it, it is only read");
  run_command->add_flag("--long", run.include_long,
                        "with a folder: also its scenarios with the tag \"long\" (a file that is named always runs)");
  run_command->add_flag("--json", run.json, "print summary.json of each run instead of tables");

  std::vector<std::string> check_paths, check_set;
  CLI::App* check_command = cli.add_subcommand("check", "read and explain scenarios, run nothing");
  check_command->add_option("scenario", check_paths, "scenario files, or folders of them")->required();
  check_command->add_option("--set", check_set, "path=value, overrides the file")->expected(1)->allow_extra_args(false)->take_all();

  bool devices_as_json = false;
  CLI::App* devices_command = cli.add_subcommand("devices", "the HID devices of this machine, and what each of them can do");
  devices_command->add_flag("--json", devices_as_json, "the list as JSON instead of text");

  std::vector<std::string> list_paths;
  CLI::App* list_command =
      cli.add_subcommand("list", "what a scenario can name: scenarios found, strategies, solvers, metrics");
  list_command->add_option("folder", list_paths, "where to look for scenarios (default: scenarios)");

  app::StudyArguments study;
  CLI::App* study_command = cli.add_subcommand("study", "error against run time of a tissue, or the largest stable stiffness in a hand");
  study_command->add_option("scenario", study.file, "a scenario file with kind = \"tissue\", or with [study] stiffness_limit")->required();
  study_command->add_option("--set", study.set, "path=value, overrides the file: --set study.repeats=9")
      ->expected(1)
      ->allow_extra_args(false)
      ->take_all();
  study_command->add_option(
      "--advise", study.advise,
      "the error to reach, \"1 % force\", \"10 um position\" or \"5 % energy\": names the cheapest method "
      "and step; exit 1 if none reaches it");
  study_command->add_option("--out", study.out, "folder for study.json, study.csv and figures; default runs/<name>-study");
  study_command->add_flag("--json", study.json, "print study.json instead of the table");

  std::string fit_file;
  bool fit_as_json = false;
  CLI::App* fit_command = cli.add_subcommand(
      "fit", "propose a [timing] table for a recording, and say whether it can stand for the recording");
  fit_command->add_option("timing.csv", fit_file, "segment,kind,index,begin_ns,end_ns")->required();
  fit_command->add_flag("--json", fit_as_json, "the numbers instead of the table");

  app::SizeArguments size;
  CLI::App* size_command = cli.add_subcommand(
      "size", "the least latency, lead and rings for which nothing underruns, what sets them, and what they cost");
  size_command->add_option("file", size.file, "a scenario, or a recording: timing.csv, or a list of steps begin_ns,end_ns")
      ->required();
  size_command->add_option("--set", size.set, "path=value, overrides the scenario")->expected(1)->allow_extra_args(false)->take_all();
  size_command->add_option("--sampling", size.sampling,
                           "of a recording: the device's period or rate, \"1 ms\" (default) or \"8 kHz\"");
  size_command->add_option("--emission", size.emission, "of a recording: how its forces are played, hold (default) or linear")
      ->check(CLI::IsMember({"hold", "linear"}));
  size_command->add_option("--damping", size.damping, "of hand and device, \"1 N s/m\" (default), for the loop's stiffness");
  size_command->add_option("--rate", size.rate, "of segments that may underrun, \"0.1 %\": what latency that takes, too");
  size_command->add_option("--confidence", size.confidence, "how sure the rate is to be, \"95 %\" (default)");
  size_command->add_flag("--json", size.json, "the numbers instead of the table");

  app::SweepArguments sweep;
  CLI::App* sweep_command = cli.add_subcommand("sweep", "every seed with every value of a scenario's [sweep], on all cores");
  sweep_command->add_option("scenario", sweep.file, "a scenario file with a [sweep]")->required();
  sweep_command->add_option("--set", sweep.set, "path=value, overrides the file: --set sweep.seeds=\"0..100\"")
      ->expected(1)
      ->allow_extra_args(false)
      ->take_all();
  sweep_command->add_option("--shard", sweep.shard, "I/N: every N-th point from the I-th on; auto: as the batch system says");
  sweep_command->add_option("--threads", sweep.threads, "points side by side; 0 = one per core (results do not depend on it)")
      ->check(CLI::Range(0, 1024));
  sweep_command->add_option("--stop-after", sweep.stop_after, "so many failures; instead of [sweep] stop_after")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1'000'000'000}));
  sweep_command->add_flag("--resume", sweep.resume, "go on where a sweep was interrupted, or start");
  sweep_command->add_option("--out", sweep.out, "folder for sweep.jsonl or sweep-I-of-N.jsonl; default runs/<name>-sweep");
  sweep_command->add_flag("--json", sweep.json, "the summary as JSON instead of text");

  app::MergeArguments merge;
  CLI::App* merge_command = cli.add_subcommand("merge", "the shards of a sweep as one file, with its summary and exit code");
  merge_command->add_option("part", merge.parts, "sweep-I-of-N.jsonl of all shards, in any order")->required();
  merge_command->add_option("--out", merge.out, "the file to write: the same bytes as of one process")->required();
  merge_command->add_flag("--json", merge.json, "the summary as JSON instead of text");

  app::ShrinkArguments shrink;
  CLI::App* shrink_command = cli.add_subcommand("shrink", "from a scenario that fails to the smallest timing that still fails");
  shrink_command->add_option("scenario", shrink.file, "a scenario file that fails")->required();
  shrink_command->add_option("--set", shrink.set, "path=value, overrides the file")->expected(1)->allow_extra_args(false)->take_all();
  shrink_command->add_option("--seed", shrink.seed, "instead of [run] seed");
  shrink_command->add_option("--expect", shrink.expect, "the line of the expectation; default: the first that fails");
  shrink_command->add_option("--max-runs", shrink.max_runs, "runs to spend; default 2000")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1'000'000'000}));
  shrink_command->add_option("--out", shrink.out, "folder for <name>-shrunk.toml and .csv; default runs/shrunk");

  std::string diff_a, diff_b;
  CLI::App* diff_command = cli.add_subcommand("diff", "the first differing event of two runs");
  diff_command->add_option("a", diff_a, "run folder or events.bin")->required();
  diff_command->add_option("b", diff_b, "run folder or events.bin")->required();

  CLI::App* schema_command = cli.add_subcommand("schema", "print the JSON Schema of scenario files, for editors");

  try {
    cli.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const bool asked_for_help = error.get_exit_code() == 0;
    cli.exit(error);
    return asked_for_help ? 0 : static_cast<int>(ExitCode::usage);
  }
  try {
    ExitCode code = ExitCode::pass;
    if (*run_command)
      code = app::run(run, interrupted);
    else if (*study_command)
      code = app::study(study, interrupted);
    else if (*check_command)
      code = app::check(check_paths, check_set);
    else if (*devices_command)
      code = app::devices(devices_as_json);
    else if (*list_command)
      code = app::list(list_paths);
    else if (*diff_command)
      code = app::diff(diff_a, diff_b);
    else if (*sweep_command)
      code = app::sweep(sweep, interrupted);
    else if (*merge_command)
      code = app::merge(merge);
    else if (*shrink_command)
      code = app::shrink(shrink, interrupted);
    else if (*size_command)
      code = app::size(size);
    else if (*fit_command)
      code = app::fit(fit_file, fit_as_json);
    else if (*schema_command)
      std::fputs(scenario_schema().c_str(), stdout);
    if (std::fflush(stdout) != 0) return static_cast<int>(ExitCode::run_failed);
    return static_cast<int>(code);
  } catch (const std::exception& error) {
    spdlog::error("evenstep: error: {}", error.what());
    return static_cast<int>(ExitCode::run_failed);
  }
}
