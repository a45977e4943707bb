#pragma once
/// A command's operands and options, as each command's file declares them. CLI11 does the work, in command.cpp alone: a
/// source that includes it takes ten seconds longer to compile.

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "evenstep/harness/run.h"

namespace CLI {
class App;
}

namespace evenstep::app {

inline constexpr const char* kExitCodes =
    "Exit: 0 pass, 1 expectation failed or no verdict, 2 usage or scenario error, 3 run failed or output cut, 4 not "
    "reproducible, 130 interrupted.";

/// The numbers an option accepts, both ends included.
struct Range {
  std::int64_t least, largest;
};

/// One subcommand. `name` of an operand is what --help calls it, that of an option begins with "--"; `meaning` is one line
/// of --help. A value keeps what it was initialized with if it is not given. The parser refuses an option that is given
/// twice.
class Command {
 public:
  explicit Command(CLI::App& app) : app_(&app) {}

  void operand(const std::string& name, std::string& value, const std::string& meaning);  ///< must be given
  void optional_operand(const std::string& name, std::string& value, const std::string& meaning);
  void operands(const std::string& name, std::vector<std::string>& values, const std::string& meaning);  ///< at least one
  void optional_operands(const std::string& name, std::vector<std::string>& values, const std::string& meaning);
  void flag(const std::string& name, bool& value, const std::string& meaning);
  void option(const std::string& name, std::string& value, const std::string& meaning);
  void required_option(const std::string& name, std::string& value, const std::string& meaning);
  /// One of `words`.
  void option(const std::string& name, std::string& value, const std::vector<std::string>& words,
              const std::string& meaning);
  void option(const std::string& name, int& value, Range range, const std::string& meaning);
  void option(const std::string& name, std::int64_t& value, Range range, const std::string& meaning);
  void option(const std::string& name, std::optional<std::int64_t>& value, const std::string& meaning);
  void option(const std::string& name, std::optional<std::int64_t>& value, Range range, const std::string& meaning);
  void option(const std::string& name, std::optional<std::uint64_t>& value, const std::string& meaning);  ///< a seed
  /// Any number of times, each with one value.
  void repeated(const std::string& name, std::vector<std::string>& values, const std::string& meaning);

 private:
  CLI::App* app_;
};

/// What a command accepts, in words: for the manual page and the shell's completion.
struct CommandText {
  struct Argument {
    std::string names;  ///< "--out", "--help, -h", or an operand's name
    bool is_option = false;
    bool takes_value = false;  ///< of an option
    std::string meaning;
  };
  std::string name, meaning;
  std::vector<Argument> arguments;
};

/// All commands of the program, and one call of it.
class Commands {
 public:
  /// What is handed to the command that runs: `interrupted`, which a signal sets; what scenarios may name; and how this
  /// program was started, for commands that the user is to paste into a shell.
  Commands(const std::atomic<bool>& interrupted, const Registry& registry, std::string program);
  ~Commands();

  /// Adds a command and returns it with its arguments, which the caller has to declare as operands and options.
  /// run(arguments, interrupted) runs it.
  template <class Arguments>
  std::pair<Command, Arguments&> add(const std::string& name, const std::string& meaning,
                                     ExitCode (*run)(const Arguments&, const std::atomic<bool>&)) {
    auto arguments = std::make_shared<Arguments>();
    return {add_command(name, meaning, [this, arguments, run] { return run(*arguments, interrupted_); }), *arguments};
  }
  /// Adds a command that reads scenarios.
  template <class Arguments>
  std::pair<Command, Arguments&> add(const std::string& name, const std::string& meaning,
                                     ExitCode (*run)(const Arguments&, const std::atomic<bool>&, const Registry&)) {
    auto arguments = std::make_shared<Arguments>();
    return {add_command(name, meaning, [this, arguments, run] { return run(*arguments, interrupted_, registry_); }),
            *arguments};
  }

  /// What --help writes above the commands that are added from now on.
  void begin_group(std::string name) { group_ = std::move(name); }
  /// Adds a command without arguments that prints a text made from all commands.
  void add_text(const std::string& name, const std::string& meaning, std::string (*text)(const std::vector<CommandText>&));

  /// The first word of a command that a person can type to start this program again.
  const std::string& program() const { return program_; }

  /// What the arguments ask for: a command to run, or the exit code after help, the version or a usage error was printed.
  std::variant<std::function<ExitCode()>, ExitCode> parse(int argc, char** argv);

 private:
  std::vector<CommandText> described() const;
  Command add_command(const std::string& name, const std::string& meaning, std::function<ExitCode()> run);

  const std::atomic<bool>& interrupted_;
  const Registry& registry_;
  std::string program_, group_;
  std::unique_ptr<CLI::App> app_;
  std::function<ExitCode()> chosen_;
};

}  // namespace evenstep::app
