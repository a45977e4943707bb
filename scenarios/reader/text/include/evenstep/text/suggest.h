#pragma once
/// "did you mean …?": the known word nearest to what was typed.

#include <string>
#include <string_view>
#include <vector>

namespace evenstep::internal {

/// The least number of insertions, deletions, substitutions and swaps of neighbouring letters that turn `a` into `b`.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The nearest of `known`, or empty if none is near. Near means that at most a third of the letters are wrong, or that it is
/// an abbreviation of at least three letters: the same first letter and the others in order ("vis" or "vsi" for
/// "visualization").
std::string_view nearest(std::string_view typed, const std::vector<std::string_view>& known);

/// "; did you mean 'x'?" or, if nothing is near, "; known: a, b, c".
std::string suggestion(std::string_view typed, const std::vector<std::string_view>& known);

}  // namespace evenstep::internal
