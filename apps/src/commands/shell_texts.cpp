#include <fmt/format.h>

#include <string>
#include <vector>

#include "src/commands.h"

namespace evenstep::app {
namespace {

std::string names_of(const std::vector<CommandText>& commands) {
  std::string names;
  for (const CommandText& command : commands) names += (names.empty() ? "" : " ") + command.name;
  return names;
}

/// Completes commands and options, and elsewhere the names of files.
std::string bash_completion(const std::vector<CommandText>& commands) {
  std::string cases;
  for (const CommandText& command : commands) {
    cases += fmt::format("    {}) words='", command.name);
    for (const CommandText::Argument& argument : command.arguments) {
      if (argument.is_option) cases += argument.names.substr(argument.names.find("--")) + ' ';
    }
    cases += "' ;;\n";
  }
  return fmt::format(R"(# source <(evenstep completion)
_evenstep() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} words=''
  COMPREPLY=()
  case ${{COMP_WORDS[1]}} in
{}  esac
  if ((COMP_CWORD == 1)); then words='{} help --help --version'; elif [[ $word != -* ]]; then return; fi
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
}}
complete -o default -F _evenstep evenstep
)",
                     cases, names_of(commands));
}

/// As roff wants it: a backslash is \e, a minus is not a hyphen, and no line begins with a command.
std::string roff(const std::string& text) {
  std::string escaped = text.starts_with('.') || text.starts_with('\'') ? "\\&" : "";
  for (const char c : text) escaped += c == '\\' ? "\\e" : c == '-' ? "\\-" : std::string(1, c);
  return escaped;
}

std::string manual(const std::vector<CommandText>& commands) {
  std::string text =
      ".TH EVENSTEP 1\n.SH NAME\nevenstep \\- deterministic tests of haptic interaction under irregular simulation steps\n"
      ".SH SYNOPSIS\n.B evenstep\n.I command\n[\n.I options\n]\n.I arguments\n.SH COMMANDS\n";
  for (const CommandText& command : commands) {
    text += fmt::format(".SS {}\n{}\n", roff(command.name), roff(command.meaning));
    for (const CommandText::Argument& argument : command.arguments) {
      text += fmt::format(".TP\n.B {}{}\n{}\n", roff(argument.names),
                          argument.takes_value && argument.is_option ? " VALUE" : "", roff(argument.meaning));
    }
  }
  return text + ".SH EXIT STATUS\n" + roff(kExitCodes) + "\n";
}

}  // namespace

void add_shell_texts(Commands& commands) {
  commands.add_text("completion", "print what completes commands and options in bash: source <(evenstep completion)",
                    bash_completion);
  commands.add_text("manual", "print the manual page: evenstep manual | man -l -", manual);
}

}  // namespace evenstep::app
