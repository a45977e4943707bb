#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "evenstep/apps/origin.h"
#include "evenstep/apps/shell.h"
#include "evenstep/campaigns/size.h"
#include "evenstep/campaigns/size_fits.h"
#include "evenstep/clock/wall_clock.h"
#include "evenstep/harness/run_folder.h"
#include "evenstep/pages/campaign_pages.h"
#include "evenstep/recordings/timing_csv.h"
#include "evenstep/reports/writers.h"
#include "src/commands.h"
#include "src/merged_results.h"
#include "src/output.h"
#include "src/part_arguments.h"
#include "src/progress.h"
#include "src/recording_options.h"

namespace evenstep::app {
namespace {

struct SizeArguments {
  std::string program;
  std::string file;
  std::vector<std::string> set;
  std::vector<std::string> what_if, split, budget, pace, own_lane;
  std::string sampling, step_size, emission, damping, rate, confidence, per, fits, junit, figure, report, timing, seeds;
  std::string worst_order, worst_timing, within;
  PartArguments part;
  bool json = false, other_maps = false, adaptive = false, spread = false;
  RecordingArguments recording;
};

/// What an option says, or the clause of --fits that says it instead; nullopt if both do, which is then printed.
struct Asked {
  std::string option, value;
};
std::optional<Asked> asked(const char* option, const std::string& value, const std::string& clause) {
  if (clause.empty()) return Asked{option, value};
  if (value.empty()) return Asked{"--fits", clause};
  print({{option, 0, 0, "is said by --fits, too; leave out one of them"}});
  return std::nullopt;
}

/// --rate, --per and --confidence; false on an error, which is then printed.
bool read_rate(const SizeArguments& arguments, SizeOptions& options) {
  const SizeFits fits = options.fits.value_or(SizeFits{});
  const std::optional<Asked> rate = asked("--rate", arguments.rate, fits.rate),
                             per = asked("--per", arguments.per, fits.per),
                             sure = asked("--confidence", arguments.confidence, fits.confidence);
  if (!rate || !per || !sure) return false;
  if (rate->value.empty() && per->value.empty() && !sure->value.empty()) {
    print(
        {{sure->option, 0, 0, "a confidence goes with a rate or a span, which say of what; for example --rate \"0.1 %\""}});
    return false;
  }
  if (!rate->value.empty() && !(options.rate = option_value(rate->option, parse_share(rate->value)))) return false;
  if (!per->value.empty()) {
    options.per = option_value(per->option, parse_span(per->value));
    if (!options.per) return false;
  }
  if (sure->value.empty()) return true;
  const std::optional<double> confidence = option_value(sure->option, parse_share(sure->value));
  options.confidence = confidence.value_or(options.confidence);
  return confidence.has_value();
}

/// --split 2 is --what-if "split 2".
std::vector<std::pair<std::string, const std::vector<std::string>*>> what_if_options(const SizeArguments& arguments) {
  return {{"split", &arguments.split},
          {"budget", &arguments.budget},
          {"pace", &arguments.pace},
          {"own-lane", &arguments.own_lane},
          {"what-if", &arguments.what_if}};
}

/// False on an error, which is then printed.
bool read_what_ifs(const SizeArguments& arguments, SizeOptions& options) {
  if (arguments.spread) options.what_ifs.push_back({.spread = true});
  for (const auto& [name, values] : what_if_options(arguments)) {
    for (const std::string& value : *values) {
      const Result<WhatIf> parsed = parse_what_if(name == "what-if" ? value : name + " " + value);
      if (!parsed) {
        print({{"--" + name, 0, 0, parsed.error()}});
        return false;
      }
      options.what_ifs.push_back(*parsed);
    }
  }
  return true;
}

std::optional<SizeOptions> options_of(const SizeArguments& arguments) {
  SizeOptions options;
  if (!arguments.sampling.empty()) {
    const std::optional<Rate> rate = option_value("--sampling", parse_period_or_rate(arguments.sampling));
    if (!rate) return std::nullopt;
    options.sampling = *rate;
  }
  if (!arguments.step_size.empty()) {
    const std::optional<Rate> rate = option_value("--step-size", parse_period_or_rate(arguments.step_size));
    if (!rate) return std::nullopt;
    options.step_size = *rate;
  }
  options.other_maps = arguments.other_maps;
  if (arguments.emission == "linear") options.emission = Emission::linear;
  if (!arguments.damping.empty()) {
    const std::optional<double> damping =
        option_value("--damping", parse_above_zero(arguments.damping, Dimension::damping, "N s/m"));
    if (!damping) return std::nullopt;
    options.damping_N_s_per_m = *damping;
  }
  options.adaptive = arguments.adaptive;
  if (!arguments.fits.empty()) {
    const Result<SizeFits> fits = parse_fits(arguments.fits);
    if (!fits) {
      print({{"--fits", 0, 0, fits.error()}});
      return std::nullopt;
    }
    options.fits = *fits;
  }
  if (!arguments.worst_order.empty()) {
    const Result<WorstOrderAsked> asked = parse_worst_order(arguments.worst_order);
    if (!asked) {
      print({{"--worst-order", 0, 0, asked.error()}});
      return std::nullopt;
    }
    options.worst_order = *asked;
  } else if (!arguments.worst_timing.empty()) {
    print({{"--worst-timing", 0, 0, "is the timing that --worst-order finds; for example --worst-order \"1 s\""}});
    return std::nullopt;
  }
  if (!read_rate(arguments, options) || !read_what_ifs(arguments, options)) return std::nullopt;
  return options;
}

SizeResult sized(const SizeArguments& arguments, const SizeOptions& options, const RecordingOptions& recording,
                 const Registry& registry) {
  if (std::filesystem::path(arguments.file).extension() != ".toml") {
    if (arguments.set.empty()) return size_recording(arguments.file, options, recording);
    return {{}, {}, {{"--set", 0, 0, "belongs to a scenario (*.toml); a recording has no keys to set"}}};
  }
  if (!arguments.sampling.empty() || !arguments.emission.empty())
    return {{},
            {},
            {{arguments.file, 0, 0, "--sampling and --emission belong to a recording; a scenario says so in [[device]]"}}};
  if (!arguments.step_size.empty())
    return {{}, {}, {{"--step-size", 0, 0, "belongs to a recording; a scenario says so in [scene] step_size"}}};
  const ReadResult read = read_scenario(arguments.file, {arguments.set, std::nullopt, registry});
  if (!read) return {{}, {}, read.error()};
  return size_scenario(*read, options);
}

/// The command that does this again.
std::string again(const SizeArguments& arguments) {
  std::string command = fmt::format("{} size {}", arguments.program, shell_file(arguments.file));
  for (const std::string& set : arguments.set) command += " --set " + shell_word(set);
  const auto option = [&](const char* name, const std::string& value) {
    if (!value.empty()) command += fmt::format(" {} {}", name, shell_word(value));
  };
  option("--sampling", arguments.sampling);
  option("--emission", arguments.emission);
  option("--step-size", arguments.step_size);
  option("--damping", arguments.damping);
  option("--rate", arguments.rate);
  option("--confidence", arguments.confidence);
  option("--per", arguments.per);
  option("--fits", arguments.fits);
  command += recording_words(arguments.recording);
  if (arguments.other_maps) command += " --other-maps";
  for (const auto& [name, values] : what_if_options(arguments))
    for (const std::string& value : *values) command += fmt::format(" --{} {}", name, shell_word(value));
  if (arguments.spread) command += " --spread";
  if (arguments.adaptive) command += " --adaptive";
  option("--worst-order", arguments.worst_order);
  option("--worst-timing", arguments.worst_timing);
  option("--timing", arguments.timing);
  option("--report", arguments.report);
  option("--out", arguments.part.out);
  return command;
}

/// False on an error, which is then printed.
bool write_report(const SizeArguments& arguments, const SizeRecord& record) {
  return arguments.report.empty() || write_text(arguments.report, size_page(record, again(arguments)));
}

/// False on an error, which is then printed.
bool write_timing(const std::string& path, SizeResult& result) {
  if (!write_text(path, format_timing_csv(result.segments))) return false;
  result.record.trace = path;
  result.record.trace_roles.clear();
  return true;
}

/// Before anything is sized: whether the run folder of --fits can be written, and the date that it bears. An error is
/// printed.
ExitCode look_at_folder(const std::string& folder, std::string& date) {
  if (folder.empty()) return ExitCode::pass;
  const Result<std::string> found = date_of_run(std::getenv, unix_seconds());
  if (!found) {
    print({{"SOURCE_DATE_EPOCH", 0, 0, found.error()}});
    return ExitCode::usage;
  }
  date = *found;
  const std::string objection = run_folder_objection(folder);
  if (!objection.empty()) spdlog::error("error: {}", objection);
  return objection.empty() ? ExitCode::pass : ExitCode::run_failed;
}

/// --fits with --out: a run folder, for `compare` and `index`. False on an error, which is then printed.
bool write_fit_folder(const SizeArguments& arguments, const SizeRecord& record, const std::string& date,
                      const JunitSuite& suite) {
  if (arguments.part.out.empty()) return true;
  RunOutcome outcome = fit_outcome(record);
  outcome.record.scenario = arguments.fits;
  outcome.record.origin = {date, commit_of(arguments.file, std::getenv)};
  const std::string error = write_folder(arguments.part.out, {{kSummaryFile, summary_of(outcome)},
                                                              {"junit.xml", junit_xml({&suite, 1})},
                                                              {kReportFile, size_page(record, again(arguments))}});
  if (!error.empty()) spdlog::error("error: {}", error);
  return error.empty();
}

/// Says for a CI whether it fits.
ExitCode judge_fit(const SizeArguments& arguments, const SizeRecord& record, const std::string& date) {
  const std::string why = lacking(record);
  const ExitCode code = why.empty() ? ExitCode::pass : ExitCode::expectation_failed;
  if (!why.empty() && !arguments.json) fmt::print("{}\nagain: {}\n", why, again(arguments));
  const std::string words = why.empty() ? "FITS" : "DOES NOT FIT", command = again(arguments);
  if (!why.empty())
    annotate(AnnotationLevel::error, {arguments.file, 0, 0}, "evenstep size --fits " + shell_word(arguments.fits),
             why + "\nagain: " + command);
  add_to_job_summary({{arguments.file, words, why.empty() ? arguments.fits : why}}, "");
  JunitSuite suite{.scenario = arguments.fits, .file = arguments.file};
  suite.whole = why.empty() ? JunitSuite::Whole::passed : JunitSuite::Whole::failed;
  suite.why = why;
  suite.reproduce = command;
  const bool written = arguments.junit.empty() || write_text(arguments.junit, junit_xml({&suite, 1}));
  return write_fit_folder(arguments, record, date, suite) && written ? code : ExitCode::run_failed;
}

/// --seeds: the segments of many seeds as one sample.
ExitCode size_many_seeds(const SizeArguments& arguments, const SizeOptions& rates, const std::atomic<bool>& interrupted,
                         const Registry& registry) {
  const Result<std::pair<std::uint64_t, std::int64_t>> seeds = parse_seeds(arguments.seeds);
  if (!seeds) {
    print({{"--seeds", 0, 0, seeds.error()}});
    return ExitCode::usage;
  }
  SizeSeedsOptions options;
  options.set = arguments.set;
  options.registry = registry;
  options.first_seed = seeds->first;
  options.seeds = seeds->second;
  options.rate = *rates.rate;
  options.confidence = rates.confidence;
  options.other_maps = rates.other_maps;
  if (!put_part(arguments.part, folder_for(arguments.part, arguments.file, "size"), interrupted, options))
    return ExitCode::usage;
  SizeSeedsOutcome outcome;
  {
    CountProgress progress(isatty(STDERR_FILENO));
    options.progress = [&](std::int64_t done, std::int64_t of, std::int64_t) { progress.update(done, of, ""); };
    outcome = size_seeds(arguments.file, options);
  }
  if (!said_why(outcome)) return outcome.exit;
  if (outcome.exit == ExitCode::interrupted)
    spdlog::error("interrupted after {} seeds; --resume goes on from there", outcome.done);
  else if (options.shard.of == 1)
    fmt::print("{}", arguments.json ? size_rates_json(outcome.record) : size_rates_text(outcome.record));
  if (!arguments.json) fmt::print("{} of {} seeds in {}\n", outcome.done, outcome.items, outcome.file);
  return outcome.exit;
}

/// What does not go together with --seeds, or only with it; empty if all is well.
std::string seeds_objection(const SizeArguments& arguments) {
  if (arguments.seeds.empty())
    return arguments.part.in_parts() || arguments.part.of || arguments.part.threads ||
                   (!arguments.part.out.empty() && arguments.fits.empty())
               ? "--shard, --of, --threads, --resume and --out divide the seeds of --seeds, with --rate; --out is also the "
                 "run folder of --fits"
               : "";
  if (arguments.rate.empty()) return "--seeds makes the sample for --rate larger; for example --rate \"0.1 %\"";
  if (std::filesystem::path(arguments.file).extension() != ".toml")
    return "--seeds belongs to a scenario (*.toml); a recording has one timing";
  const bool other = !arguments.figure.empty() || !arguments.report.empty() || !arguments.timing.empty() ||
                     !arguments.sampling.empty() || !arguments.emission.empty() || !arguments.damping.empty() ||
                     !arguments.step_size.empty() || !arguments.per.empty() || !arguments.fits.empty() ||
                     !arguments.worst_order.empty() || arguments.adaptive || arguments.spread ||
                     !recording_words(arguments.recording).empty();
  const auto options = what_if_options(arguments);
  const bool what_if =
      std::any_of(options.begin(), options.end(), [](const auto& option) { return !option.second->empty(); });
  return other || what_if ? "--seeds finds rates of the scenario as it is; leave out --figure, --report, --timing, "
                            "--damping, --per, --fits, --worst-order, "
                            "what-ifs and what belongs to a recording"
                          : "";
}

/// --within: for every schedule within bounds, without a file.
ExitCode size_all_within(const SizeArguments& arguments, const SizeOptions& options) {
  const auto what_ifs = what_if_options(arguments);
  const bool other =
      arguments.other_maps || arguments.adaptive || arguments.spread || arguments.part.in_parts() ||
      !recording_words(arguments.recording).empty() || !arguments.set.empty() ||
      std::any_of(what_ifs.begin(), what_ifs.end(), [](const auto& option) { return !option.second->empty(); });
  const std::string* const words[] = {&arguments.file,   &arguments.damping, &arguments.rate,        &arguments.confidence,
                                      &arguments.per,    &arguments.fits,    &arguments.worst_order, &arguments.junit,
                                      &arguments.figure, &arguments.report,  &arguments.timing,      &arguments.seeds};
  if (other || std::any_of(std::begin(words), std::end(words), [](const std::string* word) { return !word->empty(); })) {
    print({{"--within", 0, 0,
            "is for all schedules within bounds, so there is no file; it goes with --sampling, --emission, --step-size and "
            "--json"}});
    return ExitCode::usage;
  }
  const Result<WithinBounds> bounds = parse_within(arguments.within);
  const Result<SizeWithin> sized = bounds ? size_within(*bounds, options) : Failure(bounds.error());
  if (!sized) {
    print({{"--within", 0, 0, sized.error()}});
    return ExitCode::usage;
  }
  fmt::print("{}", arguments.json ? size_within_json(*sized) : size_within_text(*sized));
  return ExitCode::pass;
}

ExitCode size(const SizeArguments& arguments, const std::atomic<bool>& interrupted, const Registry& registry) {
  if (!arguments.within.empty()) {
    const std::optional<SizeOptions> options = options_of(arguments);
    return options ? size_all_within(arguments, *options) : ExitCode::usage;
  }
  if (arguments.file.empty() == arguments.part.status.empty()) {
    print({{"size", 0, 0,
            "takes a scenario or a recording, or --within, or --status and the folder of the parts of --seeds"}});
    return ExitCode::usage;
  }
  if (!arguments.part.status.empty()) return print_parts_status(arguments.part, "size");
  if (const std::string objection = seeds_objection(arguments); !objection.empty()) {
    print({{"size", 0, 0, objection}});
    return ExitCode::usage;
  }
  if (arguments.fits.empty() && !arguments.junit.empty()) {
    print({{"--junit", 0, 0, "is the verdict of --fits; for example --fits \"latency 20 ms\""}});
    return ExitCode::usage;
  }
  const std::optional<SizeOptions> options = options_of(arguments);
  if (!options) return ExitCode::usage;
  if (!arguments.seeds.empty()) return size_many_seeds(arguments, *options, interrupted, registry);
  const std::optional<RecordingOptions> recording = recording_options(arguments.recording);
  if (!recording) return ExitCode::usage;
  std::string date;
  if (const ExitCode code = look_at_folder(arguments.part.out, date); code != ExitCode::pass) return code;
  SizeResult result = sized(arguments, *options, *recording, registry);
  if (!result.errors.empty()) {
    print(result.errors);
    return ExitCode::usage;
  }
  if (!result.damage.empty()) spdlog::warn("{}: {}", arguments.file, result.damage);
  if (result.record.fit && !result.record.fit->refused.empty()) {
    print({{"--fits", 0, 0, result.record.fit->refused}});
    return ExitCode::usage;
  }
  if (result.record.worst_order && !result.record.worst_order->refused.empty()) {
    print({{"--worst-order", 0, 0, result.record.worst_order->refused}});
    return ExitCode::usage;
  }
  const std::string figure = arguments.figure.empty() ? "" : size_svg(result.record);
  if (!arguments.figure.empty() && figure.empty()) {
    print({{arguments.figure, 0, 0, "there is no curve to draw: too many steps, or none; size a part of the recording"}});
    return ExitCode::usage;
  }
  if (!figure.empty() && !write_text(arguments.figure, figure)) return ExitCode::run_failed;
  if (!arguments.timing.empty() && !write_timing(arguments.timing, result)) return ExitCode::run_failed;
  if (!arguments.worst_timing.empty()) {
    if (!write_text(arguments.worst_timing, format_timing_csv(result.worst))) return ExitCode::run_failed;
    result.record.worst_order->file = arguments.worst_timing;
  }
  if (!write_report(arguments, result.record)) return ExitCode::run_failed;
  fmt::print("{}", arguments.json ? size_json(result.record) : size_text(result.record));
  return result.record.fit ? judge_fit(arguments, result.record, date) : ExitCode::pass;
}

}  // namespace

std::optional<ExitCode> size_results(const Merged& merged) {
  const Result<std::pair<std::uint64_t, std::int64_t>> seeds = parse_seeds(merged.subject.seeds);
  if (!seeds) {
    print({{merged.file, 1, 0, seeds.error()}});
    return std::nullopt;
  }
  SizeSeedsOptions options;
  options.set = merged.subject.set;
  options.registry = merged.registry;
  options.first_seed = seeds->first;
  options.seeds = seeds->second;
  options.rate = merged.subject.rate;
  options.confidence = merged.subject.confidence;
  options.other_maps = merged.subject.other_maps;
  options.complete_file = merged.file;
  options.interrupted = &merged.interrupted;
  const SizeSeedsOutcome outcome = size_seeds(merged.subject.file, options);
  if (!said_why(outcome)) return std::nullopt;
  fmt::print("{}", merged.json ? size_rates_json(outcome.record) : size_rates_text(outcome.record));
  if (!merged.json) fmt::print("{} seeds in {}\n", outcome.items, outcome.file);
  return outcome.exit;
}

void add_size(Commands& commands) {
  auto [command, arguments] = commands.add<SizeArguments>(
      "size", "the least latency, lead and rings for which nothing underruns, what sets them, and what they cost", size);
  arguments.program = commands.program();
  command.optional_operand("file", arguments.file,
                           "a scenario, or a recording: timing.csv, a list of steps begin_ns,end_ns, or a profiler's file");
  command.repeated("--set", arguments.set, "path=value, overrides the scenario");
  command.option("--sampling", arguments.sampling,
                 "of a recording: the device's period or rate, \"1 ms\" (default) or \"8 kHz\"");
  command.option("--emission", arguments.emission, {"hold", "linear"},
                 "of a recording: how its forces are played, hold (default) or linear");
  command.option(
      "--step-size", arguments.step_size,
      "of a recording: what a step simulates, \"11.1 ms\" or \"90 Hz\": whether steps follow a clock of their own");
  command.option("--damping", arguments.damping, "of hand and device, \"1 N s/m\" (default), for the loop's stiffness");
  command.option("--rate", arguments.rate, "of segments that may underrun, \"0.1 %\": what latency that takes, too");
  command.option("--per", arguments.per, "\"1 h\": what latency has one late segment in so long at most, or --rate of them");
  command.option("--confidence", arguments.confidence, "how sure the rate or the span is to be, \"95 %\" (default)");
  command.option(
      "--fits", arguments.fits,
      "\"latency 20 ms, lead 2 ms, rings 64 32, map clocked, per 1 h\": whether what your program has is enough; else "
      "exit 1");
  command.option("--junit", arguments.junit, "file.xml: the verdict of --fits");
  command.flag("--spread", arguments.spread, "what if steps waited for their slots instead of following each other at once");
  command.repeated("--split", arguments.split, "parts: what if each drawing were made in so many, with steps between them");
  command.repeated("--budget", arguments.budget,
                   "\"20 ms [merge|skip|hold]\": what if a pause could take at most that (docs/choose/pauses.md)");
  command.repeated("--pace", arguments.pace, "\"90 %\", \"33 ms\": what if segments kept to a grid");
  command.repeated(
      "--own-lane", arguments.own_lane,
      "factor: what if drawings had a lane of their own, and steps beside one were so many times slower; \"1.3, spread\" "
      "spreads the steps, too");
  command.repeated("--what-if", arguments.what_if, "\"split 2, budget 20 ms hold\": several at once");
  command.flag("--adaptive", arguments.adaptive, "of each what-if also a latency that adapts");
  command.option("--seeds", arguments.seeds, "\"0..1000\", of a scenario: the segments of all these seeds, for --rate");
  add_part_options(command, arguments.part, "sizing", "seeds");
  command.option("--out,-o", arguments.part.out,
                 "folder for size.jsonl or size-I-of-N.jsonl; default runs/<name>-size; with --fits a run folder, for "
                 "compare and index");
  command.option("--figure", arguments.figure, "file.svg: latency against velocity jump, of any path and of the maps");
  command.option("--report", arguments.report, "file.html: all of it as one page");
  command.option("--timing", arguments.timing, "file.csv: the segments that were sized, for [timing] trace");
  command.option(
      "--worst-order", arguments.worst_order,
      "\"1 s\", \"1 s, map paper\": what if its hitches came together, as many in so long as ever in it: searches "
      "orders of its segments");
  command.option("--worst-timing", arguments.worst_timing,
                 "file.csv: the worst order found, of the map to use or named, for [timing] trace");
  command.option(
      "--within", arguments.within,
      "\"visualization 9 ms .. 14 ms, step 1.2 ms .. 1.9 ms, steps 10 .. 20\", without a file: what is enough for "
      "every such schedule; with --step-size instead of steps, for a loop that keeps real time");
  command.flag("--other-maps", arguments.other_maps,
               "also JACK's loop and liblsl's line, for comparison (docs/choose/alternatives.md)");
  command.flag("--json", arguments.json, "the numbers instead of the table");
  add_recording_options(command, arguments.recording);
}

}  // namespace evenstep::app
