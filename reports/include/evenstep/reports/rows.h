#pragma once
/// Columns of a record that may be larger than the memory: a vector whose elements, once there is a mebibyte of them, are in
/// a file that has no name (RowFiles). Without RowFiles it is a vector like any other; what is in it is the same either way.

#include <cstddef>
#include <memory>
#include <new>
#include <string>
#include <vector>

namespace evenstep {

/// Makes the files, in one folder, and sees to it that little of them is in memory at a time: a thread looks 200 times a
/// second, and gives all pages back if there are more than 32 MiB of them. They stay in the files, or in what the system
/// caches of files, and are read again when they are used. A file is gone with its rows, also if the process is killed.
///
/// Thread-safe. A folder without room, or one that cannot be written, is a RunFailure (reason "disk") with the remedy.
class RowFiles {
 public:
  explicit RowFiles(std::string folder);
  ~RowFiles();
  RowFiles(const RowFiles&) = delete;
  RowFiles& operator=(const RowFiles&) = delete;

  /// Memory for `bytes` bytes; the space is taken from the disk at once, so that no later write can fail.
  void* map(std::size_t bytes);
  void unmap(void* at, std::size_t bytes) noexcept;

 private:
  class Mappings;
  std::string folder_;
  std::unique_ptr<Mappings> mappings_;
};

template <class T>
class RowAllocator {
 public:
  using value_type = T;
  using propagate_on_container_copy_assignment = std::true_type;
  using propagate_on_container_move_assignment = std::true_type;
  using propagate_on_container_swap = std::true_type;

  RowAllocator() = default;
  RowAllocator(std::shared_ptr<RowFiles> files) : files_(std::move(files)) {}
  template <class Other>
  RowAllocator(const RowAllocator<Other>& other) : files_(other.files()) {}

  T* allocate(std::size_t count) {
    if (!in_file(count)) return std::allocator<T>().allocate(count);
    return static_cast<T*>(files_->map(count * sizeof(T)));  // in_file: no overflow
  }
  void deallocate(T* at, std::size_t count) noexcept {
    if (in_file(count))
      files_->unmap(at, count * sizeof(T));
    else
      std::allocator<T>().deallocate(at, count);
  }
  const std::shared_ptr<RowFiles>& files() const { return files_; }
  friend bool operator==(const RowAllocator& a, const RowAllocator& b) { return a.files_ == b.files_; }

 private:
  static constexpr std::size_t kLeastBytes = 1 << 20;
  bool in_file(std::size_t count) const {
    return files_ && count >= kLeastBytes / sizeof(T) && count <= PTRDIFF_MAX / sizeof(T);
  }
  std::shared_ptr<RowFiles> files_;
};

template <class T>
using Rows = std::vector<T, RowAllocator<T>>;

}  // namespace evenstep
