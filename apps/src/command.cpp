#include "command.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <sstream>

#include "commands.h"
#include "evenstep/harness/version.h"
#include "evenstep/text/suggest.h"

namespace evenstep::app {
namespace {

constexpr std::int64_t kLargest = std::numeric_limits<std::int64_t>::max();

/// What is wrong with a number as it was typed; empty if nothing is.
std::string number_objection(const std::string& text, Range range, const char* what) {
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool all = error == std::errc() && end == text.data() + text.size() && text != "-0";
  if (all && number >= range.least && number <= range.largest) return {};
  return fmt::format("'{}' is {}; write a whole number from {} to {}", text, what, range.least, range.largest);
}

auto between(Range range) {
  return [range](const std::string& text) { return number_objection(text, range, "not possible"); };
}

std::string named(const char* what, const std::string& typed, const std::vector<std::string>& known) {
  return what + (" '" + typed + "'") + internal::suggestion(typed, {known.begin(), known.end()});
}

/// The first option of these words that the command does not have, with the nearest known one; empty if it has all.
std::string unknown_option(const std::string& whose, const CLI::App& command, const std::vector<std::string>& words) {
  std::vector<std::string> known;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  }
  for (const std::string& word : words) {
    const std::string name = word.substr(0, word.find('='));
    if (name.starts_with("--") && name != "--" && std::find(known.begin(), known.end(), name) == known.end())
      return named((whose + " has no option").c_str(), name, known);
  }
  return {};
}

const CLI::App* command_of(const CLI::App& program, const std::vector<std::string>& words) {
  for (const CLI::App* one : program.get_subcommands(nullptr)) {
    if (!words.empty() && one->get_name() == words[0]) return one;
  }
  return nullptr;
}

/// What was not said and must be, with what it is.
std::string missing_argument(const CLI::App& command) {
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_required() && option->count() == 0)
      return fmt::format("{} is missing: {}", option->get_name(), option->get_description());
  }
  return "something is missing";
}

/// What is wrong with a call that the parser did not understand, in one sentence, and what helps. Its own sentences speak of
/// what a user need not know.
std::string objection(const CLI::App& program, const CLI::ParseError& error, const std::vector<std::string>& words) {
  if (words.empty() || words[0].empty()) return "a command is missing";
  const CLI::App* const command = command_of(program, words);
  if (!command && words[0].starts_with('-')) return named("evenstep has no option", words[0], {"--help", "--version"});
  if (std::error_code ignored; !command && std::filesystem::exists(words[0], ignored)) {
    const bool plays = words[0].ends_with(".toml") || std::filesystem::is_directory(words[0], ignored);
    return fmt::format("'{}' is no command; did you mean {} {}", words[0], plays ? "run" : "size", words[0]);
  }
  if (!command) {
    std::vector<std::string> commands;
    for (const CLI::App* one : program.get_subcommands(nullptr)) commands.push_back(one->get_name());
    return named("unknown command", words[0], commands);
  }
  if (const std::string unknown = unknown_option(words[0], *command, words); !unknown.empty()) return unknown;

  const std::string what = error.what(), option = what.substr(0, what.find_first_of(": "));
  if (dynamic_cast<const CLI::RequiredError*>(&error)) return missing_argument(*command);
  if (dynamic_cast<const CLI::ExtrasError*>(&error)) {
    const std::vector<std::string> extra = command->remaining();
    const std::string first = extra.empty() ? "" : extra.front();
    if (first.starts_with('-')) return fmt::format("{} has no option '{}'", words[0], first);
    return fmt::format("{} does not take one more argument, '{}'", words[0], first);
  }
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ValidationError))
    return what;  // in our words: Command checks what it takes
  if (what.find("override") != std::string::npos) return "--" + option + " takes no value";
  // By its count, because the parser's versions word this differently.
  const CLI::Option* const given = command->get_option_no_throw(option);
  if (given && given->count() > 1) return option + " is given twice";
  return option + " needs a value";
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
  app_->add_flag(name, value, meaning)->disable_flag_override();
}

void Command::option(const std::string& name, std::string& value, const std::string& meaning) {
  app_->add_option(name, value, meaning);
}

void Command::required_option(const std::string& name, std::string& value, const std::string& meaning) {
  app_->add_option(name, value, meaning)->required();
}

void Command::option(const std::string& name, std::string& value, const std::vector<std::string>& words,
                     const std::string& meaning) {
  app_->add_option(name, value, meaning)
      ->check(
          [words](const std::string& text) {
            if (std::find(words.begin(), words.end(), text) != words.end()) return std::string();
            return "there is no '" + text + "'" + internal::suggestion(text, {words.begin(), words.end()});
          },
          "");
}

void Command::option(const std::string& name, int& value, Range range, const std::string& meaning) {
  app_->add_option(name, value, meaning)->check(between(range), "");
}

void Command::option(const std::string& name, std::int64_t& value, Range range, const std::string& meaning) {
  app_->add_option(name, value, meaning)->check(between(range), "");
}

void Command::option(const std::string& name, std::optional<std::int64_t>& value, const std::string& meaning) {
  option(name, value, {-kLargest, kLargest}, meaning);
}

void Command::option(const std::string& name, std::optional<std::int64_t>& value, Range range, const std::string& meaning) {
  app_->add_option(name, value, meaning)->check(between(range), "");
}

void Command::option(const std::string& name, std::optional<std::uint64_t>& value, const std::string& meaning) {
  app_->add_option(name, value, meaning)
      ->check(
          [](const std::string& text) {
            return number_objection(text, {0, kLargest}, "no seed");
          },
          "");
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
  CLI::App* const command = app_->add_subcommand(name, meaning)->group(group_);
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
    if (error.get_exit_code() == 0) {  // help or the version is asked for
      std::ostringstream text;
      app_->exit(error, text, text);
      std::fputs(text.str().c_str(), stdout);
      return ExitCode::pass;
    }
    spdlog::error("evenstep: error: {}; see {}{} --help", objection(*app_, error, words), program_,
                  command_of(*app_, words) ? " " + words[0] : "");
    return ExitCode::usage;
  }
  return chosen_;
}

}  // namespace evenstep::app
