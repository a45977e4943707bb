#pragma once
/// Text that stays valid whatever a scenario file says: UTF-8 kept, broken UTF-8 replaced by U+FFFD.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "evenstep/time/time.h"

namespace evenstep::internal {

/// Takes the first code point off `text` (not empty). U+FFFD and one byte for anything that is not UTF-8.
char32_t take_code_point(std::string_view& text);
void append_utf8(std::string& out, char32_t c);

/// For text and attributes of XML 1.0: characters that it does not allow are left out, line breaks in attributes kept.
std::string xml_escape(std::string_view text);
/// A field of RFC 4180, quoted where it has to be.
std::string csv_field(const std::string& text);
/// Columns on a terminal: 0 for combining marks, 2 for East Asian wide characters and emoji.
std::size_t display_width(std::string_view text);

/// Exact decimal seconds of an instant: "1.234567890".
std::string exact_seconds(RealTime t);

}  // namespace evenstep::internal
