#include "output.h"

#include <fcntl.h>
#include <poll.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <mutex>

#include "evenstep/apps/shell.h"

namespace evenstep::app {
namespace {

constexpr std::size_t kLargestJobSummary = 1024 * 1024;  // of one step; the runner refuses a larger one whole

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value ? value : "";
}

/// Messages with the program as it was started.
class MessageText : public spdlog::formatter {
 public:
  explicit MessageText(std::string program) : program_(std::move(program)) {}
  void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& out) override {
    const std::string text = with_program({message.payload.data(), message.payload.size()}, program_) + '\n';
    out.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<spdlog::formatter> clone() const override { return std::make_unique<MessageText>(program_); }

 private:
  std::string program_;
};

/// Whether all of it could be written; if not, errno says why.
bool write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

/// Errors and warnings as annotations, everything else as it is.
class AnnotatingSink : public spdlog::sinks::base_sink<std::mutex> {
  void sink_it_(const spdlog::details::log_msg& message) override {
    spdlog::memory_buf_t text;
    formatter_->format(message, text);
    std::string_view line(text.data(), text.size());
    if (message.level < spdlog::level::warn) {
      std::fwrite(line.data(), 1, line.size(), stderr);
      return;
    }
    line.remove_suffix(1);
    annotate(message.level == spdlog::level::warn ? AnnotationLevel::warning : AnnotationLevel::error, {}, "evenstep",
             std::string(line));
  }
  void flush_() override {}
};

/// A stream to the descriptor in which its reader (the runner, or a terminal) takes nothing for a command.
struct GuardedStream {
  int descriptor;
  std::function<std::string(std::string_view)> pass;
};
ssize_t write_guarded(void* cookie, const char* bytes, std::size_t count) {
  auto* const stream = static_cast<GuardedStream*>(cookie);
  return write_all(stream->descriptor, stream->pass({bytes, count})) ? static_cast<ssize_t>(count) : 0;
}

/// No runner reads a file, so what is written there stays as it is.
template <class Guard>
void guard(std::FILE*& stream, int descriptor, int buffering, Guard guard) {
  struct stat what {};
  if (::fstat(descriptor, &what) == 0 && S_ISREG(what.st_mode)) return;
  static GuardedStream streams[3];  // lives as long as the C library's streams
  streams[descriptor] = {descriptor, [guard](std::string_view text) mutable { return guard.pass(text); }};
  if (std::FILE* const guarded = ::fopencookie(&streams[descriptor], "w", {nullptr, write_guarded, nullptr, nullptr})) {
    std::setvbuf(guarded, nullptr, buffering, BUFSIZ);
    stream = guarded;
  }
}

/// Whether stdout is a pipe or a socket that nobody reads any more.
bool reader_is_gone() {
  pollfd out{STDOUT_FILENO, POLLOUT, 0};
  return ::poll(&out, 1, 0) == 1 && (out.revents & (POLLERR | POLLHUP)) != 0;
}

/// Keeps the numbers of stdout and stderr from files that are opened later: what is printed would be written into these.
void occupy_closed_streams() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (::fcntl(descriptor, F_GETFD) < 0) ::open("/dev/null", descriptor == STDERR_FILENO ? O_WRONLY : O_RDONLY);
}

}  // namespace

bool on_github() { return variable("GITHUB_ACTIONS") == "true"; }

void prepare_output(const std::string& program) {
  occupy_closed_streams();
  spdlog::sink_ptr sink;
  if (on_github()) {
    guard(stdout, STDOUT_FILENO, _IOFBF, CommandGuard{});
    guard(stderr, STDERR_FILENO, _IOLBF, CommandGuard{});
    sink = std::make_shared<AnnotatingSink>();
  } else {
    if (::isatty(STDOUT_FILENO)) guard(stdout, STDOUT_FILENO, _IOLBF, TerminalGuard{});
    if (::isatty(STDERR_FILENO)) guard(stderr, STDERR_FILENO, _IONBF, TerminalGuard{});
    sink = std::make_shared<spdlog::sinks::stderr_sink_mt>();
  }
  spdlog::set_default_logger(std::make_shared<spdlog::logger>("evenstep", std::move(sink)));
  spdlog::set_formatter(std::make_unique<MessageText>(program));
}

ExitCode finish_output(ExitCode code, bool may_stop) {
  std::fflush(stdout);
  if (!std::ferror(stdout)) return code;
  const bool gone = reader_is_gone();
  if (gone && may_stop) return ExitCode::pass;
  spdlog::error("evenstep: error: stdout has not taken all that was printed: {}",
                gone ? "nobody reads it any more" : "it is closed, or its disk is full");
  return worse(code, ExitCode::run_failed);
}

void annotate(AnnotationLevel level, const Place& place, const std::string& title, const std::string& message) {
  if (!on_github()) return;
  std::fflush(stderr);
  const Place shown{file_in_repository(place.file, variable("GITHUB_WORKSPACE")), place.line, place.column};
  write_all(STDERR_FILENO, annotation(level, shown, title, message));
}

void add_to_job_summary(const std::vector<SummaryRow>& rows, const std::string& below) {
  const std::string file = variable("GITHUB_STEP_SUMMARY");
  if (!on_github() || file.empty()) return;
  std::error_code none_yet;
  const std::uintmax_t there = std::filesystem::file_size(file, none_yet);
  const std::size_t used = none_yet ? 0 : static_cast<std::size_t>(std::min<std::uintmax_t>(there, kLargestJobSummary));
  std::ofstream out(file, std::ios::app | std::ios::binary);
  out << summary_markdown(rows, below, kLargestJobSummary - used) << std::flush;
  if (!out) spdlog::warn("{}: the job's summary cannot be written", file);
}

}  // namespace evenstep::app
