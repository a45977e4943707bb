#pragma once
// Recordings for tests: written by the writer itself, with made-up ticks and steps.

#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "catch.h"
#include "evenstep/harness/input_log.h"
#include "src/log/codec.h"
#include "temporary_folder.h"

namespace evenstep::test {

using Bytes = std::vector<std::byte>;

using testing::TemporaryFolder;

inline Bytes bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

inline InputLogHead made_up_head() {
  InputLogHead head;
  head.version = "0.0.0";
  head.scenario_text = "format = 1\n";
  head.strategy = "phase_locked";
  head.tools = 1;
  return head;
}

/// Slice number `index` of each of the two lanes, with 20 ticks and 9 steps.
inline internal::DeviceSlice device_slice(std::int64_t index) {
  internal::DeviceSlice slice;
  slice.tools.resize(1);
  for (std::int64_t k = 20 * index; k < 20 * (index + 1); ++k) {
    const RealTime at{k * 1'000'000};
    internal::LoggedTick tick;
    tick.input = {{.read_at = at,
                   .position_m = {0.1 * static_cast<double>(k), 0, 0},
                   .sequence = static_cast<std::uint32_t>(k),
                   .fresh = true},
                  at,
                  0,
                  static_cast<std::uint64_t>(k)};
    slice.tools[0].ticks.push_back(tick);
  }
  slice.check = LaneCheck{RealTime{20'000'000 * (index + 1)}, 20 * (index + 1), 7};
  return slice;
}
inline internal::SimulationSlice simulation_slice(std::int64_t index) {
  internal::SimulationSlice slice;
  slice.heads.resize(1);
  slice.segments.push_back({index, RealTime{20'000'000 * index}, RealTime{20'000'000 * (index + 1)}, std::nullopt});
  for (std::int64_t n = 0; n < 9; ++n) {
    const RealTime begin{20'000'000 * index + 2'000'000 * n};
    slice.steps.push_back({index, begin, begin + Duration{1'000'000}});
    slice.heads[0].push_back(static_cast<std::uint64_t>(9 * index + n));
  }
  slice.check = LaneCheck{RealTime{20'000'000 * (index + 1)}, 19 * (index + 1), 9};
  return slice;
}

template <class Struct>
Bytes encoded(const Struct& value) {
  Bytes bytes;
  internal::encode(value, bytes);
  return bytes;
}

inline void append(Bytes& bytes, const Bytes& more) { bytes.insert(bytes.end(), more.begin(), more.end()); }

/// A whole file with this many slices of each lane, and where each of its blocks ends.
struct MadeUp {
  Bytes bytes = internal::file_begin();
  std::vector<std::size_t> ends;

  explicit MadeUp(std::int64_t slices, bool with_end = true) {
    add(internal::BlockKind::head, encoded(made_up_head()));
    for (std::int64_t i = 0; i < slices; ++i) {
      add(internal::BlockKind::device, encoded(device_slice(i)));
      add(internal::BlockKind::simulation, encoded(simulation_slice(i)));
    }
    InputLogEnd end;
    end.counters.resize(1);
    if (with_end) add(internal::BlockKind::end, encoded(end));
  }
  void add(internal::BlockKind kind, const Bytes& content) {
    append(bytes, internal::block_bytes(kind, ends.size(), content));
    ends.push_back(bytes.size());
  }
};

inline std::string errors_of(const InputLogResult& result) {
  std::string all;
  for (const Diagnostic& error : result.error_or({})) all += text(error) + "\n";
  return all;
}

}  // namespace evenstep::test
