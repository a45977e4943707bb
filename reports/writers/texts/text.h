#pragma once
/// Text that stays valid whatever a scenario file contains: valid UTF-8 is kept, broken UTF-8 replaced by U+FFFD.

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>

#include "evenstep/reports/unicode.h"
#include "evenstep/time/time.h"

namespace evenstep::internal {

/// Text for XML 1.0, also in attributes: characters that XML does not allow become U+FFFD, line breaks in attributes
/// are kept.
std::string xml_escape(std::string_view text);
/// A CSV field as in RFC 4180, quoted if necessary.
std::string csv_field(const std::string& text);
/// The number of columns on a terminal: a combining mark takes 0, an East Asian wide character or an emoji 2.
std::size_t display_width(std::string_view text);

/// The words of a text in lines of at most so many columns, each after `indent` and with a line end. A wider word has a line
/// of its own.
std::string in_lines(std::string_view text, std::size_t columns, std::string_view indent = {});

/// Formats into a stream, a row at a time; a failing disk shows in the stream's state.
template <class... Values>
void print(std::ostream& out, fmt::format_string<Values...> text, Values&&... values) {
  fmt::basic_memory_buffer<char, 512> line;
  fmt::format_to(std::back_inserter(line), text, std::forward<Values>(values)...);
  out.write(line.data(), static_cast<std::streamsize>(line.size()));
}

/// Exact decimal seconds of an instant: "1.234567890".
std::string exact_seconds(RealTime t);

}  // namespace evenstep::internal
