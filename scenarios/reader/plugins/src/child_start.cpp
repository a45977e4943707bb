#include "child_start.h"

#include <fcntl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>

namespace evenstep::internal {
namespace {

/// As a program expects it: no signal is blocked, and those that this program handles or ignores end it.
void take_default_signals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGCHLD}) std::signal(signal, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
}

void close_from(int first) {
#ifdef SYS_close_range
  if (syscall(SYS_close_range, static_cast<unsigned>(first), ~0U, 0U) == 0) return;
#endif
  const long most = sysconf(_SC_OPEN_MAX);
  for (int number = first; number < (most < 0 || most > 65536 ? 65536 : static_cast<int>(most)); ++number) close(number);
}

[[noreturn]] void watch(int life) {
  setpgid(0, 0);  // a Ctrl-C at the terminal must not end it before us
  take_default_signals();
  // The watcher must hold nothing open, least of all the input of another process, which would then never end.
  dup2(life, 0);
  close_from(1);
  pid_t group = 0, told = 0;
  for (;;) {
    const ssize_t got = read(0, &told, sizeof told);
    if (got == static_cast<ssize_t>(sizeof told)) group = told;
    if (got == 0 || (got < 0 && errno != EINTR)) break;
  }
  if (group > 1) kill(-group, SIGKILL);
  _exit(0);
}

[[noreturn]] void become(const char* program, char* const* words, const char* folder, const ChildEnds& ends, int failure) {
  setpgid(0, 0);
  take_default_signals();
  const pid_t self = getpid();
  bool ok = write(ends.life, &self, sizeof self) == static_cast<ssize_t>(sizeof self);
  // Numbers above 2 first: an end may itself be one of 0 to 2.
  const int in = fcntl(ends.in, F_DUPFD_CLOEXEC, 3), out = fcntl(ends.out, F_DUPFD_CLOEXEC, 3),
            err = fcntl(ends.err, F_DUPFD_CLOEXEC, 3);
  ok = ok && dup2(in, 0) == 0 && dup2(out, 1) == 1 && dup2(err, 2) == 2 && chdir(folder) == 0;
  if (ok) execve(program, words, environ);
  const int why = errno;
  while (write(failure, &why, sizeof why) < 0 && errno == EINTR) {
  }
  _exit(127);
}

}  // namespace

pid_t start_watcher(int life) {
  const pid_t watcher = fork();
  if (watcher == 0) watch(life);
  return watcher;
}

pid_t start_program(const std::string& program, const std::vector<std::string>& words, const std::string& folder,
                    const ChildEnds& ends) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  int failure[2];
  if (pipe2(failure, O_CLOEXEC) != 0) return -1;
  if (failure[1] <= 2) {  // dup2 in the new process would overwrite it
    const int above = fcntl(failure[1], F_DUPFD_CLOEXEC, 3);
    close(failure[1]);
    failure[1] = above;
  }
  const pid_t process = fork();
  if (process == 0) become(program.c_str(), arguments.data(), folder.c_str(), ends, failure[1]);
  const int fork_errno = errno;
  close(failure[1]);
  int why = fork_errno;
  ssize_t got = 0;
  while (process > 0 && (got = read(failure[0], &why, sizeof why)) < 0 && errno == EINTR) {
  }
  close(failure[0]);
  if (process > 0 && got <= 0) return process;  // exec has closed the pipe
  if (process > 0) waitpid(process, nullptr, 0);
  errno = why;
  return -1;
}

}  // namespace evenstep::internal
