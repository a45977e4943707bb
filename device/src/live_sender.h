#pragma once
/// The thread that writes to a real device, so that no caller waits for the cable, and that looks for the device when it was
/// unplugged. Waiting items are sent in the order of the calls; a newer force takes the place of one that still waits.
///
/// `Item` is what is sent; its member `bool newest` says that a later item may take its place. `Handle` is what the reading
/// thread needs once the device is back.

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/device/hid/hid_transport.h"
#include "evenstep/device/looked_for.h"
#include "evenstep/device/write_times.h"

namespace evenstep::internal {

enum class Presence { here, away, gone };

template <class Item, class Handle>
class LiveSender {
 public:
  /// What the thread does; it alone calls these.
  class Cable {
   public:
    virtual ~Cable() = default;
    /// May take as long as the device does.
    virtual HidWrite send(const Item& item) = 0;
    /// Opens the device if it is back; empty: not yet.
    virtual std::optional<Handle> find() = 0;
  };

  /// A device that was unplugged is looked for four times a second for `patience`; 0: it is gone at once. The cable must
  /// outlive the sender.
  LiveSender(const WallClock& clock, Duration patience, Cable& cable)
      : clock_(clock), patience_(patience), cable_(cable), waiting_(kMostWaiting), thread_([this] { run(); }) {}
  /// First goes on, for at most a second, sending what waits.
  ~LiveSender() {
    {
      const std::lock_guard lock(mutex_);
      closing_ = true;
      closed_at_ = clock_.now();
    }
    work_.notify_one();
    thread_.join();
  }
  LiveSender(const LiveSender&) = delete;
  LiveSender& operator=(const LiveSender&) = delete;

  /// Queues what `fill` writes into an Item. If it is `newest` it takes the place of a waiting one for which `same` holds.
  /// `rejected`: the queue is full, or the device is away.
  template <class Same, class Fill>
  HidWrite put(bool newest, Same same, Fill fill) {
    const std::lock_guard lock(mutex_);
    if (presence_ == Presence::gone) return HidWrite::gone;
    Item* slot = nullptr;
    // Searches from the back, up to the first item that must keep its place, so that no item is moved ahead of it.
    for (std::size_t i = count_; newest && i > 0 && !slot; --i) {
      Item& other = waiting_[(first_ + i - 1) % kMostWaiting];
      if (!other.newest) break;
      if (same(std::as_const(other))) slot = &other;
    }
    if (presence_ == Presence::away || (!slot && count_ == kMostWaiting)) {
      ++times_.rejected;
      return HidWrite::rejected;
    }
    if (slot) ++times_.overtaken;
    if (!slot) slot = &waiting_[(first_ + count_++) % kMostWaiting];
    fill(*slot);
    slot->newest = newest;
    work_.notify_one();
    return HidWrite::ok;
  }
  /// Counts something that is not even queued as rejected.
  HidWrite reject() {
    const std::lock_guard lock(mutex_);
    if (presence_ == Presence::gone) return HidWrite::gone;
    ++times_.rejected;
    return HidWrite::rejected;
  }

  Presence presence() const {
    const std::lock_guard lock(mutex_);
    return presence_;
  }
  /// What the reading thread goes on with; has a value once after each return of the device.
  std::optional<Handle> take_returned() {
    const std::lock_guard lock(mutex_);
    return std::exchange(returned_, std::nullopt);
  }
  /// The reading thread has noticed that the device is gone; with a return pending, it has only noticed the old handle.
  Presence lose() {
    const std::lock_guard lock(mutex_);
    if (!returned_) lose_device();
    return presence_;
  }
  void wait_until_sent(std::chrono::nanoseconds at_most) {
    std::unique_lock lock(mutex_);
    idle_.wait_for(lock, at_most, [&] { return (count_ == 0 && !sending_) || presence_ != Presence::here; });
  }
  /// Calls `call` and holds back what waits meanwhile; false: something is being sent, so it was not called.
  template <class Call>
  bool between_sends(Call call) {
    const std::lock_guard lock(mutex_);
    if (sending_) return false;
    call();
    return true;
  }

  /// How many items were taken by put() and refused afterwards.
  std::int64_t refused() const {
    const std::lock_guard lock(mutex_);
    return refused_;
  }
  WriteTimes times() const {
    const std::lock_guard lock(mutex_);
    return times_;
  }
  std::int64_t times_unplugged() const {
    const std::lock_guard lock(mutex_);
    return times_unplugged_;
  }

 private:
  /// The same as the kernel's queue of input reports: if more wait, the device has stopped accepting them.
  static constexpr std::size_t kMostWaiting = 64;
  /// How long the destructor waits for the queue to be sent.
  static constexpr Duration kFarewell{1'000'000'000};

  /// Call with the lock held.
  void lose_device() {
    if (presence_ != Presence::here) return;
    ++times_unplugged_;
    presence_ = patience_.ns > 0 ? Presence::away : Presence::gone;
    lost_at_ = clock_.now();
    times_.rejected += static_cast<std::int64_t>(std::exchange(count_, 0));
    work_.notify_one();
    idle_.notify_one();
  }

  void run() {
    std::unique_lock lock(mutex_);
    while (presence_ != Presence::gone) {
      work_.wait(lock, [&] { return count_ > 0 || closing_ || presence_ != Presence::here; });
      if (closing_ && (count_ == 0 || presence_ != Presence::here || clock_.now() > closed_at_ + kFarewell)) return;
      if (presence_ == Presence::here)
        send_one(lock);
      else
        look_for_device(lock);
    }
  }

  void send_one(std::unique_lock<std::mutex>& lock) {
    const Item item = waiting_[first_];
    first_ = (first_ + 1) % kMostWaiting;
    --count_;
    sending_ = true;
    lock.unlock();
    const RealTime began = clock_.now();
    const HidWrite result = cable_.send(item);
    const Duration taken = clock_.now() - began;
    lock.lock();
    sending_ = false;
    idle_.notify_one();
    times_.taken.add(taken);
    if (result == HidWrite::gone) lose_device();
    if (result == HidWrite::ok) return;
    ++times_.rejected;
    ++refused_;
  }

  void look_for_device(std::unique_lock<std::mutex>& lock) {
    if (clock_.now() > lost_at_ + patience_) {
      presence_ = Presence::gone;
      return;
    }
    lock.unlock();
    std::optional<Handle> found = cable_.find();
    lock.lock();
    if (found) {
      returned_ = std::move(found);
      presence_ = Presence::here;
    } else {
      work_.wait_for(lock, std::chrono::nanoseconds(kLookAgain.ns), [&] { return closing_; });
    }
  }

  const WallClock& clock_;
  const Duration patience_;
  Cable& cable_;

  mutable std::mutex mutex_;  // guards everything below
  std::condition_variable work_, idle_;
  std::vector<Item> waiting_;  // a ring of `count` from `first` on: nothing is allocated after the start
  std::size_t first_ = 0, count_ = 0;
  WriteTimes times_;
  std::int64_t refused_ = 0;
  bool sending_ = false, closing_ = false;
  Presence presence_ = Presence::here;
  RealTime lost_at_, closed_at_;
  std::int64_t times_unplugged_ = 0;
  std::optional<Handle> returned_;
  std::thread thread_;  // the last member, because it uses all others
};

}  // namespace evenstep::internal
