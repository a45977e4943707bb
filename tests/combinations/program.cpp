#include "program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "cases.h"
#include "evenstep/apps/command_line.h"

namespace evenstep::testing {
namespace {

int seconds_until_killed = 0;
constexpr int kThrew = 255;

/// In the child: the first alarm interrupts the program, the second one ends it.
void on_alarm(int) {
  std::signal(SIGALRM, SIG_DFL);
  alarm(static_cast<unsigned>(seconds_until_killed));
  kill(getpid(), SIGINT);
}

[[noreturn]] void be_program(std::vector<std::string> arguments, const std::string& folder, const Registry& registry,
                             const ProgramLimits& limits) {
  arguments.insert(arguments.begin(), "evenstep");
  std::vector<char*> words;
  for (std::string& argument : arguments) words.push_back(argument.data());
  words.push_back(nullptr);
  const int output = open((folder + "/output.txt").c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (output < 0 || dup2(output, STDOUT_FILENO) < 0 || dup2(output, STDERR_FILENO) < 0 || chdir(folder.c_str()) != 0)
    _exit(99);
  const rlimit no_core{0, 0}, memory{limits.most_bytes, limits.most_bytes};
  setrlimit(RLIMIT_CORE, &no_core);
  if (!kSanitized) setrlimit(RLIMIT_AS, &memory);
  seconds_until_killed = limits.end_after_s;
  for (const int signal : {SIGABRT, SIGSEGV, SIGFPE, SIGILL, SIGBUS}) std::signal(signal, SIG_DFL);  // not the test's own
  std::signal(SIGALRM, on_alarm);
  alarm(static_cast<unsigned>(limits.interrupt_after_s));
  const int code = command_line(static_cast<int>(words.size()) - 1, words.data(), registry);
  std::fflush(nullptr);
  _exit(code);
}

/// As waitpid gives it. The child must not return.
int status_of_child(const std::function<void()>& be_child) {
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("fork: " + std::string(std::strerror(errno)));
  if (child == 0) be_child();
  int status = 0;
  if (waitpid(child, &status, 0) != child) throw std::runtime_error("waitpid: " + std::string(std::strerror(errno)));
  return status;
}

}  // namespace

Ended run_program(const std::vector<std::string>& arguments, const std::string& folder, const Registry& registry,
                  const ProgramLimits& limits) {
  const int status = status_of_child([&] { be_program(arguments, folder, registry, limits); });
  std::ifstream file(folder + "/output.txt");
  std::ostringstream text;
  text << file.rdbuf();
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, WIFSIGNALED(status) ? WTERMSIG(status) : 0, text.str()};
}

std::optional<int> in_own_process(const std::function<int()>& work) {
  const int status = status_of_child([&] {
    alarm(60);
    try {
      _exit(work());
    } catch (const std::exception&) {
      _exit(kThrew);
    }
  });
  return WIFEXITED(status) && WEXITSTATUS(status) != kThrew ? std::optional(WEXITSTATUS(status)) : std::nullopt;
}

std::string Ended::text() const {
  const std::string end =
      signal ? fmt::format("signal {} ({})", signal, strsignal(signal)) : fmt::format("exit code {}", exit_code);
  return end + '\n' + output;
}

}  // namespace evenstep::testing
