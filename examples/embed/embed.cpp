// The remap between a device thread and a simulation thread, with the timing of the paper: 30 times a second a visualization
// of 11.1 ms, and then 15 steps. The hand moves evenly, and what the steps read and the device plays must be even, too.
// `embed`: in programmed time, where every number is the same each time. `embed wall`: by std::chrono::steady_clock.
#include <evenstep/remap/remapper.h>
#include <evenstep/time/chrono.h>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <thread>
#include <vector>
using evenstep::duration, evenstep::RealTime;
using namespace std::chrono_literals;
constexpr double kVelocity_m_per_s = 0.1, kStiffness_N_per_m = 200;
constexpr int kSegments = 60, kSteps = 15, kTicks = 2000;
constexpr double kStep_m = kVelocity_m_per_s / (30 * kSteps);  // how far the hand moves in a slot

enum Order { ends, ticks, begins };  // which of two things at the same time is first
struct Time {                        // both threads count from the same start
  const bool wall;
  const std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  std::mutex mutex = {};
  std::condition_variable changed = {};
  std::pair<RealTime, Order> next[2] = {{{-2}, ends}, {{-1}, ends}};

  RealTime wait_until(int thread, RealTime at, Order order) {
    if (wall) std::this_thread::sleep_until(start + std::chrono::nanoseconds(at.ns));
    if (wall) return evenstep::real_time(std::chrono::steady_clock::now() - start);
    std::unique_lock lock(mutex);  // a thread goes on when the other has nothing to do before it
    next[thread] = {at, order};
    changed.notify_all();
    changed.wait(lock, [&] { return at == evenstep::kNever || next[thread] < next[1 - thread]; });
    return at;
  }
};

void device_thread(evenstep::Remapper<double>& remap, Time& time, std::vector<double>& felt_N) {
  for (int k = 0; k < kTicks; ++k) {
    const RealTime now = time.wait_until(0, RealTime{} + duration(1ms) * k, ticks);
    remap.sample(now, kVelocity_m_per_s * seconds(now));  // where a real device would be read
    felt_N.push_back(remap.force(now).value);             // and be sent this
  }
  if (!time.wall) time.wait_until(0, evenstep::kNever, ends);
}

void simulation_thread(evenstep::Remapper<double>& remap, Time& time, std::vector<double>& read_m) {
  for (int k = 0; k < kSegments; ++k) {
    const RealTime segment = evenstep::tick_time({30, 1}, k), end = evenstep::tick_time({30, 1}, k + 1);
    const RealTime first = segment + duration(11'100us);
    remap.segment(time.wait_until(1, segment, begins));  // here it would draw
    for (int i = 0; i < kSteps; ++i) {
      const auto at = [&](int step) { return RealTime{first.ns + (end - first).ns * step / kSteps}; };
      read_m.push_back(remap.begin_step(time.wait_until(1, at(i), begins)).hand.value);
      const double force_N = -kStiffness_N_per_m * read_m.back();  // and here it would compute
      remap.end_step(time.wait_until(1, at(i + 1), ends), force_N);
    }
  }
  if (!time.wall) time.wait_until(1, evenstep::kNever, ends);
}

double velocity_jump(const std::vector<double>& x, std::size_t from, double step) {
  double most = 0;
  for (std::size_t n = from + 2; n < x.size(); ++n) most = std::max(most, std::abs(x[n] - 2 * x[n - 1] + x[n - 2]));
  return most / step;
}

int main(int argc, char**) {
  Time time{.wall = argc > 1};
  evenstep::Remapper<double> remap({.lead = duration(261us), .latency = duration(15ms + 66us)});
  std::vector<double> read_m, felt_N;
  std::thread device(device_thread, std::ref(remap), std::ref(time), std::ref(felt_N));
  simulation_thread(remap, time, read_m);
  device.join();
  const double in = velocity_jump(read_m, 120, kStep_m), out = velocity_jump(felt_N, 270, kStiffness_N_per_m * kStep_m);
  const evenstep::RemapCounts counts = remap.counts();
  const int underruns = static_cast<int>(counts.hand.held), late = static_cast<int>(counts.late_forces);
  std::printf("velocity jump: %.2g step in, %.2g step out; %d underruns, %d late forces\n", in, out, underruns, late);
  return time.wall || (in < 1e-6 && out < 1e-6 && underruns == 0 && late == 0) ? 0 : 1;
}
