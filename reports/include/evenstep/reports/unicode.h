#pragma once
/// UTF-8, read and written by code points. What is read need not be valid.

#include <string>
#include <string_view>

namespace evenstep {

/// Takes the first code point off `text`, which must not be empty. For anything that is not UTF-8 it takes one byte and
/// gives U+FFFD.
char32_t take_code_point(std::string_view& text);
void append_utf8(std::string& out, char32_t c);

/// Whether the character is invisible or changes how others are shown: controls, soft hyphen, marks of direction, joiners,
/// invisible operators, separators of lines, fillers, annotations, tags, variation selectors except those of emoji.
bool is_unseen(char32_t c);

}  // namespace evenstep
