#pragma once
/// What somebody with a GPU runs once and sends to us: whether every OpenCL device of a machine computes the bits of the CPU
/// solver, how fast, and what its recordings and a live run look like. `evenstep devices --opencl --check`.

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "evenstep/campaigns/record_solver.h"
#include "evenstep/format/reader.h"
#include "evenstep/sim/opencl_devices.h"

namespace evenstep {

/// A block of tissue whose steps are timed.
struct TimedBlock {
  std::array<int, 3> lattice{};
  std::int64_t particles = 0;
};

struct OpenClCheckOptions {
  /// Reads one of evenstep's own scenarios, with these overrides.
  std::function<ReadResult(const std::string& file, const std::vector<std::string>& set)> read;
  std::vector<TimedBlock> blocks{
      {{10, 10, 10}, 1'000}, {{27, 27, 28}, 20'270}, {{46, 46, 47}, 99'452}, {{79, 79, 80}, 499'280}};
  Duration timed{1'000'000'000};            ///< steps of each block
  Duration recorded{5'000'000'000};         ///< each recording
  Duration live{10'000'000'000};            ///< the live run
  std::vector<std::string> overrides = {};  ///< of every scenario that is read: a smaller one, for tests
  std::function<void(const std::string& what)> progress = {};
  const std::atomic<bool>* interrupted = nullptr;
};

struct OpenClCheckRow {
  enum class State { found, differs, missing };
  std::string what, text;  ///< text: what was found, or why nothing could be
  State state = State::found;
};
struct OpenClCheck {
  OpenClListed device;
  OpenClDescription description;  ///< empty where it does not say
  std::vector<OpenClCheckRow> rows;
  bool any(OpenClCheckRow::State state) const;
};

OpenClCheck check_opencl(const OpenClListed& device, const OpenClCheckOptions& options);
/// What it says of the commands of that many steps, and of a recording.
std::string check_text(const std::vector<DeviceCommand>& commands, std::int64_t steps);
std::string check_text(const RecordSummary& summary);
/// A table in Markdown, to be pasted.
std::string check_table(const std::vector<OpenClCheck>& checks, const RecordedMachine& machine);

}  // namespace evenstep
