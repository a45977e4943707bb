#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <memory>

#include "evenstep/harness/input_log.h"
#include "evenstep/harness/recorded_timing.h"
#include "evenstep/recordings/timing_csv.h"
#include "evenstep/reports/run_failure.h"
#include "evenstep/text/text_file.h"
#include "src/commands.h"
#include "src/recording_options.h"

namespace evenstep::app {
namespace {

struct ImportArguments {
  std::string file, out;
  bool list = false, strict = false;
  RecordingArguments recording;
};

std::string length_text(Duration length) {
  const auto ns = static_cast<double>(length.ns);
  if (length.ns < 1'000'000) return fmt::format("{:.4g} us", ns / 1e3);
  return length.ns < 1'000'000'000 ? fmt::format("{:.4g} ms", ns / 1e6) : fmt::format("{:.4g} s", ns / 1e9);
}

void print_head(const Profile& profile) {
  RealTime end = profile.intervals.front().end;
  for (const ProfileInterval& interval : profile.intervals) end = std::max(end, interval.end);
  fmt::print("{}: {}, {} intervals in {}\ntime base: {}\n", profile.file, profile.format, profile.intervals.size(),
             length_text(end - profile.intervals.front().begin), profile.time_base);
}

/// How many intervals come from where; of a source with several queues also from which.
void print_sources(const Profile& profile) {
  std::vector<std::int64_t> of_track(profile.tracks.size()), of_source(profile.sources.size()), queues(of_source.size());
  for (const ProfileInterval& interval : profile.intervals) ++of_track[interval.track];
  for (std::size_t i = 0; i < of_track.size(); ++i) {
    of_source[profile.tracks[i].source] += of_track[i];
    queues[profile.tracks[i].source] += profile.tracks[i].order == TrackOrder::follow;
  }
  for (std::size_t i = 0; i < of_source.size(); ++i) {
    if (!profile.sources[i].empty()) fmt::print("from {}: {} intervals\n", profile.sources[i], of_source[i]);
    for (std::size_t k = 0; k < of_track.size() && queues[i] > 1; ++k) {
      const ProfileTrack& track = profile.tracks[k];
      if (track.source == i && track.order == TrackOrder::follow)
        fmt::print("from {}, {}: {} intervals\n", profile.sources[i], track.lane, of_track[k]);
    }
  }
}

void print_clipped(const Profile& profile) {
  if (profile.clipped.count > 0)
    fmt::print("clipped: {} intervals run over the next begin of their thread or queue, and end there now; the first: {}\n",
               profile.clipped.count, profile.clipped.first);
}

/// `roles`: what they would take is marked.
bool print_list(const Profile& profile, const Roles& roles) {
  const std::vector<NameSummary> names = summarize(profile);
  std::vector<std::string> marks(names.size());
  if (!roles.unset()) {
    RoleMarks marked = mark_roles(profile, roles, names);
    if (!marked) {
      print(marked.error());
      return false;
    }
    marks = *std::move(marked);
  }
  print_sources(profile);
  fmt::print("{:>8}  {:>10}  {:>10}  name\n", "count", "median", "period");
  for (std::size_t i = 0; i < names.size(); ++i) {
    const NameSummary& name = names[i];
    fmt::print("{:>8}  {:>10}  {:>10}  {}{}{}{}\n", name.count, length_text(name.median),
               name.period ? length_text(*name.period) : "", name.category, name.category.empty() ? "" : ": ", name.text,
               marks[i].empty() ? "" : fmt::format("  <- {}", marks[i]));
  }
  return true;
}

void print_left_out(const std::vector<LeftOut>& left_out) {
  for (const LeftOut& left : left_out) {
    fmt::print("left out: {} {}{}\n", left.count, left.what,
               left.first.empty() ? "" : fmt::format(", the first: {}", left.first));
  }
}

void print_assigned(const AssignedRoles& assigned) {
  if (assigned.guessed) {
    std::string options;
    const auto add = [&](const char* option, const std::string& value) {
      if (!value.empty()) options += fmt::format(" --{} '{}'", option, value);
    };
    add("segment", assigned.roles.segment);
    add("visualization", assigned.roles.visualization);
    add("step", assigned.roles.step);
    fmt::print("guessed:{}\n", options);
  }
  constexpr std::size_t kMostShown = 20;
  for (std::size_t i = 0; i < std::min(assigned.became.size(), kMostShown); ++i)
    fmt::print("{}: {} of '{}'\n", assigned.became[i].role, assigned.became[i].count, assigned.became[i].name);
  if (assigned.became.size() > kMostShown) fmt::print("and {} more names\n", assigned.became.size() - kMostShown);
  if (assigned.merged > 0)
    fmt::print("merged: {} intervals into the step or visualization that they are a part of\n", assigned.merged);
  if (assigned.cut > 0)
    fmt::print("cut: {} pictures begin before the one before them ends, and are taken to begin there\n", assigned.cut);
  if (assigned.clipped > 0)
    fmt::print("warning: {} steps and visualizations had no end of their own: they end where the next one begins\n",
               assigned.clipped);
  print_left_out(assigned.left_out);
  std::size_t shown = 0, steps = 0;
  for (const SegmentTiming& segment : assigned.segments) {
    shown += segment.visualization.has_value();
    steps += segment.steps.size();
  }
  fmt::print("{} segments with {} visualizations and {} steps, {} long\n", assigned.segments.size(), shown, steps,
             length_text(assigned.segments.back().end - RealTime{}));
  if (steps > 0 && assigned.roles.step_begin.empty() && assigned.roles.steps == 0)
    fmt::print("each interval that matches is a step; where several make up one, say which it begins with: --step-begin\n");
  if (steps == 0)
    fmt::print(
        "without steps there is nothing to run: say how many follow each visualization, --steps 8 --step-time \"1.2 ms\"\n");
}

/// False on an error, which is then printed.
bool write(const std::string& path, const std::function<void(std::ostream&)>& timing) {
  const std::string error = internal::write_text_file(path, timing);
  if (!error.empty())
    print({{path, 0, 0, error}});
  else
    fmt::print("wrote {}\n", path);
  return error.empty();
}

/// A recording of a live run itself says what its segments and steps are. A long one has its rows in files, beside the file
/// that is written. Throws RunFailure if there is no room for them.
ExitCode import_live_run(const ImportArguments& arguments) {
  const bool writes = !arguments.out.empty() && !arguments.list;
  namespace fs = std::filesystem;
  const bool beside = writes && (!fs::exists(arguments.out) || fs::is_regular_file(arguments.out));  // no pipe or device
  const fs::path place = beside ? fs::path(arguments.out + "/..").lexically_normal() : fs::temp_directory_path();
  const InputLogResult log = read_input_log(arguments.file, {false, std::make_shared<RowFiles>(place)});
  if (!log) {
    print(log.error());
    return ExitCode::usage;
  }
  fmt::print("{}: recording of a live run, {} segments with {} steps, {} long\n", arguments.file, log->rows.segments.size(),
             log->rows.steps.size(), length_text(log->until() - RealTime{}));
  if (!writes) return ExitCode::pass;
  const auto timing = [&](std::ostream& out) { write_recorded_timing(log->rows, out); };
  return write(arguments.out, timing) ? ExitCode::pass : ExitCode::run_failed;
}

/// A timing.csv, or a list of steps, whose segments are then found.
ExitCode import_timing(const ImportArguments& arguments) {
  if (!recording_words(arguments.recording).empty()) {
    print({{arguments.file, 0, 0,
            "is a timing.csv or a list of steps: its columns are known, and it has no names; remove "
            "what says which of a profiler's names are what"}});
    return ExitCode::usage;
  }
  const Recording csv = read_recording(arguments.file);
  if (!csv) {
    print(csv.error());
    return ExitCode::usage;
  }
  std::size_t steps = 0;
  for (const SegmentTiming& segment : *csv) steps += segment.steps.size();
  fmt::print("{}: timing, {} segments with {} steps, {} long\n", arguments.file, csv->size(), steps,
             length_text(csv->back().end - csv->front().begin));
  if (arguments.out.empty() || arguments.list) return ExitCode::pass;
  const auto timing = [&](std::ostream& out) { out << format_timing_csv(*csv); };
  return write(arguments.out, timing) ? ExitCode::pass : ExitCode::run_failed;
}

/// False on an error, which is then printed.
bool write_assigned(const std::string& path, const AssignedRoles& assigned) {
  return write(path, [&, at = std::size_t{0}](std::ostream& out) mutable {
    write_timing_csv(out, [&] { return at < assigned.segments.size() ? &assigned.segments[at++] : nullptr; });
  });
}

ExitCode import(const ImportArguments& arguments, const std::atomic<bool>&) {
  try {
    if (is_input_log(arguments.file)) return import_live_run(arguments);
  } catch (const RunFailure& failure) {
    spdlog::error("error: {}; {}", failure.what(), failure.remedy);
    return ExitCode::run_failed;
  }
  if (is_timing_csv(arguments.file)) return import_timing(arguments);
  const std::optional<RecordingOptions> options = recording_options(arguments.recording);
  if (!options) return ExitCode::usage;
  const ProfileResult profile = read_profile(arguments.file, options->profile);
  if (!profile) {
    print(profile.error());
    return ExitCode::usage;
  }
  const Roles roles = with_preset(options->roles, options->preset);
  print_head(*profile);
  if (arguments.list) {
    if (!print_list(*profile, roles)) return ExitCode::usage;
    print_clipped(*profile);
    print_left_out(profile->left_out);
    return ExitCode::pass;
  }
  const AssignedRolesResult assigned = assign_roles(*profile, roles);
  if (!assigned) {
    print(assigned.error());
    return ExitCode::usage;
  }
  print_clipped(*profile);
  print_assigned(*assigned);
  if (!arguments.out.empty() && !write_assigned(arguments.out, *assigned)) return ExitCode::run_failed;
  const std::string damage = assigned->damage();
  if (damage.empty()) return ExitCode::pass;
  fmt::print("warning: {}\n", damage);
  return arguments.strict ? ExitCode::expectation_failed : ExitCode::pass;
}

}  // namespace

void add_import(Commands& commands) {
  auto [command, arguments] = commands.add<ImportArguments>(
      "import", "a profiler's file as timing.csv: which of its names are segments, visualizations and steps", import);
  command.operand(
      "file", arguments.file,
      "Nsight Systems or rocpd SQLite, CSV, PresentMon, trace events (JSON, also gzipped), Tracy, Unreal, any CSV, or a "
      "recording of `run --record`");
  command.flag("--list", arguments.list,
               "only its names, with count, median length and period, and which of them the roles given would take");
  command.flag("--strict", arguments.strict, "exit with 1 if more than 1 % was merged, clipped or left out unasked");
  command.option("--out,-o", arguments.out, "the timing.csv to write; without it nothing is written");
  add_recording_options(command, arguments.recording);
}

}  // namespace evenstep::app
