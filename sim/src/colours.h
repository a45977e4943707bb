#pragma once
/// Four colours for the lattice: no particle has a spring to one of its own colour.

namespace evenstep::internal {

inline constexpr int kColours = 4;

/// By the parities of the site: {000, 111}, {001, 110}, {010, 101}, {100, 011}. Two sites of a colour differ by three even
/// or three odd numbers, neighbours by one or two ones.
constexpr int colour_of(int x, int y, int z) { return ((x ^ z) & 1) | ((y ^ z) & 1) << 1; }

}  // namespace evenstep::internal
