#include "evenstep/apps/workflow_commands.h"

#include <fmt/format.h>

#include <filesystem>

#include "evenstep/reports/plain_text.h"

namespace evenstep {
namespace {

/// `text` with each character of `special` as %XX.
std::string escaped(std::string_view text, std::string_view special) {
  std::string out;
  for (const char c : text)
    out += special.find(c) == std::string_view::npos ? std::string(1, c)
                                                     : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  return out;
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
  std::error_code none;  // there is no absolute path of an empty one
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
