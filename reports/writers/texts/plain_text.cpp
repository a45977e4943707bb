#include "evenstep/reports/plain_text.h"

#include <fmt/format.h>

#include "evenstep/reports/unicode.h"

namespace evenstep {
namespace {

/// The first `most` characters, with a backslash before each ASCII character of `special`.
std::string plain(std::string_view text, std::size_t most, std::string_view special) {
  std::string out;
  for (std::size_t count = 0; !text.empty(); ++count) {
    if (count == most) return out + "…";
    const char32_t c = take_code_point(text);
    if (c == '\n' || c == '\r' || c == '\t') {
      out += ' ';
    } else if (is_unseen(c)) {
      out += fmt::format("⟨U+{:04X}⟩", static_cast<unsigned>(c));
    } else {
      const bool begins_link = c == '.' && !special.empty() && (out.ends_with('w') || out.ends_with('W'));  // "www."
      if (begins_link || (c < 0x80 && special.find(static_cast<char>(c)) != std::string_view::npos)) out += '\\';
      append_utf8(out, c);
    }
  }
  return out;
}

}  // namespace

std::string plain_text(std::string_view text) { return plain(text, 200, ""); }

std::string markdown_text(std::string_view text, std::size_t most) { return plain(text, most, "\\`*_[]<>|#&~$@!:"); }

}  // namespace evenstep
