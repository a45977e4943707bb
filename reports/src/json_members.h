#pragma once
/// Writes JSON objects and arrays member by member.

#include <fmt/format.h>

#include <optional>
#include <string>
#include <string_view>

#include "src/text.h"

namespace evenstep::internal {

/// One level of an object or array; it adds the commas.
class Members {
 public:
  explicit Members(std::string& out) : out_(out) {}
  std::string& next() {
    if (!first_) out_ += ',';
    first_ = false;
    return out_;
  }
  std::string& key(std::string_view name) { return next() += json_string(name) + ':'; }
  void text(std::string_view name, std::string_view value) { key(name) += json_string(value); }
  void number(std::string_view name, double value) { key(name) += json_number(value); }
  void number(std::string_view name, const std::optional<double>& value) {
    key(name) += value ? json_number(*value) : "null";
  }
  void whole(std::string_view name, std::int64_t value) { key(name) += fmt::format("{}", value); }
  void flag(std::string_view name, bool value) { key(name) += value ? "true" : "false"; }

 private:
  std::string& out_;
  bool first_ = true;
};

}  // namespace evenstep::internal
