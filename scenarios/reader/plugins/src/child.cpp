#include "child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <system_error>

#include "child_start.h"
#include "evenstep/clock/wall_clock.h"
#include "excerpt.h"

namespace evenstep::internal {
namespace {

constexpr int kMostLinesShown = 100;
constexpr std::size_t kLongestLineShown = 400;
constexpr double kTimeToEnd_s = 1;  // for a process whose input was closed

struct Pipe {
  Descriptor read, write;
};
Pipe make_pipe() {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "a pipe");
  return {Descriptor(ends[0]), Descriptor(ends[1])};
}

void do_not_block(const Descriptor& descriptor) { fcntl(descriptor.number(), F_SETFL, O_NONBLOCK); }

/// Writes without SIGPIPE, whose handling belongs to the program that we are part of.
ssize_t write_quietly(int descriptor, std::string_view bytes) {
  sigset_t pipe_signal, before, pending;
  sigemptyset(&pipe_signal);
  sigaddset(&pipe_signal, SIGPIPE);
  sigpending(&pending);
  pthread_sigmask(SIG_BLOCK, &pipe_signal, &before);
  const ssize_t sent = write(descriptor, bytes.data(), bytes.size());
  const int why = errno;
  if (sent < 0 && why == EPIPE && sigismember(&pending, SIGPIPE) == 0) {
    const timespec at_once{};
    while (sigtimedwait(&pipe_signal, nullptr, &at_once) < 0 && errno == EINTR) {
    }
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  errno = why;
  return sent;
}

int milliseconds(double s) { return static_cast<int>(std::clamp(std::ceil(1e3 * s), 0.0, 1e6)); }

void wait_a_millisecond() { poll(nullptr, 0, 1); }

void end_at_once(pid_t process) {
  if (process <= 0) return;
  kill(process, SIGKILL);
  while (waitpid(process, nullptr, 0) < 0 && errno == EINTR) {
  }
}

}  // namespace

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  std::swap(number_, other.number_);
  return *this;
}

void Descriptor::close() {
  if (number_ >= 0) ::close(number_);
  number_ = -1;
}

Child::Child(const std::string& program, const std::vector<std::string>& words, const std::string& folder,
             std::string shown_as, Duration limit)
    : shown_as_(std::move(shown_as)), limit_(limit) {
  Pipe in = make_pipe(), out = make_pipe(), err = make_pipe(), life = make_pipe();
  watcher_ = start_watcher(life.read.number());
  if (watcher_ > 0)
    process_ = start_program(program, words, folder,
                             {in.read.number(), out.write.number(), err.write.number(), life.write.number()});
  if (process_ < 0) {
    const std::string why = std::generic_category().message(errno);
    end_at_once(watcher_);
    throw std::runtime_error(fmt::format("cannot be started in '{}': {}", folder, why));
  }
  in_ = std::move(in.write);
  out_ = std::move(out.read);
  err_ = std::move(err.read);
  life_ = std::move(life.write);
  for (const Descriptor* ours : {&in_, &out_, &err_}) do_not_block(*ours);
}

Child::~Child() {
  in_.close();
  if (!failed_) has_ended(kTimeToEnd_s);
  // The group has the number of its first process, which is given to nobody else until that process is waited for: so the
  // group is ended first, the watcher next, and the process last.
  kill(-process_, SIGKILL);
  end_at_once(watcher_);
  while (waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
  }
  try {
    read_errors();
    take_error_lines(true);
  } catch (...) {  // no memory or no log for the rest
  }
}

std::string Child::ask_line(std::string_view bytes, std::size_t most) {
  std::size_t end = std::string::npos;
  const Heard heard = hear(bytes, [&] {
    end = heard_.find('\n');
    return end != std::string::npos || heard_.size() >= most;
  });
  if (end == std::string::npos) {
    const std::string begin = heard_.empty() ? "" : fmt::format("; it has written '{}'", excerpt(heard_, 60));
    if (heard == Heard::enough)
      fail(fmt::format("the first line of its standard output is longer than {} bytes{}", most, begin));
    if (heard == Heard::closed) fail(fmt::format("{} before its first line was whole{}", how_it_ended(), begin));
    fail(fmt::format("did not answer the first line within {:g} s{}", seconds(limit_), begin));
  }
  std::string line = heard_.substr(0, end);
  heard_.erase(0, end + 1);
  return line;
}

std::string Child::ask(std::string_view bytes, std::size_t size) {
  read_some();
  if (!heard_.empty())
    fail(fmt::format("has written {} bytes that nobody asked for: '{}'", heard_.size(), excerpt(heard_, 40)));
  const Heard heard = hear(bytes, [&] { return heard_.size() >= size; });
  if (heard == Heard::closed)
    fail(fmt::format("{} after {} of the {} bytes of its answer", how_it_ended(), heard_.size(), size));
  if (heard == Heard::nothing)
    fail(fmt::format("has written {} of the {} bytes of its answer within {:g} s", heard_.size(), size, seconds(limit_)));
  std::string answer = heard_.substr(0, size);
  heard_.erase(0, size);
  return answer;
}

/// Sends and listens until it has heard enough, or the time is over.
template <class Enough>
Child::Heard Child::hear(std::string_view bytes, Enough enough) {
  const double end_s = monotonic_seconds() + seconds(limit_);
  while (!enough()) {
    const double left_s = end_s - monotonic_seconds();
    if (left_s <= 0) return Heard::nothing;
    std::array<pollfd, 3> streams{pollfd{out_.number(), POLLIN, 0}, pollfd{err_.number(), POLLIN, 0},
                                  pollfd{bytes.empty() ? -1 : in_.number(), POLLOUT, 0}};
    if (poll(streams.data(), streams.size(), milliseconds(left_s)) < 0 && errno != EINTR)
      throw std::system_error(errno, std::generic_category(), "poll");
    if (streams[1].revents != 0) read_errors();
    if (streams[2].revents != 0) send_some(bytes);
    if (streams[0].revents != 0 && !read_some()) return enough() ? Heard::enough : Heard::closed;
  }
  return Heard::enough;
}

void Child::send_some(std::string_view& bytes) {
  const ssize_t sent = write_quietly(in_.number(), bytes);
  if (sent >= 0) return bytes.remove_prefix(static_cast<std::size_t>(sent));
  if (errno == EPIPE) bytes = {};  // it reads no more; what it still writes says how far it came
}

/// False if it has closed its output.
bool Child::read_some() {
  std::array<char, 4096> buffer;
  const ssize_t got = read(out_.number(), buffer.data(), buffer.size());
  if (got > 0) heard_.append(buffer.data(), static_cast<std::size_t>(got));
  return got > 0 || (got < 0 && (errno == EAGAIN || errno == EINTR));
}

void Child::read_errors() {
  std::array<char, 4096> buffer;
  ssize_t got = 0;
  while (err_.number() >= 0 && (got = read(err_.number(), buffer.data(), buffer.size())) > 0) {
    error_text_.append(buffer.data(), static_cast<std::size_t>(got));
    take_error_lines(false);
  }
  if (got == 0) err_.close();
}

/// Logs what has come of its standard error, line by line; `all`: also what has no line end, as no more will come.
void Child::take_error_lines(bool all) {
  for (;;) {
    std::size_t end = error_text_.find('\n');
    if (end == std::string::npos && error_text_.size() <= kLongestLineShown && (!all || error_text_.empty())) return;
    end = std::min(end, error_text_.size());
    last_line_ = excerpt(std::string_view(error_text_).substr(0, end), kLongestLineShown);
    error_text_.erase(0, end + 1);
    if (lines_shown_ < kMostLinesShown) spdlog::warn("{}: {}", shown_as_, last_line_);
    if (lines_shown_ == kMostLinesShown) spdlog::warn("{}: (no more of its standard error is shown)", shown_as_);
    lines_shown_ = std::min(lines_shown_ + 1, kMostLinesShown + 1);
  }
}

/// Waits till it has ended, at most so long, and lets it write meanwhile.
bool Child::has_ended(double wait_s) {
  const double end_s = monotonic_seconds() + wait_s;
  for (;;) {
    siginfo_t ended{};
    if (waitid(P_PID, static_cast<id_t>(process_), &ended, WEXITED | WNOHANG | WNOWAIT) != 0) return errno != EINTR;
    if (ended.si_pid != 0) return true;
    if (monotonic_seconds() >= end_s) return false;
    read_errors();
    if (out_.number() >= 0 && !read_some()) out_.close();
    heard_.resize(std::min<std::size_t>(heard_.size(), 4096));
    wait_a_millisecond();
  }
}

std::string Child::how_it_ended() {
  const std::string heard = heard_;
  const bool ended = has_ended(kTimeToEnd_s);
  heard_ = heard;
  if (!ended) return "closed its standard output";
  siginfo_t how{};
  if (waitid(P_PID, static_cast<id_t>(process_), &how, WEXITED | WNOHANG | WNOWAIT) != 0) return "ended";
  return how.si_code == CLD_EXITED ? fmt::format("ended (exit status {})", how.si_status)
                                   : fmt::format("was ended by signal {} ({})", how.si_status, strsignal(how.si_status));
}

void Child::fail(const std::string& what) {
  failed_ = true;
  throw std::runtime_error(with_last_error(what));
}

std::string Child::with_last_error(const std::string& what) {
  read_errors();
  take_error_lines(true);
  return last_line_.empty() ? what : fmt::format("{}; its standard error ends with: {}", what, last_line_);
}

}  // namespace evenstep::internal
