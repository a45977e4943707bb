#pragma once
/// A device's own name goes to terminals and logs, so control characters become '?'.

#include <string>
#include <utility>

namespace evenstep::internal {

inline std::string printable(std::string text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const auto before = i > 0 ? static_cast<unsigned char>(text[i - 1]) : 0;
    if (byte < 0x20 || byte == 0x7F) text[i] = '?';
    if (before == 0xC2 && byte >= 0x80 && byte < 0xA0) text[i - 1] = text[i] = '?';  // the same in two bytes of UTF-8
  }
  return text;
}

}  // namespace evenstep::internal
