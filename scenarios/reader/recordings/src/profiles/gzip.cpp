// What is gzipped, by zlib.
#include <fmt/format.h>
#include <zlib.h>

#include "bytes.h"
#include "evenstep/time/library_on_demand.h"

namespace evenstep::internal {
namespace {

struct Zlib {
  decltype(&::inflateInit2_) init = nullptr;
  decltype(&::inflate) inflate = nullptr;
  decltype(&::inflateReset) reset = nullptr;
  decltype(&::inflateEnd) end = nullptr;
  std::string missing;
};

/// zlib is opened when the first gzipped file is read.
const Zlib& zlib() {
  static const Zlib library = [] {
    Zlib wanted;
    wanted.missing = load_on_demand("libz.so.1", {{"inflateInit2_", reinterpret_cast<void**>(&wanted.init)},
                                                  {"inflate", reinterpret_cast<void**>(&wanted.inflate)},
                                                  {"inflateReset", reinterpret_cast<void**>(&wanted.reset)},
                                                  {"inflateEnd", reinterpret_cast<void**>(&wanted.end)}})
                         .value_or("");
    return wanted;
  }();
  return library;
}

class UnpackedBytes : public Bytes {
 public:
  explicit UnpackedBytes(std::unique_ptr<Bytes> packed) : packed_(std::move(packed)), buffer_(std::size_t{64} << 10, '\0') {
    constexpr int kGzip = 16 + MAX_WBITS;
    if (!zlib().missing.empty()) {
      error_ = fmt::format("is gzipped, and zlib cannot be loaded: {}; install zlib1g, or unpack it", zlib().missing);
    } else if (zlib().init(&stream_, kGzip, ZLIB_VERSION, static_cast<int>(sizeof(z_stream))) != Z_OK) {
      error_ = "is gzipped, and zlib does not start";
    } else {
      open_ = true;
    }
  }
  ~UnpackedBytes() override {
    if (open_) zlib().end(&stream_);
  }
  UnpackedBytes(const UnpackedBytes&) = delete;
  UnpackedBytes& operator=(const UnpackedBytes&) = delete;

  std::string_view next() override {
    while (error_.empty()) {
      if (stream_.avail_in == 0 && !refill()) return {};
      // A file may hold several gzip streams, one after the other.
      if (ended_ && zlib().reset(&stream_) != Z_OK) error_ = "is damaged";
      ended_ = false;
      stream_.next_out = reinterpret_cast<Bytef*>(buffer_.data());
      stream_.avail_out = static_cast<uInt>(buffer_.size());
      const int status = zlib().inflate(&stream_, Z_NO_FLUSH);
      if (status != Z_OK && status != Z_STREAM_END && status != Z_BUF_ERROR) {
        error_ = fmt::format("is damaged: {}", stream_.msg == nullptr ? "no gzip stream" : stream_.msg);
        return {};
      }
      ended_ = status == Z_STREAM_END;
      const std::size_t count = buffer_.size() - stream_.avail_out;
      left_ -= static_cast<std::int64_t>(count);
      if (left_ < 0) error_ = fmt::format("unpacks to more than {} bytes, the limit for such a file", kMostProfileBytes);
      if (count > 0 && error_.empty()) return std::string_view(buffer_).substr(0, count);
    }
    return {};
  }

 private:
  /// False at the end of the file, which is an error within a gzip stream.
  bool refill() {
    const std::string_view piece = packed_->next();
    if (!packed_->error().empty()) {
      error_ = packed_->error();
    } else if (piece.empty() && !ended_) {
      error_ = "is damaged: it ends within a gzip stream";
    }
    // zlib does not write there; its interface is older than const.
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(piece.data()));
    stream_.avail_in = static_cast<uInt>(piece.size());
    return !piece.empty();
  }

  std::unique_ptr<Bytes> packed_;
  std::string buffer_;
  z_stream stream_{};
  bool open_ = false, ended_ = false;
  std::int64_t left_ = kMostProfileBytes;
};

}  // namespace

std::unique_ptr<Bytes> unpacked(std::unique_ptr<Bytes> packed) { return std::make_unique<UnpackedBytes>(std::move(packed)); }

}  // namespace evenstep::internal
