#pragma once
// The bytes of a recording's blocks. Each struct has one function `code`, which lists its fields and both writes and reads
// them. A new field is a new line there, which asks for the version, and it makes kInputLogVersion one higher.
//
// Integers and doubles are little-endian, bool is a byte 0 or 1. A text or list has its length (32 bits) in front of it,
// and a value that may be missing has a bool.

#include <bit>
#include <cstddef>
#include <cstring>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "embedded_files.h"
#include "evenstep/harness/input_log.h"

namespace evenstep::internal {

static_assert(std::endian::native == std::endian::little, "a big-endian machine has to swap bytes here");

struct LoggedTick {
  TickInput input;
  LiveTick live;
};
/// What a device adds in a slice.
struct ToolSlice {
  std::vector<LoggedTick> ticks;
  std::vector<DeviceSpring> springs;
};
struct DeviceSlice {
  std::vector<ToolSlice> tools;
  std::optional<LaneCheck> check;  ///< empty: there is more to come before it
};
struct LoggedStep {
  std::int64_t segment = 0;
  RealTime begin, end;
};
struct SimulationSlice {
  std::optional<SegmentRow> last;  ///< the last segment of the slices before, if its visualization has gone on since
  std::vector<SegmentRow> segments;
  std::vector<LoggedStep> steps;
  std::vector<std::vector<std::uint64_t>> heads;  ///< per device and step
  std::optional<RealTime> unfinished;             ///< launch of the step that runs at the end of the slice
  std::optional<LaneCheck> check;
};

/// Of a sample, as one byte.
enum class Driven : std::uint8_t { no = 0, yes = 1, away = 2 };

template <class Codec>
void code(Codec& codec, DeviceSample& sample) {
  Driven driven = sample.away ? Driven::away : sample.drivable ? Driven::yes : Driven::no;
  codec(sample.read_at, sample.taken_at, sample.position_m, sample.sequence, sample.fresh, sample.at_range, driven);
  if constexpr (Codec::kReads) {
    sample.drivable = driven == Driven::yes;
    sample.away = driven == Driven::away;
  }
}
template <class Codec>
void code(Codec& codec, TickInput& input) {
  codec(input.sample, input.played_at, input.force_head, input.order);
}
template <class Codec>
void code(Codec& codec, LoggedTick& tick) {
  codec(tick.input, tick.live.lateness, tick.live.force_N);
}
template <class Codec>
void code(Codec& codec, DeviceSpring& spring) {
  codec(spring.center_m, spring.below_N_per_m, spring.above_N_per_m, spring.limit_N);
}
template <class Codec>
void code(Codec& codec, LaneCheck& check) {
  codec(check.until, check.events, check.hash);
}
template <class Codec>
void code(Codec& codec, ToolSlice& slice) {
  codec(slice.ticks, slice.springs);
}
template <class Codec>
void code(Codec& codec, DeviceSlice& slice) {
  codec(slice.tools, slice.check);
}
template <class Codec>
void code(Codec& codec, LoggedStep& step) {
  codec(step.segment, step.begin, step.end);
}
template <class Codec>
void code(Codec& codec, SegmentRow& segment) {
  codec(segment.index, segment.begin, segment.end, segment.visualization, segment.finishes, segment.left_out);
}
template <class Codec>
void code(Codec& codec, SimulationSlice& slice) {
  codec(slice.last, slice.segments, slice.steps, slice.heads, slice.unfinished, slice.check);
}
template <class Codec>
void code(Codec& codec, NamedFile& file) {
  codec(file.path, file.digest);
}
template <class Codec>
void code(Codec& codec, FilePiece& piece) {
  codec(piece.file, piece.size, piece.offset, piece.length, piece.packed, piece.bytes);
}
template <class Codec>
void code(Codec& codec, DeviceBinding& binding) {
  codec(binding.name, binding.path);
}
template <class Codec>
void code(Codec& codec, InputLogHead& head) {
  codec(head.version, head.build, head.scenario_file, head.scenario_text, head.files, head.origin.date, head.origin.commit,
        head.devices, head.forces, head.permute_ties, head.strategy, head.tools);
  if (codec.version() >= 3) codec(head.format);
}
template <class Codec>
void code(Codec& codec, InputLogEnd& end) {
  codec(end.trace_hash, end.forces_digest, end.interrupted, end.real_time_granted, end.counters);
  if (codec.version() >= 3) codec(end.steps_due);
}

/// Writes at the end of `bytes`.
class Encoder {
 public:
  static constexpr bool kReads = false;
  explicit Encoder(std::vector<std::byte>& bytes) : bytes_(bytes) {}
  std::uint32_t version() const { return kInputLogVersion; }
  template <class... Fields>
  void operator()(Fields&... fields) {
    (one(fields), ...);
  }

 private:
  template <class Number>
  void raw(Number number) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof number);
    std::memcpy(bytes_.data() + at, &number, sizeof number);
  }
  void length(std::size_t count) { raw(static_cast<std::uint32_t>(count)); }

  void one(bool& value) { raw(static_cast<std::uint8_t>(value ? 1 : 0)); }
  void one(Driven& value) { raw(static_cast<std::uint8_t>(value)); }
  void one(std::uint32_t& value) { raw(value); }
  void one(std::uint64_t& value) { raw(value); }
  void one(std::int64_t& value) { raw(value); }
  void one(double& value) { raw(value); }
  void one(RealTime& time) { raw(time.ns); }
  void one(Duration& duration) { raw(duration.ns); }
  void one(glm::dvec3& v) { (*this)(v.x, v.y, v.z); }
  void one(std::array<RealTime, 2>& pair) { (*this)(pair[0], pair[1]); }
  void one(std::string& text) {
    length(text.size());
    const auto bytes = std::as_bytes(std::span(text));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  template <class T>
  void one(std::optional<T>& value) {
    bool there = value.has_value();
    one(there);
    if (there) one(*value);
  }
  template <class T>
  void one(std::vector<T>& list) {
    length(list.size());
    for (T& value : list) one(value);
  }
  void one(std::map<std::string, double>& table) {
    length(table.size());
    for (auto& [key, value] : table) {
      raw(static_cast<std::uint32_t>(key.size()));
      const auto bytes = std::as_bytes(std::span(key));
      bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
      raw(value);
    }
  }
  template <class Struct>
  void one(Struct& fields) {
    code(*this, fields);
  }

  std::vector<std::byte>& bytes_;
};

/// Reads from the begin of `bytes`. After something that is missing or impossible, nothing more is read.
class Decoder {
 public:
  static constexpr bool kReads = true;
  Decoder(std::span<const std::byte> bytes, std::uint32_t version) : bytes_(bytes), version_(version) {}
  std::uint32_t version() const { return version_; }
  template <class... Fields>
  void operator()(Fields&... fields) {
    (one(fields), ...);
  }
  /// Whether everything was there, and nothing else.
  bool whole() const { return !failed_ && at_ == bytes_.size(); }
  std::size_t at() const { return at_; }

 private:
  template <class Number>
  void raw(Number& number) {
    if (failed_ || bytes_.size() - at_ < sizeof number) {
      failed_ = true;
      return;
    }
    std::memcpy(&number, bytes_.data() + at_, sizeof number);
    at_ += sizeof number;
  }
  /// Every entry takes a byte at least, so an impossible count is found before anything is allocated for it.
  std::size_t length() {
    std::uint32_t count = 0;
    raw(count);
    failed_ = failed_ || count > bytes_.size() - at_;
    return failed_ ? 0 : count;
  }

  void one(bool& value) {
    std::uint8_t byte = 0;
    raw(byte);
    failed_ = failed_ || byte > 1;
    value = byte == 1;
  }
  void one(Driven& value) {
    std::uint8_t byte = 0;
    raw(byte);
    failed_ = failed_ || byte > 2;
    value = static_cast<Driven>(failed_ ? 0 : byte);
  }
  void one(std::uint32_t& value) { raw(value); }
  void one(std::uint64_t& value) { raw(value); }
  void one(std::int64_t& value) { raw(value); }
  void one(double& value) { raw(value); }
  void one(RealTime& time) { raw(time.ns); }
  void one(Duration& duration) { raw(duration.ns); }
  void one(glm::dvec3& v) { (*this)(v.x, v.y, v.z); }
  void one(std::array<RealTime, 2>& pair) { (*this)(pair[0], pair[1]); }
  void one(std::string& text) {
    const std::size_t count = length();
    text.assign(reinterpret_cast<const char*>(bytes_.data() + at_), count);
    at_ += count;
  }
  template <class T>
  void one(std::optional<T>& value) {
    bool there = false;
    one(there);
    if (there && !failed_) one(value.emplace());
  }
  template <class T>
  void one(std::vector<T>& list) {
    for (std::size_t left = length(); left > 0 && !failed_; --left) one(list.emplace_back());
  }
  void one(std::map<std::string, double>& table) {
    for (std::size_t left = length(); left > 0 && !failed_; --left) {
      std::string key;
      double value = 0;
      (*this)(key, value);
      table.insert_or_assign(std::move(key), value);
    }
  }
  template <class Struct>
  void one(Struct& fields) {
    code(*this, fields);
  }

  std::span<const std::byte> bytes_;
  std::uint32_t version_;
  std::size_t at_ = 0;
  bool failed_ = false;
};

template <class Struct>
void encode(const Struct& value, std::vector<std::byte>& bytes) {
  Encoder encoder(bytes);
  encoder(const_cast<Struct&>(value));  // it only reads; `code` is one function for both ways
}
/// Empty if these bytes are not exactly one such struct, in a file of this version.
template <class Struct>
std::optional<Struct> decode(std::span<const std::byte> bytes, std::uint32_t version = kInputLogVersion) {
  Decoder decoder(bytes, version);
  std::optional<Struct> value(std::in_place);
  decoder(*value);
  return decoder.whole() ? std::move(value) : std::nullopt;
}

/// What the file begins with; the number of its version follows.
inline constexpr std::string_view kInputLogMagic = "evenstep-record\n";

enum class BlockKind : std::uint32_t { head = 1, device = 2, simulation = 3, end = 4, file = 5 };

/// In front of every block.
struct BlockHeader {
  std::uint32_t length = 0;  ///< bytes that follow this header
  BlockKind kind = BlockKind::head;
  std::uint64_t sequence = 0;     ///< 0 for the head, then one more with each block
  std::uint32_t content_crc = 0;  ///< CRC-32C of what follows
  std::uint32_t own_crc = 0;      ///< CRC-32C of the 20 bytes before it
};
static_assert(sizeof(BlockHeader) == 24 && std::is_trivially_copyable_v<BlockHeader>);
inline constexpr std::size_t kOwnCrcAt = 20;

/// The head with the longest scenario, or a piece of a file; a slice has some thousand bytes.
inline constexpr std::uint32_t kMostBlockBytes = 32U << 20;

/// A block as it stands in the file.
std::vector<std::byte> block_bytes(BlockKind kind, std::uint64_t sequence, std::span<const std::byte> content);
/// Magic and version.
std::vector<std::byte> file_begin();

}  // namespace evenstep::internal
