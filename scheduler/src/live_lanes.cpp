#include "evenstep/scheduler/live_lanes.h"

#include <condition_variable>
#include <exception>
#include <future>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace evenstep {

struct WorkerExecutor::State {
  const Clock& clock;
  std::mutex mutex;
  std::condition_variable started;
  std::condition_variable finished;
  std::vector<Completion*> waiting;  // guarded by mutex
  bool closing = false;              // guarded by mutex
  std::thread thread;

  explicit State(const Clock& c) : clock(c) {}

  void loop() {
    std::vector<Completion*> batch;  // swapped with `waiting`, so that neither allocates once it has grown
    for (;;) {
      {
        std::unique_lock lock(mutex);
        started.wait(lock, [this] { return closing || !waiting.empty(); });
        if (waiting.empty()) return;
        batch.swap(waiting);
      }
      for (Completion* completion : batch) run(*completion);
      batch.clear();
    }
  }

  void run(Completion& completion) {
    try {
      completion.work->run();
    } catch (...) {
      completion.failure = std::current_exception();
    }
    completion.stamp = clock.now();
    if (completion.home != nullptr) completion.home->completed(completion);
    {
      // `done` is set last: a thread that has seen it may destroy the completion, its scheduler and its clock.
      std::lock_guard lock(mutex);
      completion.done.store(true, std::memory_order_release);
    }
    finished.notify_all();
  }
};

WorkerExecutor::WorkerExecutor(const Clock& clock) : state_(std::make_unique<State>(clock)) {
  state_->thread = std::thread([state = state_.get()] { state->loop(); });
}

WorkerExecutor::WorkerExecutor(const Clock& clock, int fifo_priority) : state_(std::make_unique<State>(clock)) {
  std::promise<RealTimeGrant> granted;
  state_->thread = std::thread([state = state_.get(), fifo_priority, &granted] {
    const RealTimeRights rights(fifo_priority);
    granted.set_value(rights.grant());
    state->loop();
  });
  grant_ = granted.get_future().get();
}

WorkerExecutor::~WorkerExecutor() {
  {
    std::lock_guard lock(state_->mutex);
    state_->closing = true;
  }
  state_->started.notify_one();
  state_->thread.join();
}

void WorkerExecutor::start(Completion& completion) {
  {
    std::lock_guard lock(state_->mutex);
    state_->waiting.push_back(&completion);
  }
  state_->started.notify_one();
}

void WorkerExecutor::wait(Completion& completion) {
  std::unique_lock lock(state_->mutex);
  state_->finished.wait(lock, [&] { return completion.done.load(std::memory_order_acquire); });
}

struct LaneThread::State {
  std::function<void()> body;
  std::exception_ptr failure;
  std::thread thread;
};

LaneThread::LaneThread(std::function<void()> body) : state_(std::make_unique<State>()) {
  state_->body = std::move(body);
  state_->thread = std::thread([state = state_.get()] {
    try {
      state->body();
    } catch (...) {
      state->failure = std::current_exception();
    }
  });
}

LaneThread::~LaneThread() {
  if (state_->thread.joinable()) state_->thread.join();
}

void LaneThread::join() {
  if (state_->thread.joinable()) state_->thread.join();
  if (state_->failure) std::rethrow_exception(std::exchange(state_->failure, nullptr));
}

}  // namespace evenstep
