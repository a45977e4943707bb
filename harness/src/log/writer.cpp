#include "writer.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "crc32c.h"

namespace evenstep::internal {
namespace {

/// How often the rings are emptied. A kill can lose what the lanes have handed over in this time.
constexpr Duration kLook{10'000'000};
/// How often data is forced to the disk, which takes milliseconds to seconds.
constexpr Duration kFlush{1'000'000'000};
/// Five seconds of two devices at 1 kHz. What does not fit stays with the lanes.
constexpr std::size_t kRingBytes = 1 << 20;

}  // namespace

std::vector<std::byte> block_bytes(BlockKind kind, std::uint64_t sequence, std::span<const std::byte> content) {
  BlockHeader header{static_cast<std::uint32_t>(content.size()), kind, sequence, crc32c(content), 0};
  header.own_crc = crc32c(std::as_bytes(std::span(&header, 1)).first(kOwnCrcAt));
  const auto head = std::as_bytes(std::span(&header, 1));
  std::vector<std::byte> bytes(head.begin(), head.end());
  bytes.insert(bytes.end(), content.begin(), content.end());
  return bytes;
}

std::vector<std::byte> file_begin() {
  const auto magic = std::as_bytes(std::span(kInputLogMagic));
  std::vector<std::byte> bytes(magic.begin(), magic.end());
  const auto version = std::as_bytes(std::span(&kInputLogVersion, 1));
  bytes.insert(bytes.end(), version.begin(), version.end());
  return bytes;
}

Result<std::unique_ptr<InputLogWriter>> InputLogWriter::create(const std::string& path, const InputLogHead& head,
                                                               const std::vector<EmbeddedFile>& files) {
  constexpr int kHow = O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC;
  int file = ::open(path.c_str(), kHow | O_EXCL, 0666);
  const bool is_new = file >= 0;
  struct stat status {};
  if (file < 0 && errno == EEXIST) {
    if (::stat(path.c_str(), &status) == 0 && S_ISREG(status.st_mode))
      return Failure(std::string("exists already; a recording is never overwritten: give another name, or remove it"));
    file = ::open(path.c_str(), kHow, 0666);
  }
  if (file < 0) return Failure(fmt::format("cannot be written: {}", std::strerror(errno)));
  std::unique_ptr<InputLogWriter> writer(new InputLogWriter(path, file));
  writer->is_new_ = is_new;
  std::vector<std::byte> content;
  encode(head, content);
  writer->next_block(BlockKind::head, content);
  const std::vector<std::byte> begin = file_begin();
  writer->pending_.insert(writer->pending_.begin(), begin.begin(), begin.end());
  for (const EmbeddedFile& embedded : files) {
    for (const FilePiece& piece : pieces_of(embedded.index, embedded.content)) {
      content.clear();
      encode(piece, content);
      const std::vector<std::byte> block = block_bytes(BlockKind::file, writer->sequence_++, content);
      writer->pending_.insert(writer->pending_.end(), block.begin(), block.end());
    }
  }
  writer->write_pending();  // if the disk is full now, it may not be later
  writer->thread_ = std::make_unique<LaneThread>([self = writer.get()] { self->loop(); });
  return writer;
}

InputLogWriter::InputLogWriter(std::string path, int file)
    : path_(std::move(path)),
      file_(file),
      device_ring_(kRingBytes),
      simulation_ring_(kRingBytes),
      clock_(WallEpoch::in(Duration{0}), Duration{0}) {}

InputLogWriter::~InputLogWriter() {
  stop();
  ::close(file_);
  if (is_new_ && blocks_kept() <= 1) ::unlink(path_.c_str());
}

bool InputLogWriter::offer(BlockKind lane, std::span<const std::byte> content) {
  return (lane == BlockKind::device ? device_ring_ : simulation_ring_).push(content);
}

void InputLogWriter::stop() {
  if (!thread_) return;
  ending_.store(true, std::memory_order_release);
  thread_.reset();  // joins
  take_from_rings();
}

bool InputLogWriter::write_now(BlockKind kind, std::span<const std::byte> content) {
  if (!write_pending()) return false;
  next_block(kind, content);
  return write_pending();
}

std::string InputLogWriter::finish() {
  if (write_pending()) flush_to_disk();
  return write_error_.empty() ? disk_error_ : write_error_;
}

void InputLogWriter::loop() {
  while (!ending_.load(std::memory_order_acquire)) {
    clock_.wait_until(clock_.now() + kLook);
    take_from_rings();
    if (dirty_ && clock_.now() - flushed_ >= kFlush) flush_to_disk();
  }
}

void InputLogWriter::take_from_rings() {
  for (const auto& [ring, kind] :
       {std::pair(&device_ring_, BlockKind::device), {&simulation_ring_, BlockKind::simulation}}) {
    while (write_pending() && ring->pop(message_)) next_block(kind, message_);
  }
  write_pending();
}

/// Only when nothing is pending.
void InputLogWriter::next_block(BlockKind kind, std::span<const std::byte> content) {
  pending_ = block_bytes(kind, sequence_++, content);
  sent_ = 0;
}

/// True if nothing is pending any more. A block that was written in part is continued where it ended.
bool InputLogWriter::write_pending() {
  if (pending_.empty()) return true;
  while (sent_ < pending_.size()) {
    const ssize_t count = ::write(file_, pending_.data() + sent_, pending_.size() - sent_);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      write_error_ = count < 0 ? std::strerror(errno) : "nothing can be written";
      return false;
    }
    sent_ += static_cast<std::size_t>(count);
  }
  pending_ = {};  // the first one may have files in it
  write_error_.clear();
  dirty_ = true;
  blocks_kept_.fetch_add(1, std::memory_order_release);
  return true;
}

void InputLogWriter::flush_to_disk() {
  // EINVAL, EROFS: a pipe or a device, which has no disk.
  if (::fdatasync(file_) != 0 && errno != EINVAL && errno != EROFS) disk_error_ = std::strerror(errno);
  dirty_ = false;
  flushed_ = clock_.now();
}

}  // namespace evenstep::internal
