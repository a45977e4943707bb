#include "embedded_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <set>

#include "evenstep/format/document.h"
#include "evenstep/format/reader.h"
#include "evenstep/text/text_file.h"
#include "evenstep/time/digest.h"
#include "evenstep/time/library_on_demand.h"

namespace evenstep {
namespace internal {
namespace {

/// zlib, opened when the first file is packed or unpacked. The types are those of zlib.h, which a build need not have.
struct Packer {
  using Bytes = unsigned char*;
  int (*pack)(Bytes to, unsigned long* to_size, const unsigned char* from, unsigned long size, int level) = nullptr;
  int (*unpack)(Bytes to, unsigned long* to_size, const unsigned char* from, unsigned long size) = nullptr;
  std::string missing;
};

const Packer& packer() {
  static const Packer library = [] {
    Packer wanted;
    wanted.missing = load_on_demand("libz.so.1", {{"compress2", reinterpret_cast<void**>(&wanted.pack)},
                                                  {"uncompress", reinterpret_cast<void**>(&wanted.unpack)}})
                         .value_or("");
    return wanted;
  }();
  return library;
}

constexpr int kPacked = 0;  // Z_OK
constexpr int kLevel = 6;

const unsigned char* raw(const char* text) { return reinterpret_cast<const unsigned char*>(text); }

/// Only what gets smaller is packed, so a piece is never longer than it was.
void pack(FilePiece& piece) {
  if (!packer().missing.empty()) return;
  std::string packed(piece.bytes.size(), '\0');
  unsigned long size = packed.size();
  if (packer().pack(reinterpret_cast<unsigned char*>(packed.data()), &size, raw(piece.bytes.data()), piece.bytes.size(),
                    kLevel) != kPacked)
    return;  // it would have got longer
  packed.resize(size);
  piece.bytes = std::move(packed);
  piece.packed = true;
}

}  // namespace

std::vector<FilePiece> pieces_of(std::uint32_t file, std::string_view content) {
  std::vector<FilePiece> pieces;
  std::size_t at = 0;
  do {
    const std::string_view part = content.substr(at, kMostPieceBytes);
    FilePiece& piece = pieces.emplace_back();
    piece = {file, content.size(), at, static_cast<std::uint32_t>(part.size()), false, std::string(part)};
    pack(piece);
    at += part.size();
  } while (at < content.size());
  return pieces;
}

std::string append_piece(const FilePiece& piece, std::string& content) {
  if (piece.offset != content.size() || piece.length > kMostPieceBytes || piece.size > kMostEmbeddedBytes ||
      piece.offset + piece.length > piece.size)
    return "a piece of a file that does not fit behind those before it";
  if (!piece.packed) {
    if (piece.bytes.size() != piece.length) return "a piece of a file of another length";
    content += piece.bytes;
    return {};
  }
  if (!packer().missing.empty()) return "a packed file, and zlib cannot be loaded (install zlib1g): " + packer().missing;
  content.resize(piece.offset + piece.length);
  unsigned long size = piece.length;
  unsigned char none = 0;
  unsigned char* const to = size == 0 ? &none : reinterpret_cast<unsigned char*>(content.data()) + piece.offset;
  if (packer().unpack(to, &size, raw(piece.bytes.data()), piece.bytes.size()) == kPacked && size == piece.length) return {};
  content.resize(piece.offset);
  return "a piece of a file that does not unpack";
}

std::string plain_name(const std::string& path) {
  std::string name = std::filesystem::path(path).filename().string();
  constexpr std::size_t kLongest = 100;
  if (name.size() > kLongest) name.erase(0, name.size() - kLongest);  // the ending says what it is
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '_';
  };
  std::replace_if(
      name.begin(), name.end(), [&](char c) { return !is_plain(c); }, '_');
  if (name.empty() || name.front() == '.') name.insert(0, "_");
  return name;
}

std::uint64_t digest_of_content(std::string_view content) {
  std::uint64_t digest = content.size();
  for (std::size_t at = 0; at < content.size(); at += sizeof digest) {
    std::uint64_t word = 0;
    std::memcpy(&word, content.data() + at, std::min(sizeof word, content.size() - at));
    digest = mix(digest, word);
  }
  return digest;
}

}  // namespace internal

using namespace internal;

std::vector<EmbeddedFile> take_files(InputLogHead& head) {
  Errors ignored;  // the text was read as a scenario before
  Value document = parse_toml(head.scenario_text, "", ignored);
  std::vector<EmbeddedFile> embedded;
  std::map<std::string, std::string> names;  // by path
  std::set<std::string> used;
  std::uint64_t bytes = 0;
  for (Value* const file : data_files(document)) {
    const auto [known, is_new] = names.try_emplace(file->text);
    if (!is_new) {
      if (!known->second.empty()) file->text = known->second;
      continue;
    }
    Result<std::string> content = read_text_file(file->text, std::int64_t{kMostEmbeddedBytes});
    if (!content || bytes + content->size() > kMostEmbeddedBytes) {
      head.files.push_back({file->text, digest_of_file(file->text)});
      continue;
    }
    bytes += content->size();
    std::string name = plain_name(file->text);
    for (int more = 2; !used.insert(name).second; ++more) name = fmt::format("{}-{}", more, plain_name(file->text));
    embedded.push_back({static_cast<std::uint32_t>(head.files.size()), std::move(*content)});
    head.files.push_back({name, digest_of_content(embedded.back().content)});
    file->text = known->second = name;
  }
  for (Value* const plug_in : library_files(document)) head.files.push_back({plug_in->text, digest_of_file(plug_in->text)});
  if (!embedded.empty()) head.scenario_text = print_toml(document);
  return embedded;
}

}  // namespace evenstep
