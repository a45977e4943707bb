#include "command.h"

#include <CLI/CLI.hpp>

#include "evenstep/harness/version.h"

namespace evenstep::app {
namespace {

CLI::Range between(Range range) { return CLI::Range(range.least, range.largest); }

}  // namespace

void Command::operand(const std::string& name, std::string& value, const std::string& meaning) {
  required_option(name, value, meaning);
}

void Command::operands(const std::string& name, std::vector<std::string>& values, const std::string& meaning) {
  app_->add_option(name, values, meaning)->required();
}

void Command::optional_operands(const std::string& name, std::vector<std::string>& values, const std::string& meaning) {
  app_->add_option(name, values, meaning);
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
  app_->add_option(name, value, meaning);
}

void Command::repeated(const std::string& name, std::vector<std::string>& values, const std::string& meaning) {
  app_->add_option(name, values, meaning)->expected(1)->allow_extra_args(false)->take_all();
}

Commands::Commands(const std::atomic<bool>& interrupted)
    : interrupted_(interrupted),
      app_(std::make_unique<CLI::App>("Deterministic tests of haptic interaction under irregular simulation steps.")) {
  app_->name("evenstep");
  app_->set_version_flag("--version", std::string("evenstep ") + kVersion);
  app_->require_subcommand(1);
  app_->footer(
      "Exit: 0 pass, 1 expectation failed, 2 usage or scenario error, 3 run failed, 4 not reproducible, 130 interrupted.");
}

Commands::~Commands() = default;

Command Commands::add_command(const std::string& name, const std::string& meaning, std::function<ExitCode()> run) {
  CLI::App* const command = app_->add_subcommand(name, meaning);
  command->callback([this, run = std::move(run)] { chosen_ = run; });
  return Command(*command);
}

std::variant<std::function<ExitCode()>, ExitCode> Commands::parse(int argc, char** argv) {
  try {
    app_->parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const bool asked_for_help = error.get_exit_code() == 0;
    app_->exit(error);
    return asked_for_help ? ExitCode::pass : ExitCode::usage;
  }
  return chosen_;
}

}  // namespace evenstep::app
