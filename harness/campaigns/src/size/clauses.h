#pragma once
/// "split 2, budget 20 ms hold": clauses separated by commas, each of which begins with a word and stands there once.

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace evenstep::internal {

inline std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(' ');
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

/// read(clause, word, rest) returns "" or why not; so does this.
template <class Read>
std::string each_clause(std::string_view text, Read read) {
  std::vector<std::string_view> seen;
  for (std::string_view left = text;;) {
    const std::size_t comma = std::min(left.find(','), left.size());
    const std::string_view clause = trimmed(left.substr(0, comma));
    const std::size_t space = std::min(clause.find(' '), clause.size());
    const std::string_view word = clause.substr(0, space);
    if (const std::string error = read(clause, word, trimmed(clause.substr(space))); !error.empty()) return error;
    if (std::find(seen.begin(), seen.end(), word) != seen.end()) return fmt::format("\"{}\" is there twice", word);
    seen.push_back(word);
    if (comma == left.size()) return {};
    left.remove_prefix(comma + 1);
  }
}

}  // namespace evenstep::internal
