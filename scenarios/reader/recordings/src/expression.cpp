#include "expression.h"

#include <regex.h>

namespace evenstep::internal {

struct Expression::Compiled {
  regex_t regex{};
  bool compiled = false;
  ~Compiled() {
    if (compiled) regfree(&regex);
  }
};

Result<Expression> Expression::of(const std::string& text) {
  if (text.size() > 1000) return Failure("longer than 1000 bytes");
  if (text.find('\0') != std::string::npos) return Failure("a zero byte in it");
  auto compiled = std::make_shared<Compiled>();
  const int status = regcomp(&compiled->regex, text.c_str(), REG_EXTENDED | REG_NOSUB);
  compiled->compiled = status == 0;
  if (status == 0) return Expression(std::move(compiled));
  char message[200];
  regerror(status, &compiled->regex, message, sizeof message);
  return Failure(std::string(message));
}

bool Expression::matches(const std::string& text) const {
  return regexec(&compiled_->regex, text.c_str(), 0, nullptr, 0) == 0;
}

}  // namespace evenstep::internal
