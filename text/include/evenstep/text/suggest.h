#pragma once
/// "did you mean …?": the known word nearest to what was typed.

#include <string>
#include <string_view>
#include <vector>

namespace evenstep::internal {

/// Fewest insertions, deletions, substitutions and swaps of neighbours that turn `a` into `b`.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The nearest of `known`, or empty if none is near: at most a third of the letters wrong, or (three letters and more) an
/// abbreviation: the same first letter and the others in order ("vis" or "vsi" for "visualization").
std::string_view nearest(std::string_view typed, const std::vector<std::string_view>& known);

/// "; did you mean 'x'?" or, if nothing is near, "; known: a, b, c".
std::string suggestion(std::string_view typed, const std::vector<std::string_view>& known);

}  // namespace evenstep::internal
