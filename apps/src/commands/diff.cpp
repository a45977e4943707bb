#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "evenstep/reports/writers.h"
#include "src/commands.h"

namespace evenstep::app {
namespace {

struct DiffArguments {
  std::string a, b;
};

std::optional<EventFile> events_of(const std::string& given) {
  namespace fs = std::filesystem;
  const fs::path path = fs::is_directory(given) ? fs::path(given) / "events.bin" : fs::path(given);
  std::ifstream in(path, std::ios::binary);
  if (!in) {
    spdlog::error("{}: error: cannot read it; expected a run folder or an events.bin", path.string());
    return std::nullopt;
  }
  const std::string content((std::istreambuf_iterator<char>(in)), {});
  std::vector<std::byte> bytes(content.size());
  std::transform(content.begin(), content.end(), bytes.begin(), [](char c) { return static_cast<std::byte>(c); });
  try {
    return read_events_bin(bytes);
  } catch (const std::runtime_error& error) {
    spdlog::error("{}: error: {}", path.string(), error.what());
    return std::nullopt;
  }
}

ExitCode diff(const DiffArguments& arguments, const std::atomic<bool>&) {
  const std::optional<EventFile> first = events_of(arguments.a), second = events_of(arguments.b);
  if (!first || !second) return ExitCode::usage;
  const std::optional<Difference> difference = first_difference(*first, *second);
  if (!difference) {
    fmt::print("the same events\n");
    return ExitCode::pass;
  }
  fmt::print("{}\n", difference->text);
  return ExitCode::expectation_failed;
}

}  // namespace

void add_diff(Commands& commands) {
  auto [command, arguments] = commands.add<DiffArguments>("diff", "the first differing event of two runs", diff);
  command.operand("a", arguments.a, "run folder or events.bin");
  command.operand("b", arguments.b, "run folder or events.bin");
}

}  // namespace evenstep::app
