#pragma once
/// What all our JSON has in common, on top of nlohmann/json: members stay in the order in which they were put in, numbers are
/// the shortest text that reads back to the same double, and nothing that a name or a message holds can break the file.

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace evenstep {

using Json = nlohmann::ordered_json;

/// null where JSON has no number for it (NaN, infinite); a whole number without ".0".
inline Json json_number(double value) {
  if (!std::isfinite(value)) return nullptr;
  constexpr double kMostDigits = 1e16;  // above it the shortest text has an exponent
  if (value == std::floor(value) && std::abs(value) < kMostDigits && !(value == 0 && std::signbit(value)))
    return static_cast<std::int64_t>(value);
  return value;
}
inline Json json_number(const std::optional<double>& value) { return value ? json_number(*value) : Json(nullptr); }

/// On one line. Text that is not UTF-8 (the message of a driver or a solver) has U+FFFD where it is broken.
inline std::string json_text(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

/// The same with each element of the array `rows` on a line of its own: a comparison of texts then shows which one changed.
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
