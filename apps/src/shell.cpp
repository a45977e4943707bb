#include "evenstep/apps/shell.h"

#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

#include <algorithm>
#include <filesystem>
#include <vector>

#include "evenstep/format/reader.h"

namespace evenstep {
namespace {

/// A value of a sweep's grid as --set takes it. In a scenario a file name is relative to the scenario, in --set to the
/// working directory.
std::string value_argument(const std::string& toml, bool is_file, const std::string& scenario) {
  const std::string shown = shown_value(toml);
  if (is_file) return (std::filesystem::path(scenario).parent_path() / shown).lexically_normal().string();
  // A text keeps its quotes if it would be read as something else without them.
  const internal::Value bare = internal::parse_toml_value(shown, {});
  return shown == toml || (bare.is(internal::Value::Kind::text) && bare.text == shown) ? shown : toml;
}

}  // namespace

std::string shell_word(const std::string& word) {
  if (!word.empty() &&
      word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=:,") == std::string::npos)
    return word;
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::string shell_file(const std::string& file) { return shell_word(file.starts_with('-') ? "./" + file : file); }

std::string program_words(const char* called_as, const char* own_name) {
  for (const char* name : {called_as, own_name}) {
    if (name && *name) return shell_word(name);
  }
  return "evenstep";
}

std::string with_program(std::string_view message, const std::string& program) {
  constexpr std::string_view kCommand = "`evenstep ";
  std::string out;
  for (std::size_t at = 0; (at = message.find(kCommand)) != std::string_view::npos;) {
    out.append(message.substr(0, at)).append("`" + program + " ");
    message.remove_prefix(at + kCommand.size());
  }
  return out.append(message);
}

std::string point_command(const std::string& program, const SweepHeader& header, const SweepPoint& point,
                          const std::string& file) {
  std::string command = fmt::format("{} run {} --seed {}", program, shell_file(file), header.seed_of(point.index));
  for (const std::string& assignment : header.set) command += " --set " + shell_word(assignment);
  for (std::size_t axis = 0; axis < header.grid.size(); ++axis) {
    const SweepHeader::Axis& one = header.grid[axis];
    const std::string& value = one.values[header.value_of(point.index, axis)];
    command += " --set " + shell_word(one.path + "=" + value_argument(value, internal::names_file(one.path), file));
  }
  std::vector<std::string> off;
  for (const std::string& fault : header.swarm) {
    if (std::find(point.faults_on.begin(), point.faults_on.end(), fault) == point.faults_on.end())
      off.push_back('"' + fault + '"');
  }
  if (!off.empty()) command += " --set " + shell_word(fmt::format("run.faults_off=[{}]", fmt::join(off, ", ")));
  return command;
}

}  // namespace evenstep
