#include "evenstep/harness/input_log.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include "codec.h"
#include "crc32c.h"
#include "evenstep/format/document.h"
#include "evenstep/format/reader.h"
#include "evenstep/text/text_file.h"
#include "evenstep/time/digest.h"

namespace evenstep {
namespace {

using namespace internal;

constexpr std::int64_t kMostBytes = std::int64_t{4} << 30;  // five hours of two devices at 1 kHz
constexpr std::int64_t kMostNamedBytes = std::int64_t{1} << 30;
/// No instant of a run lies further from its begin: sums of some of them are still far from an overflow.
constexpr std::int64_t kFarthest_ns = 100'000'000'000'000;  // a day and more
constexpr std::int64_t kMostEvents = std::int64_t{1} << 40;

bool near(RealTime time) { return time.ns >= -kFarthest_ns && time.ns <= kFarthest_ns; }
bool finite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

/// The bytes of a recording, a piece at a time.
class LogBytes {
 public:
  explicit LogBytes(std::size_t size) : size_(size) {}
  virtual ~LogBytes() = default;
  std::size_t size() const { return size_; }
  /// At most `count` bytes from `at` on, fewer at the end. They hold until the next call.
  virtual std::span<const std::byte> read(std::size_t at, std::size_t count) = 0;

 protected:
  std::size_t left(std::size_t at, std::size_t count) const { return std::min(count, size_ - std::min(at, size_)); }

 private:
  std::size_t size_;
};

class BytesInMemory final : public LogBytes {
 public:
  explicit BytesInMemory(std::span<const std::byte> bytes) : LogBytes(bytes.size()), bytes_(bytes) {}
  std::span<const std::byte> read(std::size_t at, std::size_t count) override { return bytes_.subspan(at, left(at, count)); }

 private:
  std::span<const std::byte> bytes_;
};

/// A file that gets shorter meanwhile ends at its new end.
class BytesInFile final : public LogBytes {
 public:
  BytesInFile(const std::string& path, std::size_t size) : LogBytes(size), stream_(path, std::ios::binary) {}
  std::span<const std::byte> read(std::size_t at, std::size_t count) override {
    buffer_.resize(left(at, count));
    stream_.clear();
    stream_.seekg(static_cast<std::streamoff>(at));
    stream_.read(reinterpret_cast<char*>(buffer_.data()), static_cast<std::streamsize>(buffer_.size()));
    return std::span(buffer_).first(static_cast<std::size_t>(std::max<std::streamsize>(0, stream_.gcount())));
  }

 private:
  std::ifstream stream_;
  std::vector<std::byte> buffer_;
};

/// Reads block by block, and stops at the first error.
class LogReader {
 public:
  LogReader(LogBytes& bytes, const std::string& name, const InputLogReading& reading) : bytes_(bytes), reading_(reading) {
    log_.file = name;
    log_.rows.segments = Rows<SegmentRow>(reading.row_files);
    log_.rows.steps = Rows<StepRow>(reading.row_files);
    log_.device_checks = log_.simulation_checks = Rows<LaneCheck>(reading.row_files);
  }

  InputLogResult read() && {
    if (!read_begin()) return Failure(std::move(errors_));
    while (errors_.empty() && read_block()) {
    }
    const bool has_head = log_.blocks > 0;
    if (!errors_.empty() && (!reading_.before_damage || !has_head)) return Failure(std::move(errors_));
    if (!has_head)
      return fail(at_,
                  "the file ends before its first block is whole, so it does not say what was run: there is nothing to "
                  "replay"),
             Failure(std::move(errors_));
    log_.damaged = !errors_.empty();
    log_.bytes = static_cast<std::int64_t>(at_);
    log_.left_bytes = static_cast<std::int64_t>(bytes_.size() - at_);
    return std::move(log_);
  }

 private:
  bool fail(std::size_t at, const std::string& message) {
    if (errors_.empty()) errors_.push_back({fmt::format("{}:{}", log_.file, at), 0, 0, message});
    return false;
  }

  bool read_begin() {
    const std::size_t size = kInputLogMagic.size() + sizeof kInputLogVersion;
    const std::span<const std::byte> begin = bytes_.read(0, size);
    const std::string_view text(reinterpret_cast<const char*>(begin.data()), begin.size());
    if (!text.starts_with(kInputLogMagic))
      return fail(0,
                  "is no recording of a live run, which begins with \"evenstep-record\"; `evenstep run --clock wall "
                  "--record FILE` makes one");
    if (begin.size() < size) return fail(kInputLogMagic.size(), "the file ends within its first 20 bytes");
    std::uint32_t version = 0;
    std::memcpy(&version, begin.data() + kInputLogMagic.size(), sizeof version);
    if (version < kOldestInputLogVersion || version > kInputLogVersion)
      return fail(kInputLogMagic.size(),
                  fmt::format("is a recording of version {}, and this evenstep reads versions {} to {}: replay it with the "
                              "evenstep that made it",
                              version, kOldestInputLogVersion, kInputLogVersion));
    version_ = version;
    at_ = size;
    return true;
  }

  /// False at the end, before a block that is not whole, and after an error.
  bool read_block() {
    BlockHeader header;
    const std::span<const std::byte> head = bytes_.read(at_, sizeof header);
    if (head.size() < sizeof header) return false;
    std::memcpy(&header, head.data(), sizeof header);
    constexpr const char* kRemedy =
        "the file was changed, or its disk lost something; --before-damage replays what stands before it";
    if (header.own_crc != crc32c(head.first(kOwnCrcAt)))
      return fail(at_, fmt::format("the head of block {} has a wrong checksum: {}", log_.blocks, kRemedy));
    if (header.sequence != static_cast<std::uint64_t>(log_.blocks))
      return fail(at_, fmt::format("block {} stands where block {} should: {}", header.sequence, log_.blocks, kRemedy));
    if (header.length > kMostBlockBytes)
      return fail(at_, fmt::format("block {} has {} bytes, and none has more than {}: {}", log_.blocks, header.length,
                                   kMostBlockBytes, kRemedy));
    const std::span<const std::byte> content = bytes_.read(at_ + sizeof header, header.length);
    if (content.size() < header.length) return false;
    if (header.content_crc != crc32c(content))
      return fail(at_, fmt::format("block {} has a wrong checksum: {}", log_.blocks, kRemedy));
    if (!take(header.kind, content))
      return fail(at_, fmt::format("block {} holds what no run can have ({}): {}", log_.blocks, wrong_, kRemedy));
    ++log_.blocks;
    at_ += sizeof header + header.length;
    return true;
  }

  bool take(BlockKind kind, std::span<const std::byte> content) {
    wrong_ = "its fields do not fill it";
    if ((kind == BlockKind::head) != (log_.blocks == 0)) return wrong("the head is the first block, and no other");
    if (log_.end) return wrong("it stands behind the last one");
    lanes_begun_ = lanes_begun_ || (kind != BlockKind::head && kind != BlockKind::file);
    switch (kind) {
      case BlockKind::head:
        return take_head(decode<InputLogHead>(content, version_));
      case BlockKind::file:
        return take_file(decode<FilePiece>(content));
      case BlockKind::device:
        return take_device(decode<DeviceSlice>(content));
      case BlockKind::simulation:
        return take_simulation(decode<SimulationSlice>(content));
      case BlockKind::end:
        return take_end(decode<InputLogEnd>(content, version_));
    }
    return wrong("a kind that is not known");
  }

  bool wrong(std::string why) {
    wrong_ = std::move(why);
    return false;
  }

  bool take_head(std::optional<InputLogHead> head) {
    if (!head) return false;
    if (version_ >= 3 && head->format != version_) return wrong("another version than the file begins with");
    if (head->tools == 0 || head->tools > kMaxTools) return wrong("the number of devices");
    log_.head = std::move(*head);
    log_.inputs.resize(log_.head.tools);
    log_.ticks.resize(log_.head.tools);
    for (std::uint32_t tool = 0; tool < log_.head.tools; ++tool) {
      log_.inputs[tool].ticks = Rows<TickInput>(reading_.row_files);
      log_.inputs[tool].interaction_heads = Rows<std::uint64_t>(reading_.row_files);
      log_.inputs[tool].springs = Rows<DeviceSpring>(reading_.row_files);
      log_.ticks[tool] = Rows<LiveTick>(reading_.row_files);
    }
    return true;
  }

  bool take_file(const std::optional<FilePiece>& piece) {
    if (!piece) return false;
    if (lanes_begun_ || piece->file >= log_.head.files.size()) return wrong("a file that does not belong there");
    std::string& content = log_.files[piece->file];
    if (file_bytes_ + piece->length > kMostEmbeddedBytes) return wrong("more files than a recording may have");
    const std::string why = append_piece(*piece, content);
    file_bytes_ += piece->length;
    return why.empty() || wrong(why);
  }

  bool take_check(const std::optional<LaneCheck>& check, Rows<LaneCheck>& checks) {
    if (!check) return true;
    const LaneCheck before = checks.empty() ? LaneCheck{} : checks.back();
    if (!near(check->until) || check->until < before.until || check->events < before.events || check->events > kMostEvents)
      return wrong("a lane goes back");
    checks.push_back(*check);
    return true;
  }

  bool take_device(std::optional<DeviceSlice> slice) {
    if (!slice) return false;
    if (slice->tools.size() != log_.inputs.size()) return wrong("the number of devices");
    for (std::size_t tool = 0; tool < slice->tools.size(); ++tool) {
      DeviceInputs& inputs = log_.inputs[tool];
      for (const LoggedTick& tick : slice->tools[tool].ticks) {
        if (!is_possible(tick, inputs)) return false;
        inputs.ticks.push_back(tick.input);
        log_.ticks[tool].push_back(tick.live);
      }
      for (const DeviceSpring& spring : slice->tools[tool].springs) {
        if (!finite(spring.center_m) || !finite(spring.below_N_per_m) || !finite(spring.above_N_per_m))
          return wrong("a spring that is not finite");
        inputs.springs.push_back(spring);
      }
    }
    return take_check(slice->check, log_.device_checks);
  }

  bool is_possible(const LoggedTick& tick, const DeviceInputs& inputs) {
    const auto& [sample, played_at, force_head, order] = tick.input;
    if (!near(sample.read_at) || !near(played_at) || !near(RealTime{tick.live.lateness.ns})) return wrong("an instant");
    if (sample.taken_at && (!near(*sample.taken_at) || *sample.taken_at > sample.read_at)) return wrong("an instant");
    if (!finite(sample.position_m)) return wrong("a position that is not finite");
    if (inputs.ticks.empty()) return true;
    const TickInput& before = inputs.ticks.back();
    if (sample.read_at < before.sample.read_at || played_at < before.played_at || order <= before.order ||
        force_head < before.force_head)
      return wrong("ticks that go back");
    return true;
  }

  bool take_simulation(std::optional<SimulationSlice> slice) {
    if (!slice) return false;
    if (slice->heads.size() != log_.inputs.size()) return wrong("the number of devices");
    if (slice->last && !take_last(*slice->last)) return false;
    for (const SegmentRow& segment : slice->segments) {
      if (!take_segment(segment)) return false;
    }
    for (const LoggedStep& step : slice->steps) {
      if (!take_step(step)) return false;
    }
    for (std::size_t tool = 0; tool < slice->heads.size(); ++tool) {
      auto& heads = log_.inputs[tool].interaction_heads;
      heads.insert(heads.end(), slice->heads[tool].begin(), slice->heads[tool].end());
      if (heads.size() < log_.rows.steps.size() + (slice->unfinished ? 1 : 0)) return wrong("steps that read nothing");
    }
    if (slice->unfinished && !near(*slice->unfinished)) return wrong("an instant");
    log_.unfinished = slice->unfinished;
    return take_check(slice->check, log_.simulation_checks);
  }

  bool take_last(const SegmentRow& segment) {
    if (log_.rows.segments.empty() || segment.index != log_.rows.segments.back().index)
      return wrong("a segment that is not the last one");
    log_.rows.segments.pop_back();
    return take_segment(segment);
  }

  bool take_segment(const SegmentRow& segment) {
    if (!near(segment.begin) || !near(segment.end) || segment.end < segment.begin) return wrong("an instant");
    if (segment.visualization) {
      const auto [begin, end] = *segment.visualization;
      if (!near(begin) || !near(end) || end < begin) return wrong("an instant");
    }
    if (!log_.rows.segments.empty() &&
        (segment.index <= log_.rows.segments.back().index || segment.begin < log_.rows.segments.back().begin))
      return wrong("segments that go back");
    log_.rows.segments.push_back(segment);
    return true;
  }

  bool take_step(const LoggedStep& step) {
    if (!near(step.begin) || !near(step.end) || step.end < step.begin) return wrong("an instant");
    const Rows<StepRow>& steps = log_.rows.steps;
    if (log_.rows.segments.empty() || step.segment > log_.rows.segments.back().index ||
        (!steps.empty() && (step.segment < steps.back().segment || step.begin < steps.back().end)))
      return wrong("steps that go back");
    StepRow row;
    row.segment = step.segment;
    row.begin = step.begin;
    row.end = step.end;
    log_.rows.steps.push_back(row);
    return true;
  }

  bool take_end(std::optional<InputLogEnd> end) {
    if (!end) return false;
    if (end->counters.size() != log_.inputs.size()) return wrong("counters of other devices");
    const std::int64_t begun = std::ssize(log_.rows.steps) + (log_.unfinished ? 1 : 0);
    if (end->steps_due && (*end->steps_due < begun || *end->steps_due > kMostEvents)) return wrong("a count of steps");
    log_.end = std::move(*end);
    return true;
  }

  LogBytes& bytes_;
  InputLogReading reading_;
  InputLog log_;
  std::uint32_t version_ = kInputLogVersion;
  std::size_t at_ = 0;
  std::string wrong_;
  bool lanes_begun_ = false;
  std::uint64_t file_bytes_ = 0;
  std::vector<Diagnostic> errors_;
};

/// A folder of its own for as long as a scenario is read, for the files of a recording.
class ReadingFolder {
 public:
  ReadingFolder() {
    std::error_code error;
    std::string name = (std::filesystem::temp_directory_path(error) / "evenstep-replay-XXXXXX").string();
    if (!error && ::mkdtemp(name.data()) != nullptr) path_ = name;
  }
  ~ReadingFolder() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  ReadingFolder(const ReadingFolder&) = delete;
  ReadingFolder& operator=(const ReadingFolder&) = delete;
  /// Empty if it could not be written.
  std::string write(std::uint32_t index, const std::string& name, const std::string& content) const {
    if (path_.empty()) return {};
    const std::string path = fmt::format("{}/{}-{}", path_, index, plain_name(name));
    return write_text_file(path, content).empty() ? path : "";
  }

 private:
  std::string path_;
};

bool is_named(const std::vector<Value*>& files, const std::string& path) {
  return std::any_of(files.begin(), files.end(), [&](const Value* file) { return file->text == path; });
}

/// What is missing for a scenario that names this file, which is not in the recording; empty: nothing.
std::string missing_text(const NamedFile& then, bool plug_in) {
  if (digest_of_file(then.path) == then.digest) return {};
  std::error_code error;
  const bool there = std::filesystem::exists(then.path, error);
  if (plug_in)
    return fmt::format(
        "the plug-in '{}' {}; plug-ins are not part of a recording: put the one there with which the run was recorded",
        then.path, there ? "is not what it was when the run was recorded" : "is not there");
  return fmt::format("'{}' is not what it was when the run was recorded, and it is not in the recording; put it back",
                     then.path);
}

/// Puts the files of a recording into `folder`, and their places into the document.
void place_files(const InputLog& log, Value& document, const std::string& place, const ReadingFolder& folder,
                 std::vector<Diagnostic>& errors) {
  const std::vector<Value*> data = data_files(document), plug_ins = library_files(document);
  for (std::uint32_t index = 0; index < log.head.files.size(); ++index) {
    const NamedFile& then = log.head.files[index];
    const auto embedded = log.files.find(index);
    std::string wrong;
    if (embedded == log.files.end()) {
      wrong = missing_text(then, is_named(plug_ins, then.path));
      if (!is_named(data, then.path) && !is_named(plug_ins, then.path))
        wrong = fmt::format("'{}' is in the head, and the scenario does not name it", then.path);
    } else if (digest_of_content(embedded->second) != then.digest) {
      wrong = fmt::format("'{}' is not whole in the recording: there is nothing to replay", then.path);
    } else if (const std::string path = folder.write(index, then.path, embedded->second); path.empty()) {
      wrong =
          fmt::format("no place for '{}', which is in the recording; is the folder for temporary files full?", then.path);
    } else {
      for (Value* const file : data) {
        if (file->text == then.path) file->text = path;
      }
    }
    if (!wrong.empty()) errors.push_back({place, 0, 0, wrong});
  }
}

}  // namespace

RealTime InputLog::until() const {
  if (device_checks.empty() || simulation_checks.empty()) return {};
  return std::min(device_checks.back().until, simulation_checks.back().until);
}

bool is_input_log(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;
  std::ifstream in(path, std::ios::binary);
  std::array<char, kInputLogMagic.size()> first{};
  in.read(first.data(), first.size());
  return in.gcount() == static_cast<std::streamsize>(first.size()) &&
         std::string_view(first.data(), first.size()) == kInputLogMagic;
}

InputLogResult read_input_log(const std::string& path, const InputLogReading& reading) {
  std::error_code error;
  if (std::filesystem::exists(path, error) && !std::filesystem::is_regular_file(path, error) &&
      !std::filesystem::is_directory(path, error))
    return Failure(std::vector<Diagnostic>{{path, 0, 0, "is no file: a recording is read from a disk"}});
  const TextPieces opened(path, kMostBytes);
  std::string wrong = opened.error();
  const std::uintmax_t size = wrong.empty() ? std::filesystem::file_size(path, error) : 0;
  if (wrong.empty() && error) wrong = error.message();
  if (wrong.empty() && size > static_cast<std::uintmax_t>(kMostBytes))
    wrong = fmt::format("is larger than {} bytes, and no recording may be", kMostBytes);
  if (!wrong.empty()) return Failure(std::vector<Diagnostic>{{path, 0, 0, wrong}});
  BytesInFile bytes(path, size);
  return LogReader(bytes, path, reading).read();
}

InputLogResult parse_input_log(std::span<const std::byte> bytes, const std::string& name, const InputLogReading& reading) {
  BytesInMemory in_memory(bytes);
  return LogReader(in_memory, name, reading).read();
}

const char* compiler_here() { return __VERSION__; }

std::uint64_t digest_of_forces(const StrategyRecord& record) {
  std::uint64_t digest = 0;
  for (const DeviceRecord& device : record.devices) {
    digest = mix(digest, name_digest(device.name));
    for (const TickRow& tick : device.ticks) {
      for (const double part_N : tick.force_N) digest = mix(digest, part_N);
    }
  }
  return digest;
}

ReadResult scenario_of(const InputLog& log, const Registry& registry) {
  const std::string place = log.file + ":scenario";
  Errors errors;
  Value document = parse_toml(log.head.scenario_text, place, errors);
  if (errors.any()) return Failure(errors.sorted(place));
  const ReadingFolder folder;
  std::vector<Diagnostic> missing;
  place_files(log, document, place, folder, missing);
  if (!missing.empty()) return Failure(std::move(missing));
  ReadResult scenario = read_document(std::move(document), place, registry, true);
  if (!scenario) return scenario;
  if (scenario->case_spec || scenario->devices.size() != log.inputs.size() || name_of(scenario->live) != log.head.strategy)
    return Failure(
        std::vector<Diagnostic>{{place, 0, 0, "the devices or the live strategy are not those of the recording"}});
  if (!log.files.empty()) scenario->resolved_toml = log.head.scenario_text;  // not with places that are gone
  return scenario;
}

std::uint64_t digest_of_file(const std::string& path) {
  const Result<std::string> content = read_text_file(path, kMostNamedBytes);
  return content ? digest_of_content(*content) : 0;
}

}  // namespace evenstep
