#pragma once
/// Text that stays valid whatever a scenario file contains: valid UTF-8 is kept, broken UTF-8 replaced by U+FFFD.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "evenstep/reports/unicode.h"
#include "evenstep/time/time.h"

namespace evenstep::internal {

/// Text for XML 1.0, also in attributes: characters that XML does not allow are left out, line breaks in attributes are
/// kept.
std::string xml_escape(std::string_view text);
/// A CSV field as in RFC 4180, quoted if necessary.
std::string csv_field(const std::string& text);
/// The number of columns on a terminal: a combining mark takes 0, an East Asian wide character or an emoji 2.
std::size_t display_width(std::string_view text);

/// Exact decimal seconds of an instant: "1.234567890".
std::string exact_seconds(RealTime t);

}  // namespace evenstep::internal
