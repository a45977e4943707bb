#pragma once
/// What all our JSON has in common, on top of nlohmann/json: members stay in the order in which they were added, numbers are
/// the shortest text that reads back to the same double, and no name or message can break the file, whatever it contains.

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "evenstep/reports/pause_parts.h"

namespace evenstep {

using Json = nlohmann::ordered_json;

/// A number; null for NaN and infinities, for which JSON has none; a whole number is written without ".0".
inline Json json_number(double value) {
  if (!std::isfinite(value)) return nullptr;
  constexpr double kMostDigits = 1e16;  // above it the shortest text has an exponent
  if (value == std::floor(value) && std::abs(value) < kMostDigits && !(value == 0 && std::signbit(value)))
    return static_cast<std::int64_t>(value);
  return value;
}
inline Json json_number(const std::optional<double>& value) { return value ? json_number(*value) : Json(nullptr); }

inline Json json_of(const PauseParts& pause) {
  return {{"length_ns", pause.length.ns},
          {"drawing_ns", pause.drawing.ns},
          {"waiting_ns", pause.waiting.ns},
          {"unrecorded_ns", pause.unrecorded.ns}};
}

/// The text on one line. Bytes that are not UTF-8 (in a message of a driver or a solver) are replaced by U+FFFD.
inline std::string json_text(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

/// The same with each element of the array `rows` on a line of its own, so that a comparison of texts shows which one
/// changed.
inline std::string json_text(const Json& object, std::string_view rows) {
  std::string out;
  for (const auto& [key, value] : object.items()) {
    out += (out.empty() ? "{" : ",") + json_text(key) + ':';
    if (key != rows) {
      out += json_text(value);
      continue;
    }
    out += '[';
    for (const Json& row : value) out += (out.back() == '[' ? "\n" : ",\n") + json_text(row);
    out += ']';
  }
  return out + '}';
}

}  // namespace evenstep
