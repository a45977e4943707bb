#include "evenstep/apps/origin.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <filesystem>
#include <optional>
#include <string_view>

#include "evenstep/text/text_file.h"

namespace evenstep {
namespace fs = std::filesystem;
namespace {

constexpr std::int64_t kLastSecond = 253'402'300'799;              // 9999-12-31T23:59:59Z
constexpr std::int64_t kMostPointerBytes = 4096;                   // HEAD, a branch, .git of a worktree: one line each
constexpr std::int64_t kMostPackedBytes = std::int64_t{64} << 20;  // half a million branches and tags
constexpr int kMostHops = 5;  // as git does: a ref that names a ref that names a ref ...

bool is_commit(std::string_view text) {
  const bool hex =
      std::all_of(text.begin(), text.end(), [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
  return hex && (text.size() == 40 || text.size() == 64);  // SHA-1, SHA-256
}

std::string without_line_end(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r' || text.back() == ' ')) text.pop_back();
  return text;
}

/// The content of a small file; empty if there is none.
std::string pointer(const fs::path& file) {
  return without_line_end(internal::read_text_file(file.string(), kMostPointerBytes).value_or(""));
}

/// The VALUE of a file of one line "<prefix>VALUE"; empty for any other line.
std::string after(std::string_view prefix, const std::string& line) {
  return line.starts_with(prefix) ? line.substr(prefix.size()) : std::string();
}

/// The folder that holds HEAD of the repository in which `folder` lies; empty if it lies in none.
fs::path git_folder_above(fs::path folder) {
  for (;; folder = folder.parent_path()) {
    std::error_code error;
    const fs::path git = folder / ".git";
    if (fs::is_directory(git, error)) return git;
    // In a worktree or a submodule, .git is a file that says where the folder is.
    if (const std::string elsewhere = after("gitdir: ", pointer(git)); !elsewhere.empty()) return folder / elsewhere;
    if (folder == folder.parent_path()) return {};
  }
}

/// A name as git allows it for a branch, so that it leads to no file outside of the repository.
bool is_ref(const std::string& name) {
  return name.starts_with("refs/") && name.find("..") == std::string::npos && name.find('\0') == std::string::npos;
}

std::string packed(const fs::path& common, const std::string& ref) {
  internal::TextPieces pieces((common / "packed-refs").string(), kMostPackedBytes);
  for (std::string_view piece = pieces.next(); !piece.empty(); piece = pieces.next()) {
    while (!piece.empty()) {
      const std::size_t end = std::min(piece.find('\n'), piece.size());
      const std::string_view line = piece.substr(0, end);
      piece.remove_prefix(std::min(end + 1, piece.size()));
      const std::size_t space = line.find(' ');
      if (space != std::string_view::npos && line.substr(space + 1) == ref) return std::string(line.substr(0, space));
    }
  }
  return {};
}

std::string head_commit(const fs::path& git) {
  // A worktree has a HEAD of its own, and shares the branches of the repository that it was made from.
  const std::string shared = pointer(git / "commondir");
  const fs::path common = shared.empty() ? git : git / shared;
  std::string content = pointer(git / "HEAD");
  for (int hop = 0; hop < kMostHops; ++hop) {
    if (is_commit(content)) return content;
    const std::string ref = after("ref: ", content);
    if (!is_ref(ref)) return {};
    content = pointer(git / ref);
    if (content.empty()) content = pointer(common / ref);
    if (content.empty()) content = packed(common, ref);
  }
  return {};
}

std::string variable(const Environment& environment, const char* name) {
  const char* const value = environment(name);
  return value ? value : "";
}

bool lies_in(const fs::path& file, const std::string& folder) {
  const fs::path inside = file.lexically_relative(fs::path(folder).lexically_normal());
  return !folder.empty() && !inside.empty() && *inside.begin() != "..";
}

}  // namespace

std::string utc_text(std::int64_t seconds_since_1970) {
  const std::chrono::seconds all{std::clamp<std::int64_t>(seconds_since_1970, 0, kLastSecond)};
  const auto whole = std::chrono::duration_cast<std::chrono::days>(all);
  const std::chrono::year_month_day date{std::chrono::sys_days(whole)};
  const std::chrono::hh_mm_ss time{all - whole};
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()), time.hours().count(),
                     time.minutes().count(), time.seconds().count());
}

Result<std::string> date_of_run(const Environment& environment, std::int64_t now) {
  const std::string given = variable(environment, "SOURCE_DATE_EPOCH");
  if (given.empty()) return utc_text(now);
  std::int64_t seconds = -1;
  const auto [end, error] = std::from_chars(given.data(), given.data() + given.size(), seconds);
  if (error != std::errc() || end != given.data() + given.size() || seconds < 0 || seconds > kLastSecond)
    return Failure(
        fmt::format("'{}' is no number of seconds since 1970; write a whole number such as 1700000000, or unset it", given));
  return utc_text(seconds);
}

std::string commit_of(const std::string& file, const Environment& environment) {
  std::error_code error;
  const fs::path absolute = fs::weakly_canonical(fs::absolute(file, error), error);
  if (error) return {};
  if (const fs::path git = git_folder_above(absolute.parent_path()); !git.empty()) return head_commit(git);
  struct Service {
    const char *workspace, *commit;
  };
  for (const Service& service : {Service{"GITHUB_WORKSPACE", "GITHUB_SHA"}, Service{"CI_PROJECT_DIR", "CI_COMMIT_SHA"}}) {
    const std::string commit = variable(environment, service.commit);
    if (lies_in(absolute, variable(environment, service.workspace)) && is_commit(commit)) return commit;
  }
  return {};
}

}  // namespace evenstep
