#pragma once
/// Four colours for the lattice: no spring joins two particles of the same colour.

namespace evenstep::internal {

inline constexpr int kColours = 4;

/// The colour follows from the parities of the site's coordinates: {000, 111}, {001, 110}, {010, 101}, {100, 011}. Two sites
/// of one colour differ by an even number in all three coordinates, or by an odd number in all three; neighbours differ by 1
/// in one or two of them.
constexpr int colour_of(int x, int y, int z) { return ((x ^ z) & 1) | ((y ^ z) & 1) << 1; }

}  // namespace evenstep::internal
