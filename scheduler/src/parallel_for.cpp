#include "evenstep/scheduler/parallel_for.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

namespace evenstep {

namespace {

std::size_t threads_for(std::size_t count, int threads) {
  const std::size_t wanted =
      threads > 0 ? static_cast<std::size_t>(threads) : std::max(1u, std::thread::hardware_concurrency());
  return std::min(wanted, count);
}

/// Runs `work` on this many threads, including the calling one; returns when all are done.
void run_threads(std::size_t threads, const std::function<void()>& work) {
  std::vector<std::jthread> others;
  for (std::size_t i = 1; i < threads; ++i) others.emplace_back(work);
  work();
}

/// The results that wait for their turn.
class InOrder {
 public:
  explicit InOrder(const std::function<bool(std::size_t, const std::string&)>& take) : take_(take) {}
  bool stopped() const { return stopped_; }

  void add(std::size_t index, std::string made, std::exception_ptr failure) {
    const std::lock_guard lock(mutex_);
    waiting_.emplace(index, Made{std::move(made), failure});
    for (auto due = waiting_.find(next_); due != waiting_.end() && !stopped_; due = waiting_.find(next_)) {
      hand_over(due->second);
      waiting_.erase(due);
      ++next_;
    }
  }
  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  struct Made {
    std::string text;
    std::exception_ptr failure;
  };
  void hand_over(const Made& made) {
    failure_ = made.failure;
    try {
      if (failure_ || !take_(next_, made.text)) stopped_ = true;
    } catch (...) {
      failure_ = std::current_exception();
      stopped_ = true;
    }
  }

  const std::function<bool(std::size_t, const std::string&)>& take_;
  std::mutex mutex_;
  std::map<std::size_t, Made> waiting_;
  std::size_t next_ = 0;
  std::exception_ptr failure_;
  std::atomic<bool> stopped_{false};
};

}  // namespace

void ordered_for(std::size_t count, int threads, const std::function<std::string(std::size_t)>& make,
                 const std::function<bool(std::size_t, const std::string&)>& take) {
  InOrder results(take);
  std::atomic<std::size_t> next{0};
  run_threads(threads_for(count, threads), [&] {
    for (std::size_t i = next++; i < count && !results.stopped(); i = next++) {
      std::string made;
      std::exception_ptr failure;
      try {
        made = make(i);
      } catch (...) {
        failure = std::current_exception();
      }
      results.add(i, std::move(made), failure);
    }
  });
  results.rethrow();
}

void parallel_for(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
  std::vector<std::exception_ptr> failures(count);
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        body(i);
      } catch (...) {
        failures[i] = std::current_exception();
      }
    }
  };
  run_threads(threads_for(count, threads), work);
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
}

}  // namespace evenstep
