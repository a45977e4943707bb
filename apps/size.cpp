#include <fmt/format.h>

#include <filesystem>

#include "commands.h"
#include "evenstep/campaigns/size.h"

namespace evenstep::app {
namespace {

/// A period or a rate; empty on an error, which is then printed.
std::optional<Rate> sampling_rate(const std::string& text) {
  const Parsed<Rate> rate = parse_rate(text);
  if (rate.ok()) return rate.value;
  const Parsed<Duration> period = parse_duration(text);
  if (period.ok() && period.value.ns > 0 && period.value.ns <= 1'000'000'000) return Rate{1'000'000'000, period.value.ns};
  print({{"--sampling", 0, 0, fmt::format("\"{}\" is no period of at most 1 s, such as \"1 ms\", and no rate, such as \"1 kHz\"", text)}});
  return std::nullopt;
}

/// Between 0 and 1; empty on an error, which is then printed.
std::optional<double> share(const std::string& option, const std::string& text) {
  const Parsed<double> parsed = parse_si(text, Dimension::ratio);
  if (parsed.ok() && parsed.value > 0 && parsed.value < 1) return parsed.value;
  print({{option, 0, 0, parsed.ok() ? fmt::format("\"{}\" must be above 0 % and below 100 %", text) : parsed.error}});
  return std::nullopt;
}

/// --rate and --confidence; false on an error, which is then printed.
bool read_rate(const SizeArguments& arguments, SizeOptions& options) {
  if (arguments.rate.empty() && !arguments.confidence.empty()) {
    print({{"--confidence", 0, 0, "goes with --rate, which says of what; for example --rate \"0.1 %\""}});
    return false;
  }
  if (arguments.rate.empty()) return true;
  options.rate = share("--rate", arguments.rate);
  if (!options.rate || arguments.confidence.empty()) return options.rate.has_value();
  const std::optional<double> confidence = share("--confidence", arguments.confidence);
  options.confidence = confidence.value_or(options.confidence);
  return confidence.has_value();
}

std::optional<SizeOptions> options_of(const SizeArguments& arguments) {
  SizeOptions options;
  if (!arguments.sampling.empty()) {
    const std::optional<Rate> rate = sampling_rate(arguments.sampling);
    if (!rate) return std::nullopt;
    options.sampling = *rate;
  }
  if (arguments.emission == "linear") options.emission = Emission::linear;
  if (!arguments.damping.empty()) {
    const Parsed<double> damping = parse_si(arguments.damping, Dimension::damping);
    if (!damping.ok() || damping.value <= 0) {
      print({{"--damping", 0, 0, damping.ok() ? "must be above 0 N s/m" : damping.error}});
      return std::nullopt;
    }
    options.damping_N_s_per_m = damping.value;
  }
  if (!read_rate(arguments, options)) return std::nullopt;
  return options;
}

SizeResult sized(const SizeArguments& arguments, const SizeOptions& options) {
  if (std::filesystem::path(arguments.file).extension() != ".toml") {
    if (arguments.set.empty()) return size_recording(arguments.file, options);
    return {{}, {{"--set", 0, 0, "belongs to a scenario (*.toml); a recording has no keys to set"}}};
  }
  if (!arguments.sampling.empty() || !arguments.emission.empty())
    return {{}, {{arguments.file, 0, 0, "--sampling and --emission belong to a recording; a scenario says so in [[device]]"}}};
  const ReadResult read = read_scenario(arguments.file, {arguments.set, std::nullopt});
  if (!read.scenario) return {{}, read.errors};
  return size_scenario(*read.scenario, options);
}

}  // namespace

ExitCode size(const SizeArguments& arguments) {
  const std::optional<SizeOptions> options = options_of(arguments);
  if (!options) return ExitCode::usage;
  const SizeResult result = sized(arguments, *options);
  if (!result.errors.empty()) {
    print(result.errors);
    return ExitCode::usage;
  }
  fmt::print("{}", arguments.json ? size_json(result.record) : size_text(result.record));
  return ExitCode::pass;
}

}  // namespace evenstep::app
