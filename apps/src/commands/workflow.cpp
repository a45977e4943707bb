#include "evenstep/apps/workflow_commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "evenstep/reports/plain_text.h"

namespace evenstep {
namespace {

/// `text` with each character of `special` as %XX, and other control characters, which a log would obey, as "?".
std::string escaped(std::string_view text, std::string_view special) {
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (special.find(c) != std::string_view::npos)
      out += fmt::format("%{:02X}", byte);
    else
      out += (byte < 0x20 && c != '\t') || byte == 0x7F ? '?' : c;
  }
  return out;
}

constexpr std::array<std::string_view, 8> kOwnSequences{"\r\033[K", "\033[0m",  "\033[31m", "\033[32m",
                                                        "\033[33m", "\033[35m", "\033[90m", "\r\n"};

/// How many bytes of `text` belong together from its first byte on: a sequence of our own or a character. 0 if that depends
/// on bytes that have not come yet.
std::size_t unit_length(std::string_view text) {
  for (const std::string_view own : kOwnSequences) {
    if (text.starts_with(own)) return own.size();
    if (text.size() < own.size() && own.starts_with(text)) return 0;
  }
  const auto lead = static_cast<unsigned char>(text.front());
  const std::size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : lead >= 0xC2 ? 2 : 1;
  for (std::size_t i = 1; i < std::min(length, text.size()); ++i) {
    if ((static_cast<unsigned char>(text[i]) & 0xC0) != 0x80) return 1;
  }
  return length <= text.size() ? length : 0;
}

/// Whether a character may go to a terminal.
bool shows(std::string_view unit) {
  const auto lead = static_cast<unsigned char>(unit.front());
  if (unit.size() == 1) return (lead >= 0x20 && lead < 0x7F) || lead == '\n' || lead == '\t';
  if (lead == 0xC2 && static_cast<unsigned char>(unit[1]) < 0xA0) return false;  // U+0080 to U+009F
  const auto in = [&](const char* first, const char* last) { return unit.size() == 3 && unit >= first && unit <= last; };
  return unit != "\u061C" && !in("\u200E", "\u200F") && !in("\u202A", "\u202E") && !in("\u2066", "\u2069");
}

/// Messages are long, and few.
std::string cell(std::string_view text) { return markdown_text(text, 4000); }

}  // namespace

std::string annotation(AnnotationLevel level, const Place& place, std::string_view title, std::string_view message) {
  constexpr std::string_view kInData = "%\r\n", kInProperty = "%\r\n:,";
  std::string properties;
  if (!place.file.empty()) properties += fmt::format("file={},", escaped(place.file, kInProperty));
  if (!place.file.empty() && place.line > 0) properties += fmt::format("line={},", place.line);
  if (!place.file.empty() && place.line > 0 && place.column > 0) properties += fmt::format("col={},", place.column);
  return fmt::format("::{} {}title={}::{}\n", level == AnnotationLevel::error ? "error" : "warning", properties,
                     escaped(title, kInProperty), escaped(message, kInData));
}

std::string file_in_repository(const std::string& file, const std::string& workspace) {
  namespace fs = std::filesystem;
  std::error_code none;  // an empty path has no absolute one
  const fs::path absolute = fs::absolute(file, none).lexically_normal();
  const fs::path inside = none || workspace.empty() ? fs::path() : absolute.lexically_relative(workspace);
  return inside.empty() || *inside.begin() == ".." ? file : inside.string();
}

std::string CommandGuard::pass(std::string_view piece) {
  std::string out;
  for (const char c : piece) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '\n' || c == '\r') {
      start_ = Start::blank;
      last_visible_ = 0;
    } else if (c == ' ' || (c >= '\t' && c <= '\f')) {
      if (start_ == Start::colon) start_ = Start::text;
      last_visible_ = c;
    } else if (byte > ' ' && byte < 0x7F) {  // the runner may skip anything else
      if ((start_ == Start::colon && c == ':') || (last_visible_ == '#' && c == '[')) out += '_';
      start_ = start_ == Start::blank && c == ':' ? Start::colon : Start::text;
      last_visible_ = c;
    }
    out += c;
  }
  return out;
}

std::string TerminalGuard::pass(std::string_view piece) {
  held_ += piece;
  std::string out;
  std::string_view rest = held_;
  while (!rest.empty()) {
    const std::size_t length = unit_length(rest);
    if (length == 0) break;
    const std::string_view unit = rest.substr(0, length);
    const bool own = std::find(kOwnSequences.begin(), kOwnSequences.end(), unit) != kOwnSequences.end();
    out += own || shows(unit) ? unit : "?";
    rest.remove_prefix(length);
  }
  held_ = std::string(rest);
  return out;
}

std::string summary_markdown(const std::vector<SummaryRow>& rows, std::string_view below, std::size_t most_bytes) {
  std::string text = "### evenstep\n\n| scenario | verdict | |\n|---|---|---|\n";
  const std::string end = fmt::format("\n{}\n", cell(below));
  std::size_t written = 0;
  for (const SummaryRow& row : rows) {
    const std::string line = fmt::format("| {} | {} | {} |\n", cell(row.scenario), cell(row.verdict), cell(row.note));
    const std::string rest = fmt::format("| and {} more | | |\n", rows.size() - written);
    if (text.size() + line.size() + rest.size() + end.size() > most_bytes) {
      text += rest;
      break;
    }
    text += line;
    ++written;
  }
  text += end;
  return text.size() <= most_bytes ? text : "";
}

}  // namespace evenstep
