#include "evenstep/reports/plain_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "src/text.h"

namespace evenstep {
namespace {

struct Points {
  char32_t first, last;
};
/// Characters that are not seen, or that change how others are: controls, soft hyphen, marks of direction, joiners,
/// invisible operators, separators of lines, fillers, annotations, tags, selectors of variants but for emoji's.
constexpr std::array kUnseen =
    std::to_array<Points>({{0x00, 0x1F},     {0x7F, 0x9F},     {0xAD, 0xAD},       {0x34F, 0x34F},     {0x61C, 0x61C},
                           {0x115F, 0x1160}, {0x17B4, 0x17B5}, {0x180B, 0x180F},   {0x200B, 0x200F},   {0x2028, 0x202E},
                           {0x2060, 0x206F}, {0x3164, 0x3164}, {0xFE00, 0xFE0E},   {0xFEFF, 0xFEFF},   {0xFFA0, 0xFFA0},
                           {0xFFF0, 0xFFFB}, {0xFFFE, 0xFFFF}, {0x1BCA0, 0x1BCA3}, {0x1D173, 0x1D17A}, {0xE0000, 0xE0FFF}});

bool is_unseen(char32_t c) {
  return std::any_of(kUnseen.begin(), kUnseen.end(), [c](Points p) { return c >= p.first && c <= p.last; });
}

/// The first `most` characters, with a backslash before each ASCII character of `special`.
std::string plain(std::string_view text, std::size_t most, std::string_view special) {
  std::string out;
  for (std::size_t count = 0; !text.empty(); ++count) {
    if (count == most) return out + "…";
    const char32_t c = internal::take_code_point(text);
    if (c == '\n' || c == '\r' || c == '\t') {
      out += ' ';
    } else if (is_unseen(c)) {
      out += fmt::format("⟨U+{:04X}⟩", static_cast<unsigned>(c));
    } else {
      const bool begins_link = c == '.' && !special.empty() && (out.ends_with('w') || out.ends_with('W'));  // "www."
      if (begins_link || (c < 0x80 && special.find(static_cast<char>(c)) != std::string_view::npos)) out += '\\';
      internal::append_utf8(out, c);
    }
  }
  return out;
}

}  // namespace

std::string plain_text(std::string_view text) { return plain(text, 200, ""); }

std::string markdown_text(std::string_view text) { return plain(text, 400, "\\`*_[]<>|#&~$@!:"); }

}  // namespace evenstep
