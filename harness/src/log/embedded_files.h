#pragma once
// The files of a scenario within its recording: cut into pieces, each in a block of its own, compressed if zlib is there.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "evenstep/harness/input_log.h"

namespace evenstep::internal {

/// A piece of a file. The pieces of a file follow each other in their order; an empty file has one piece.
struct FilePiece {
  std::uint32_t file = 0;    ///< index into InputLogHead::files
  std::uint64_t size = 0;    ///< of the whole file
  std::uint64_t offset = 0;  ///< of this piece
  std::uint32_t length = 0;  ///< of this piece, unpacked
  bool packed = false;       ///< `bytes` is a zlib stream
  std::string bytes;
};

inline constexpr std::uint32_t kMostPieceBytes = 16U << 20;

std::vector<FilePiece> pieces_of(std::uint32_t file, std::string_view content);
/// Appends a piece to what came before it. Returns what is wrong with it; empty: nothing.
std::string append_piece(const FilePiece& piece, std::string& content);

/// A name without folders, of letters, digits and ".-_" alone.
std::string plain_name(const std::string& path);

std::uint64_t digest_of_content(std::string_view content);

}  // namespace evenstep::internal
