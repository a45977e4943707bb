#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <ostream>
#include <stdexcept>
#include <string_view>

#include "evenstep/reports/writers.h"
#include "writers/texts/text.h"

namespace evenstep {
namespace {

constexpr std::string_view kMagic = "EVSTEP01";
constexpr std::size_t kRowBytes = 20;       // time, hash, name, lane, zero
constexpr std::size_t kStrategyBytes = 24;  // at least: name length, trace hash, event name count, row count
constexpr std::uint8_t kLanes = 3;

class Writer {
 public:
  explicit Writer(std::ostream& out) : out_(out) {}
  template <class Unsigned>
  void put(Unsigned value) {
    std::array<char, sizeof(Unsigned)> bytes;
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(value >> (8 * i) & 0xFF);
    raw({bytes.data(), bytes.size()});
  }
  void text(std::string_view text) {
    put(static_cast<std::uint32_t>(text.size()));
    raw(text);
  }
  void raw(std::string_view text) { out_.write(text.data(), static_cast<std::streamsize>(text.size())); }

 private:
  std::ostream& out_;
};

/// Reads from the bytes of a file. It first checks how many bytes are left, so nothing is allocated for a size that the file
/// cannot contain.
class Reader {
 public:
  explicit Reader(const std::vector<std::byte>& bytes) : bytes_(bytes) {}

  template <class Unsigned>
  Unsigned take(const char* what) {
    need(sizeof(Unsigned), what);
    Unsigned value = 0;
    for (std::size_t i = 0; i < sizeof(Unsigned); ++i)
      value |= static_cast<Unsigned>(static_cast<Unsigned>(bytes_[at_ + i]) << (8 * i));
    at_ += sizeof(Unsigned);
    return value;
  }
  std::string text(const char* what) {
    const auto length = take<std::uint32_t>(what);
    need(length, what);
    std::string text(length, '\0');
    std::memcpy(text.data(), bytes_.data() + at_, length);
    at_ += length;
    return text;
  }
  /// A count of items that have at least `least` bytes each.
  template <class Unsigned>
  std::size_t count(const char* what, std::size_t least) {
    const std::size_t before = at_;
    const Unsigned value = take<Unsigned>(what);
    if (value > (bytes_.size() - at_) / least)
      fail(before, fmt::format("{} {} do not fit in the rest of the file", value, what));
    return static_cast<std::size_t>(value);
  }
  [[noreturn]] void fail(std::size_t offset, const std::string& what) const {
    throw std::runtime_error(fmt::format("events.bin: byte {}: {}", offset, what));
  }
  std::size_t at() const { return at_; }
  std::size_t left() const { return bytes_.size() - at_; }

 private:
  void need(std::size_t size, const char* what) const {
    if (size > left()) fail(at_, fmt::format("the file ends inside {} ({} bytes needed, {} left)", what, size, left()));
  }
  const std::vector<std::byte>& bytes_;
  std::size_t at_ = 0;
};

EventRow take_row(Reader& reader, std::size_t names) {
  EventRow row;
  row.time = {static_cast<std::int64_t>(reader.take<std::uint64_t>("an event"))};
  row.chained_hash = reader.take<std::uint64_t>("an event");
  row.name = reader.take<std::uint16_t>("an event");
  if (row.name >= names) reader.fail(reader.at() - 2, fmt::format("event name {} of {}", row.name, names));
  row.lane = reader.take<std::uint8_t>("an event");
  if (row.lane >= kLanes) reader.fail(reader.at() - 1, fmt::format("unknown lane {}", row.lane));
  if (reader.take<std::uint8_t>("an event") != 0) reader.fail(reader.at() - 1, "the spare byte is not 0");
  return row;
}

StrategyRecord take_strategy(Reader& reader) {
  StrategyRecord strategy;
  strategy.name = reader.text("a strategy's name");
  strategy.trace_hash = reader.take<std::uint64_t>("a trace hash");
  const auto names = reader.count<std::uint32_t>("event names", sizeof(std::uint32_t));
  for (std::size_t i = 0; i < names; ++i) strategy.event_names.push_back(reader.text("an event name"));
  const auto rows = reader.count<std::uint64_t>("events", kRowBytes);
  strategy.events.reserve(rows);
  for (std::size_t i = 0; i < rows; ++i) strategy.events.push_back(take_row(reader, names));
  return strategy;
}

const char* lane_text(std::uint8_t lane) {
  constexpr const char* kNames[] = {"completion", "device", "launch"};
  return lane < kLanes ? kNames[lane] : "unknown";
}

std::string event_text(const StrategyRecord& strategy, std::size_t index) {
  if (index >= strategy.events.size()) return fmt::format("ends after {} events", strategy.events.size());
  const EventRow& event = strategy.events[index];
  const std::string name = event.name < strategy.event_names.size() ? strategy.event_names[event.name] : "?";
  return fmt::format("{} s {}.{} (hash {:016x})", internal::exact_seconds(event.time), lane_text(event.lane), name,
                     event.chained_hash);
}

/// The number of equal events at the beginning. The hashes are chained, so once they differ they always differ, and a binary
/// search finds the first difference.
std::size_t equal_prefix(const StrategyRecord& a, const StrategyRecord& b) {
  std::size_t low = 0, high = std::min(a.events.size(), b.events.size());
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    if (a.events[middle].chained_hash == b.events[middle].chained_hash) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

std::optional<Difference> difference_of(const StrategyRecord& a, const StrategyRecord& b) {
  const std::size_t index = equal_prefix(a, b);
  if (index == a.events.size() && index == b.events.size() && a.trace_hash == b.trace_hash) return std::nullopt;
  std::string text =
      fmt::format("{}: first difference at event {}: A {}, B {}", a.name, index, event_text(a, index), event_text(b, index));
  if (index == a.events.size() && index == b.events.size()) {
    text = fmt::format("{}: all {} events are equal but the trace hash is not: A {:016x}, B {:016x}", a.name, index,
                       a.trace_hash, b.trace_hash);
  }
  return Difference{a.name, static_cast<std::int64_t>(index), std::move(text)};
}

const StrategyRecord* find(const std::vector<StrategyRecord>& strategies, const std::string& name) {
  const auto found = std::find_if(strategies.begin(), strategies.end(), [&](const auto& s) { return s.name == name; });
  return found == strategies.end() ? nullptr : &*found;
}

/// The real time of the difference: the earlier time of the events there, if both logs have one.
RealTime time_of(const Difference& difference, const StrategyRecord& a, const StrategyRecord& b) {
  RealTime time = kNever;
  const auto index = static_cast<std::size_t>(difference.index);
  for (const StrategyRecord* strategy : {&a, &b}) {
    if (index < strategy->events.size()) time = std::min(time, strategy->events[index].time);
  }
  return time;
}

}  // namespace

void events_bin(const RunRecord& run, std::ostream& stream) {
  Writer out(stream);
  out.raw(kMagic);
  out.put(static_cast<std::uint32_t>(run.strategies.size()));
  for (const StrategyRecord& strategy : run.strategies) {
    out.text(strategy.name);
    out.put(strategy.trace_hash);
    out.put(static_cast<std::uint32_t>(strategy.event_names.size()));
    for (const std::string& name : strategy.event_names) out.text(name);
    out.put(static_cast<std::uint64_t>(strategy.events.size()));
    for (const EventRow& event : strategy.events) {
      out.put(static_cast<std::uint64_t>(event.time.ns));
      out.put(event.chained_hash);
      out.put(event.name);
      out.put(event.lane);
      out.put(std::uint8_t{0});
    }
  }
}

EventFile read_events_bin(const std::vector<std::byte>& bytes) {
  Reader reader(bytes);
  if (bytes.size() < kMagic.size() || std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) != 0) {
    reader.fail(0, "this is not an event log of format 1 (EVSTEP01)");
  }
  reader.take<std::uint64_t>("the magic");
  EventFile file;
  const auto strategies = reader.count<std::uint32_t>("strategies", kStrategyBytes);
  for (std::size_t i = 0; i < strategies; ++i) file.push_back(take_strategy(reader));
  if (reader.left() > 0) reader.fail(reader.at(), fmt::format("{} bytes after the last strategy", reader.left()));
  return file;
}

std::optional<Difference> first_difference(const std::vector<StrategyRecord>& a, const std::vector<StrategyRecord>& b) {
  for (const StrategyRecord& strategy : a) {
    if (!find(b, strategy.name)) return Difference{strategy.name, -1, strategy.name + ": only A has this strategy"};
  }
  for (const StrategyRecord& strategy : b) {
    if (!find(a, strategy.name)) return Difference{strategy.name, -1, strategy.name + ": only B has this strategy"};
  }
  std::optional<Difference> first;
  RealTime first_time = kNever;
  for (const StrategyRecord& strategy : a) {
    const StrategyRecord& other = *find(b, strategy.name);
    std::optional<Difference> difference = difference_of(strategy, other);
    if (!difference) continue;
    const RealTime time = time_of(*difference, strategy, other);
    if (first && time >= first_time) continue;
    first = std::move(difference);
    first_time = time;
  }
  return first;
}

}  // namespace evenstep
