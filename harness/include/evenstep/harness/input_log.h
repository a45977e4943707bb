#pragma once
/// The recording of a run on the wall clock, as a file that is written while it runs (`run --record FILE`): everything that
/// a replay needs, in blocks, each with a checksum. docs/devices/replay.md has the format byte by byte and what is kept
/// when.
///
/// A file whose writer was killed is valid up to its last whole block. Files are not trusted: whatever they contain is
/// either read or an error with its place.

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "evenstep/harness/live_devices.h"
#include "evenstep/loop/exchange.h"
#include "evenstep/reports/rows.h"
#include "evenstep/reports/run_record.h"
#include "evenstep/scheduler/step_timing.h"
#include "evenstep/text/diagnostic.h"
#include "evenstep/time/result.h"

namespace evenstep {

/// The version that is written, and the oldest that is read.
inline constexpr std::uint32_t kInputLogVersion = 3, kOldestInputLogVersion = 2;
/// The most that all files in a recording may have together, unpacked.
inline constexpr std::uint64_t kMostEmbeddedBytes = std::uint64_t{256} << 20;

/// A file that the scenario names, as it was when the run began. Data files (recorded timing, motions) are stored in the
/// recording, under a name without a folder, up to kMostEmbeddedBytes. Data files that are not stored, and plug-ins, must
/// still be where they were.
struct NamedFile {
  std::string path;  ///< as the scenario's text has it
  std::uint64_t digest = 0;
};

/// The first block: what ran, and how.
struct InputLogHead {
  std::string version, build;  ///< of evenstep: "0.2.0"; the compiler
  std::string scenario_file;
  std::string scenario_text;           ///< the whole scenario in one: `extends`, --set and --seed are merged into it
  std::vector<NamedFile> files;        ///< the files that this text names (recorded timing, motions, plug-ins)
  RunOrigin origin;                    ///< when it began, and from which commit of the user's repository
  std::vector<DeviceBinding> devices;  ///< --device
  bool forces = false;                 ///< --forces
  std::optional<std::uint64_t> permute_ties;
  std::string strategy;  ///< the live one
  std::uint32_t tools = 0;
  /// The version that the file begins with, once more, because here it is under a checksum. Version 2 does not have it.
  std::uint32_t format = kInputLogVersion;
};

/// A file that goes into the recording.
struct EmbeddedFile {
  std::uint32_t index = 0;  ///< into InputLogHead::files
  std::string content;
};

/// How far a lane had got at the end of a slice of 20 ms, and the hash of all its events until then.
struct LaneCheck {
  RealTime until;  ///< all events before it have run
  std::int64_t events = 0;
  std::uint64_t hash = 0;
  bool operator==(const LaneCheck&) const = default;
};

/// What the record of a live run has in addition to what a replay computes again.
struct LiveTick {
  Duration lateness;
  glm::dvec3 force_N{0};  ///< as it was sent
};

/// The last block.
struct InputLogEnd {
  std::uint64_t trace_hash = 0;     ///< of the live strategy
  std::uint64_t forces_digest = 0;  ///< digest_of_forces()
  bool interrupted = false;         ///< by a signal, before the end of the scenario
  bool real_time_granted = false;
  std::vector<std::map<std::string, double>> counters;  ///< per device
  /// Steps that were due before the end, including those that never began. Version 2 does not have it.
  std::optional<std::int64_t> steps_due;
};

/// A recording as it was read.
struct InputLog {
  std::string file;
  InputLogHead head;
  /// The files stored in it, by their index, as far as their pieces are there: a complete file has the digest that the head
  /// gives.
  std::map<std::uint32_t, std::string> files;
  std::vector<DeviceInputs> inputs;
  std::vector<Rows<LiveTick>> ticks;   ///< per device, the same index as DeviceInputs::ticks
  StrategyRecord rows;                 ///< its segments, and begin and end of its steps; nothing else
  std::optional<RealTime> unfinished;  ///< when the step that was running at the end was launched
  Rows<LaneCheck> device_checks, simulation_checks;
  std::optional<InputLogEnd> end;  ///< empty: the writer was killed, or its disk was full
  std::int64_t blocks = 0;
  std::int64_t bytes = 0;       ///< of the whole blocks, including what stands before them
  std::int64_t left_bytes = 0;  ///< after those: an incomplete block, or everything from a damaged block on
  bool damaged = false;         ///< the left bytes begin with a damaged block, as InputLogReading::before_damage allows

  /// The instant up to which both lanes are recorded; 0 if there is no input at all.
  RealTime until() const;
  /// Whether the run came to its end, and all of it is here.
  bool whole() const { return end && !end->interrupted; }
};

/// Whether the file begins as such a recording does.
bool is_input_log(const std::string& path);

struct InputLogReading {
  bool before_damage = false;  ///< a damaged block is no error: read what stands before the first one
  /// Where the rows go; null: into memory.
  std::shared_ptr<RowFiles> row_files = nullptr;
};
using InputLogResult = Result<InputLog, std::vector<Diagnostic>>;
/// A file is read block by block, so that with `row_files` the memory does not depend on how long the run was.
/// Errors name file and byte: not a recording, another version, an incomplete head, a wrong checksum, contents that no run
/// can have.
InputLogResult read_input_log(const std::string& path, const InputLogReading& reading = {});
/// The same for bytes in memory; `name` stands for the file in errors.
InputLogResult parse_input_log(std::span<const std::byte> bytes, const std::string& name, const InputLogReading& = {});

/// The scenario that ran, as the head has it; messages give its place as "FILE:scenario". It is also an error if a file that
/// it names has changed.
ReadResult scenario_of(const InputLog& log, const Registry& registry = {});

/// The compiler of this evenstep: another one may round sums in another way.
const char* compiler_here();

/// A digest of the forces of all ticks as they were sent, bit for bit, device by device.
std::uint64_t digest_of_forces(const StrategyRecord& record);

/// Lists in head.files the files that head.scenario_text names, and returns those that are to be stored in the recording;
/// the text is changed to give each its new name. Of the others (files that cannot be read or are too large, and plug-ins)
/// only the digest is kept.
std::vector<EmbeddedFile> take_files(InputLogHead& head);
/// The digest of the file's present content; 0 if it cannot be read.
std::uint64_t digest_of_file(const std::string& path);

}  // namespace evenstep
