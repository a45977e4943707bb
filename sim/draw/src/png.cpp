#include <fmt/format.h>
#include <zlib.h>

#include <array>
#include <string_view>

#include "evenstep/draw/canvas.h"
#include "evenstep/time/library_on_demand.h"

namespace evenstep {
namespace {

struct Zlib {
  decltype(&::compress2) compress2 = nullptr;
  decltype(&::compressBound) compressBound = nullptr;
  decltype(&::crc32) crc32 = nullptr;
  std::string missing;
};
const Zlib& zlib() {
  static const Zlib library = [] {
    Zlib wanted;
    wanted.missing = load_on_demand("libz.so.1", {{"compress2", reinterpret_cast<void**>(&wanted.compress2)},
                                                  {"compressBound", reinterpret_cast<void**>(&wanted.compressBound)},
                                                  {"crc32", reinterpret_cast<void**>(&wanted.crc32)}})
                         .value_or("");
    return wanted;
  }();
  return library;
}

std::string big_endian(std::uint32_t value) {
  std::string bytes;
  for (const int shift : {24, 16, 8, 0}) bytes += static_cast<char>(value >> shift & 0xff);
  return bytes;
}

std::string chunk(std::string_view type, const std::string& data) {
  const std::string body = std::string(type) + data;
  const auto crc = zlib().crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()));
  return big_endian(static_cast<std::uint32_t>(data.size())) + body + big_endian(static_cast<std::uint32_t>(crc));
}

}  // namespace

// PNG (ISO/IEC 15948), colour type 2 (red, green, blue), each row without a filter.
Result<std::string> png_of(const Image& image) {
  if (!zlib().missing.empty()) return Failure(fmt::format("zlib cannot be loaded: {}; install zlib1g", zlib().missing));
  std::string rows;
  const std::uint8_t* pixel = image.pixels.data();
  for (int y = 0; y < image.height; ++y) {
    rows += '\0';
    for (int x = 0; x < image.width; ++x, pixel += 4) rows.append(reinterpret_cast<const char*>(pixel), 3);
  }
  uLongf size = zlib().compressBound(static_cast<uLong>(rows.size()));
  std::string packed(size, '\0');
  if (zlib().compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(rows.data()),
                       static_cast<uLong>(rows.size()), Z_DEFAULT_COMPRESSION) != Z_OK)
    return Failure(std::string("zlib cannot pack the picture"));
  packed.resize(size);
  const std::string header = big_endian(static_cast<std::uint32_t>(image.width)) +
                             big_endian(static_cast<std::uint32_t>(image.height)) + std::string("\x08\x02\0\0\0", 5);
  return "\x89PNG\r\n\x1a\n" + chunk("IHDR", header) + chunk("IDAT", packed) + chunk("IEND", "");
}

}  // namespace evenstep
