#pragma once
/// Text from elsewhere, made fit for a terminal and a report.

#include <string>
#include <string_view>

namespace evenstep::internal {

/// At most `most` bytes of a text: control characters, and bytes that are not UTF-8, become '?'; "..." where it was cut.
std::string excerpt(std::string_view text, std::size_t most);

}  // namespace evenstep::internal
