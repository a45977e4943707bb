#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "evenstep/reports/rows.h"
#include "evenstep/reports/run_failure.h"
#include "evenstep/reports/run_record.h"

namespace evenstep {
namespace {

constexpr std::chrono::milliseconds kLook{5};
constexpr std::size_t kInMemory = 32 << 20;  // bytes of files that may stay in memory: pages given back must be read again

/// The bytes of files that this process has in memory now (proc(5), statm). SIZE_MAX, if the system does not say.
std::size_t mapped_in_memory() {
  std::ifstream statm("/proc/self/statm");
  std::size_t size = 0, resident = 0, shared = 0;
  if (!(statm >> size >> resident >> shared)) return SIZE_MAX;
  return shared * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

/// A file in the folder without a name (or whose name is already removed); -1 with errno.
int nameless_file(const std::string& folder) {
  const int file = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file >= 0 || (errno != EOPNOTSUPP && errno != EISDIR && errno != ENOENT)) return file;
  std::string name = folder + "/.evenstep-rows-XXXXXX";  // not every file system has nameless files
  const int named = ::mkostemp(name.data(), O_CLOEXEC);
  if (named >= 0) ::unlink(name.c_str());
  return named;
}

[[noreturn]] void fail(const std::string& folder, std::size_t bytes, int error) {
  throw RunFailure("disk",
                   fmt::format("no room for {} MiB of the record in '{}': {}", bytes >> 20, folder, std::strerror(error)),
                   "free some space, give a place on another disk with --out, or shorten the run", -1);
}

}  // namespace

/// All mappings, and the thread that gives their pages back.
class RowFiles::Mappings {
 public:
  Mappings() : thread_([this] { give_back(); }) {}
  ~Mappings() {
    {
      const std::lock_guard lock(mutex_);
      ending_ = true;
    }
    wake_.notify_one();
    thread_.join();
  }
  void add(void* at, std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    all_.emplace(reinterpret_cast<std::uintptr_t>(at), bytes);
    wake_.notify_one();
  }
  void remove(void* at) {
    const std::lock_guard lock(mutex_);
    all_.erase(reinterpret_cast<std::uintptr_t>(at));
  }

 private:
  /// On a shared mapping, MADV_DONTNEED drops pages from the process but loses no byte of the file.
  void give_back() {
    std::unique_lock lock(mutex_);
    while (!ending_) {
      if (all_.empty())
        wake_.wait(lock, [this] { return ending_ || !all_.empty(); });
      else
        wake_.wait_for(lock, kLook, [this] { return ending_; });
      if (all_.empty() || mapped_in_memory() < kInMemory) continue;
      for (const auto& [at, bytes] : all_) {
        void* const pages = reinterpret_cast<void*>(at);
        // Pages that a live run locked with the rest of its memory (mlockall) need not stay.
        if (::madvise(pages, bytes, MADV_DONTNEED) != 0 && errno == EINVAL && ::munlock(pages, bytes) == 0)
          ::madvise(pages, bytes, MADV_DONTNEED);
      }
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_;
  std::map<std::uintptr_t, std::size_t> all_;
  bool ending_ = false;
  std::thread thread_;
};

RowFiles::RowFiles(std::string folder) : folder_(std::move(folder)), mappings_(std::make_unique<Mappings>()) {}
RowFiles::~RowFiles() = default;

void* RowFiles::map(std::size_t bytes) {
  const int file = nameless_file(folder_);
  if (file < 0) fail(folder_, bytes, errno);
  const int full = ::posix_fallocate(file, 0, static_cast<off_t>(bytes));
  void* const at = full == 0 ? ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0) : MAP_FAILED;
  const int error = full == 0 ? errno : full;
  ::close(file);
  if (at == MAP_FAILED) fail(folder_, bytes, error);
  mappings_->add(at, bytes);
  return at;
}

void RowFiles::unmap(void* at, std::size_t bytes) noexcept {
  mappings_->remove(at);
  ::munmap(at, bytes);
}

StrategyRecord empty_record(const std::shared_ptr<RowFiles>& files) {
  StrategyRecord record;
  record.steps = Rows<StepRow>(files);
  record.segments = Rows<SegmentRow>(files);
  record.events = Rows<EventRow>(files);
  record.underruns = Rows<UnderrunRow>(files);
  record.twin_force_N = Rows<Vec3>(files);
  return record;
}

DeviceRecord empty_device_record(const std::shared_ptr<RowFiles>& files) {
  DeviceRecord record;
  record.steps = Rows<StepSample>(files);
  record.ticks = Rows<TickRow>(files);
  record.springs = Rows<SpringRow>(files);
  return record;
}

}  // namespace evenstep
