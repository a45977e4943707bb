#pragma once
/// The coroutine of a lane. g++ 12 forces these rules on it (tests/scheduler/coroutine_rules_test.cpp shows each):
///   - coroutines are free functions; never capturing lambdas
///   - `co_await` is a whole statement or the initialiser of a variable; never inside ?:, && or an argument list
///   - awaitables and their arguments are trivially copyable (static_assert in scheduler.h)

#include <coroutine>
#include <exception>
#include <utility>

namespace evenstep {

class Scheduler;

/// Owns a coroutine that starts suspended, to be passed to Scheduler::spawn. Destroying an unfinished task destroys its
/// frame.
class [[nodiscard]] Task {
 public:
  struct promise_type {
    std::exception_ptr failure;
    Task get_return_object() { return Task{std::coroutine_handle<promise_type>::from_promise(*this)}; }
    std::suspend_always initial_suspend() noexcept { return {}; }
    std::suspend_always final_suspend() noexcept { return {}; }
    void return_void() noexcept {}
    void unhandled_exception() noexcept { failure = std::current_exception(); }
  };

  Task(Task&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  Task& operator=(Task&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Task() {
    if (handle_) handle_.destroy();
  }

 private:
  friend class Scheduler;
  explicit Task(std::coroutine_handle<promise_type> handle) : handle_(handle) {}
  std::coroutine_handle<promise_type> handle_;
};

}  // namespace evenstep
