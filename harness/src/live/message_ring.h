#pragma once
// Messages from one thread to another one: bounded, lock-free, without a system call on either side. What does not fit is
// refused as a whole, so the writer never waits.

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace evenstep::internal {

class MessageRing {
 public:
  /// All of its memory is touched here, so that no later push meets a page fault.
  explicit MessageRing(std::size_t bytes) : ring_(bytes) {}

  /// One thread. False: there is no room now, and nothing was taken.
  bool push(std::span<const std::byte> message) {
    const std::uint64_t head = head_.load(std::memory_order_relaxed);
    const std::size_t used = static_cast<std::size_t>(head - tail_.load(std::memory_order_acquire));
    if (ring_.size() - used < sizeof(Length) + message.size()) return false;
    const auto length = static_cast<Length>(message.size());
    put(head, std::as_bytes(std::span(&length, 1)));
    put(head + sizeof(Length), message);
    head_.store(head + sizeof(Length) + message.size(), std::memory_order_release);
    return true;
  }

  /// The other thread. False: there is none.
  bool pop(std::vector<std::byte>& message) {
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    if (head_.load(std::memory_order_acquire) == tail) return false;
    Length length = 0;
    get(tail, std::as_writable_bytes(std::span(&length, 1)));
    message.resize(length);
    get(tail + sizeof(Length), message);
    tail_.store(tail + sizeof(Length) + length, std::memory_order_release);
    return true;
  }

 private:
  using Length = std::uint32_t;

  void put(std::uint64_t at, std::span<const std::byte> bytes) {
    const std::size_t begin = static_cast<std::size_t>(at % ring_.size());
    const std::size_t before_end = std::min(bytes.size(), ring_.size() - begin);
    if (before_end > 0) std::memcpy(ring_.data() + begin, bytes.data(), before_end);
    if (before_end < bytes.size()) std::memcpy(ring_.data(), bytes.data() + before_end, bytes.size() - before_end);
  }
  void get(std::uint64_t at, std::span<std::byte> bytes) const {
    const std::size_t begin = static_cast<std::size_t>(at % ring_.size());
    const std::size_t before_end = std::min(bytes.size(), ring_.size() - begin);
    if (before_end > 0) std::memcpy(bytes.data(), ring_.data() + begin, before_end);
    if (before_end < bytes.size()) std::memcpy(bytes.data() + before_end, ring_.data(), bytes.size() - before_end);
  }

  std::vector<std::byte> ring_;
  alignas(64) std::atomic<std::uint64_t> head_{0};  ///< bytes ever pushed
  alignas(64) std::atomic<std::uint64_t> tail_{0};  ///< bytes ever popped
};

}  // namespace evenstep::internal
