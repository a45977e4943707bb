#include "command.h"

#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <limits>
#include <sstream>

#include "commands.h"
#include "evenstep/harness/version.h"
#include "evenstep/text/suggest.h"

namespace evenstep::app {
namespace {

CLI::Range between(Range range) { return CLI::Range(range.least, range.largest); }

/// What is wrong with a seed; empty if nothing is. The largest is that of a number in a file.
std::string seed_objection(const std::string& text) {
  std::int64_t seed = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  const bool all = error == std::errc() && end == text.data() + text.size();
  if (all && seed >= 0 && !text.starts_with('-')) return {};
  return "'" + text + "' is no seed; write a whole number from 0 to " +
         std::to_string(std::numeric_limits<std::int64_t>::max());
}

std::string named(const char* what, const std::string& typed, const std::vector<std::string>& known) {
  return what + (" '" + typed + "'") + internal::suggestion(typed, {known.begin(), known.end()});
}

/// For a call that was not understood: the first word, if it is no command, or the first option that the command does not
/// have, with the nearest known one. Empty for any other fault.
std::string mistyped(const CLI::App& program, const std::vector<std::string>& words) {
  std::vector<std::string> known;
  const CLI::App* command = nullptr;
  for (const CLI::App* one : program.get_subcommands(nullptr)) {
    known.push_back(one->get_name());
    if (!words.empty() && known.back() == words[0]) command = one;
  }
  if (words.empty() || words[0].empty() || (!command && words[0].starts_with('-'))) return {};
  if (!command) return named("unknown command", words[0], known);
  known.clear();
  for (const CLI::Option* option : command->get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  }
  for (const std::string& word : words) {
    const std::string name = word.substr(0, word.find('='));
    if (name.starts_with("--") && name != "--" && std::find(known.begin(), known.end(), name) == known.end())
      return named((words[0] + " has no option").c_str(), name, known);
  }
  return {};
}

/// Help, the version, or what is wrong with the call.
void print_answer(const CLI::App& program, const CLI::ParseError& error) {
  std::ostringstream out, err;
  program.exit(error, out, err);
  std::fputs(out.str().c_str(), stdout);
  std::fputs(err.str().c_str(), stderr);
}

/// "help" and "help COMMAND" are --help and COMMAND --help.
std::vector<std::string> words_of(int argc, char** argv) {
  std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  if (words.empty() || words[0] != "help") return words;
  words.erase(words.begin());
  words.emplace_back("--help");
  return words;
}

}  // namespace

// Operands are paths.
void Command::operand(const std::string& name, std::string& value, const std::string& meaning) {
  app_->add_option(name, value, meaning)->required()->transform(here_or_installed, "");
}

void Command::optional_operand(const std::string& name, std::string& value, const std::string& meaning) {
  app_->add_option(name, value, meaning);
}

void Command::operands(const std::string& name, std::vector<std::string>& values, const std::string& meaning) {
  app_->add_option(name, values, meaning)->required()->transform(here_or_installed, "");
}

void Command::optional_operands(const std::string& name, std::vector<std::string>& values, const std::string& meaning) {
  app_->add_option(name, values, meaning)->transform(here_or_installed, "");
}

void Command::flag(const std::string& name, bool& value, const std::string& meaning) {
  app_->add_flag(name, value, meaning);
}

void Command::option(const std::string& name, std::string& value, const std::string& meaning) {
  app_->add_option(name, value, meaning);
}

void Command::required_option(const std::string& name, std::string& value, const std::string& meaning) {
  app_->add_option(name, value, meaning)->required();
}

void Command::option(const std::string& name, std::string& value, const std::vector<std::string>& words,
                     const std::string& meaning) {
  app_->add_option(name, value, meaning)->check(CLI::IsMember(words));
}

void Command::option(const std::string& name, int& value, Range range, const std::string& meaning) {
  app_->add_option(name, value, meaning)->check(between(range));
}

void Command::option(const std::string& name, std::int64_t& value, Range range, const std::string& meaning) {
  app_->add_option(name, value, meaning)->check(between(range));
}

void Command::option(const std::string& name, std::optional<std::int64_t>& value, const std::string& meaning) {
  app_->add_option(name, value, meaning);
}

void Command::option(const std::string& name, std::optional<std::int64_t>& value, Range range, const std::string& meaning) {
  app_->add_option(name, value, meaning)->check(between(range));
}

void Command::option(const std::string& name, std::optional<std::uint64_t>& value, const std::string& meaning) {
  app_->add_option(name, value, meaning)->check(seed_objection, "");
}

void Command::repeated(const std::string& name, std::vector<std::string>& values, const std::string& meaning) {
  app_->add_option(name, values, meaning)->expected(1)->allow_extra_args(false)->take_all();
}

Commands::Commands(const std::atomic<bool>& interrupted, const Registry& registry, std::string program)
    : interrupted_(interrupted),
      registry_(registry),
      program_(std::move(program)),
      app_(std::make_unique<CLI::App>("Deterministic tests of haptic interaction under irregular simulation steps.")) {
  app_->name("evenstep");
  app_->set_version_flag("--version", std::string("evenstep ") + kVersion);
  app_->require_subcommand(1);
  app_->footer(kExitCodes);
}

Commands::~Commands() = default;

Command Commands::add_command(const std::string& name, const std::string& meaning, std::function<ExitCode()> run) {
  CLI::App* const command = app_->add_subcommand(name, meaning);
  command->callback([this, run = std::move(run)] { chosen_ = run; });
  return Command(*command);
}

void Commands::add_text(const std::string& name, const std::string& meaning,
                        std::string (*text)(const std::vector<CommandText>&)) {
  add_command(name, meaning, [this, text] {
    std::fputs(text(described()).c_str(), stdout);
    return ExitCode::pass;
  });
}

std::vector<CommandText> Commands::described() const {
  std::vector<CommandText> texts;
  for (const CLI::App* command : app_->get_subcommands(nullptr)) {
    CommandText& text = texts.emplace_back(CommandText{command->get_name(), command->get_description(), {}});
    for (const CLI::Option* option : command->get_options()) {
      text.arguments.push_back({option->nonpositional() ? option->get_name(false, true) : option->get_name(),
                                option->nonpositional(), option->get_items_expected_max() > 0, option->get_description()});
    }
  }
  return texts;
}

std::variant<std::function<ExitCode()>, ExitCode> Commands::parse(int argc, char** argv) {
  const std::vector<std::string> words = words_of(argc, argv);
  try {
    app_->parse(std::vector<std::string>(words.rbegin(), words.rend()));  // CLI11 takes them from the back
  } catch (const CLI::ParseError& error) {
    const bool asked_for_help = error.get_exit_code() == 0;
    const std::string mistake = asked_for_help ? "" : mistyped(*app_, words);
    if (mistake.empty())
      print_answer(*app_, error);
    else
      spdlog::error("evenstep: error: {}", mistake);
    return asked_for_help ? ExitCode::pass : ExitCode::usage;
  }
  return chosen_;
}

}  // namespace evenstep::app
