#include "evenstep/plugins/process_solver.h"

#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include "child.h"
#include "process_answer.h"

namespace evenstep {
namespace {

using namespace internal;

constexpr const char* kProtocolRemedy = "see docs/parts/process-protocol.md, and print to standard error only";

bool can_be_run(const std::string& path) {
  struct stat about {};
  return stat(path.c_str(), &about) == 0 && S_ISREG(about.st_mode) && access(path.c_str(), X_OK) == 0;
}

class ProcessSolver final : public ForeignSolver {
 public:
  ProcessSolver(const ProcessCommand& command, const std::string& program, const SolverRequest& request)
      : tools_(static_cast<std::size_t>(request.tool_count)),
        child_(program, command.words, command.folder, text_of(command), command.answer_limit) {
    const Result<SolverCapabilities, std::string> has = read_greeting(child_.ask_line(greeting(request), kLongestGreeting));
    if (!has) throw SolverError(SolverFault::unavailable, has.error(), kProtocolRemedy);
    has_ = *has;
  }
  ToolResponse step(std::span<const glm::dvec3> positions_m, double step_s) override {
    ask(RequestKind::step, n_, step_s, positions_m);
    ++n_;
    return last_.response;
  }
  SolverCapabilities capabilities() const override { return has_; }
  std::span<const ToolContact> contacts() const override { return last_.contacts; }
  std::uint64_t state_digest() override { return last_.state_digest; }
  double energy_J() override { return last_.energy_J; }
  void reset() override {
    n_ = 0;
    ask(RequestKind::reset, n_, 0, std::vector<glm::dvec3>(tools_));
  }

 private:
  void ask(RequestKind kind, std::uint64_t n, double step_s, std::span<const glm::dvec3> positions_m) {
    const std::string bytes = child_.ask(request_record(kind, n, step_s, positions_m), answer_size(tools_, has_.contacts));
    const Result<ProcessAnswer, std::string> answer = read_answer(bytes, tools_, has_.contacts, kind, n);
    if (!answer) throw SolverError(SolverFault::unavailable, answer.error(), kProtocolRemedy);
    if (answer->status != 0)
      throw SolverError(answer->status == 2   ? SolverFault::bad_input
                        : answer->status == 3 ? SolverFault::unstable_step
                                              : SolverFault::unavailable,
                        child_.with_last_error(fmt::format("answered with status {}", answer->status)),
                        "see what it wrote to its standard error");
    last_ = *answer;
  }

  std::size_t tools_;
  Child child_;
  SolverCapabilities has_;
  ProcessAnswer last_;
  std::uint64_t n_ = 0;
};

}  // namespace

std::string text_of(const ProcessCommand& command) { return fmt::format("{}", fmt::join(command.words, " ")); }

std::optional<std::string> program_of(const ProcessCommand& command) {
  namespace fs = std::filesystem;
  const std::string& first = command.words.front();
  if (first.find('/') != std::string::npos) {
    const std::string path = fs::absolute(fs::path(command.folder) / first).string();
    return can_be_run(path) ? std::optional(path) : std::nullopt;
  }
  const char* const folders = std::getenv("PATH");
  std::string_view left = folders == nullptr ? "" : folders;
  while (!left.empty() && !first.empty()) {
    const std::string_view folder = left.substr(0, left.find(':'));
    left.remove_prefix(std::min(left.size(), folder.size() + 1));
    const std::string path = (fs::path(folder) / first).string();
    if (folder.starts_with('/') && can_be_run(path)) return path;
  }
  return std::nullopt;
}

SolverFactory process_solver(const ProcessCommand& command) {
  return [command](const SolverRequest& request) -> std::unique_ptr<ForeignSolver> {
    const std::optional<std::string> program = program_of(command);
    if (!program)
      throw SolverError(SolverFault::unavailable,
                        fmt::format("there is no program '{}' that can be run", command.words.front()),
                        "install it, or write its path");
    return std::make_unique<ProcessSolver>(command, *program, request);
  };
}

}  // namespace evenstep
