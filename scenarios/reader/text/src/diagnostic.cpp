#include "evenstep/text/diagnostic.h"

#include <fmt/format.h>

namespace evenstep {

std::string text(const Diagnostic& diagnostic) {
  if (diagnostic.line == 0) return fmt::format("{}: error: {}", diagnostic.file, diagnostic.message);
  return fmt::format("{}:{}:{}: error: {}", diagnostic.file, diagnostic.line, diagnostic.column, diagnostic.message);
}

}  // namespace evenstep
