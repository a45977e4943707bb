#pragma once
/// A POSIX extended regular expression. The C library's matcher takes time and memory that are bounded by the length of a
/// name, where that of std::regex can take exponential time, and a stack frame for each letter.

#include <memory>
#include <string>

#include "evenstep/time/result.h"

namespace evenstep::internal {

class Expression {
 public:
  /// At most 1,000 bytes. The error is what the C library says.
  static Result<Expression> of(const std::string& text);
  /// Whether it matches anywhere in `text`.
  bool matches(const std::string& text) const;

 private:
  struct Compiled;
  explicit Expression(std::shared_ptr<const Compiled> compiled) : compiled_(std::move(compiled)) {}
  std::shared_ptr<const Compiled> compiled_;
};

}  // namespace evenstep::internal
