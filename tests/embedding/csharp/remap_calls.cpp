/// remap_calls COUNT [PLANT] : random calls of evenstep_remap.h and what they gave, for wrapper_test.cs, which makes the
/// same calls from C#. Every number is written by the name of its field and read by its name in C#, so fields that are not
/// in the same place differ. Every second remap has a clock of its own. With PLANT a bit of the last number is wrong.

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "remap/c/random_calls.h"

using namespace evenstep;
using namespace evenstep::testing;

namespace {

/// The stream, in the byte order of the machine.
std::string bytes;

template <class... Numbers>
void put(const Numbers&... numbers) {
  const auto one = [](const auto& number) { bytes.append(reinterpret_cast<const char*>(&number), sizeof number); };
  (one(numbers), ...);
}

void must(int code) {
  if (code != EVENSTEP_REMAP_OK) throw std::runtime_error(evenstep_remap_last_error());
}

void put_options(const evenstep_remap_options& o) {
  put(o.components, o.lead_ns, o.latency_ns, o.emission, o.adapts, o.bandwidth_Hz, o.sample_capacity, o.force_capacity);
  put(o.sample_window_ns, o.sample_furthest_ns, o.force_window_ns, o.force_furthest_ns);
  put(o.adapt_start_ns, o.adapt_least_ns, o.adapt_most_ns, o.adapt_window_ns, o.adapt_margin_ns, o.adapt_slew_ppm);
}

void put_counts(const evenstep_remap_counts& c) {
  put(c.steps, c.acquiring, c.late_forces, c.latest_force_ns);
  put(c.hand_inside, c.hand_held, c.hand_extrapolated, c.hand_overruns, c.hand_empty);
  put(c.force_inside, c.force_held, c.force_extrapolated, c.force_overruns, c.force_empty);
}

/// Makes the call, and writes it with its answer. `simulated_ns` is the time of a step of a remap with a clock.
void play(evenstep_remap* remap, remap_c_call& call, std::uint32_t components, bool clocked, std::int64_t simulated_ns) {
  const auto values = [&] {
    for (std::uint32_t i = 0; i < components; ++i) put(call.value[i]);
  };
  put(static_cast<std::int32_t>(call.what), call.at_ns);
  switch (call.what) {
    case REMAP_C_SAMPLE:
      values();
      return must(evenstep_remap_sample(remap, call.at_ns, call.value));
    case REMAP_C_FORCE:
      must(evenstep_remap_force(remap, call.at_ns, call.value, &call.status));
      values();
      return put(call.status);
    case REMAP_C_SEGMENT:
      return must(evenstep_remap_segment(remap, call.at_ns));
    case REMAP_C_BEGIN_STEP: {
      evenstep_remap_read read;
      read.struct_size = sizeof read;
      must(clocked ? evenstep_remap_begin_step_at(remap, call.at_ns, simulated_ns, call.value, &read)
                   : evenstep_remap_begin_step(remap, call.at_ns, call.value, &read));
      put(simulated_ns);
      values();
      return put(read.status, read.read_ns, read.newest_ns, read.has_slot);
    }
    default:
      values();
      must(evenstep_remap_end_step(remap, call.at_ns, call.value, &call.time_ns));
      return put(call.time_ns);
  }
}

void play_all(std::uint64_t seed, const evenstep_remap_options& defaults) {
  Draw draw(seed);
  const evenstep_remap_options options = random_options(defaults, draw);
  std::vector<remap_c_call> calls = calls_of(random_schedule(draw, 20), draw);
  const bool clocked = seed % 2 == 1;
  evenstep_remap_clock clock{.struct_size = sizeof clock,
                             .reserved = 0,
                             .steps = draw.between(10, 1'000),
                             .seconds = draw.between(1, 3),
                             .dropped_jump_ns = draw.between(0, 1) * draw.between(1, 1'000'000)};
  evenstep_remap* remap = nullptr;
  must(clocked ? evenstep_remap_create_clocked(&options, &clock, &remap) : evenstep_remap_create(&options, &remap));
  put(static_cast<std::int32_t>(clocked));
  put_options(options);
  put(clock.steps, clock.seconds, clock.dropped_jump_ns, static_cast<std::int32_t>(calls.size()));
  std::int64_t n = 0;
  for (remap_c_call& call : calls) {
    if (call.what == REMAP_C_BEGIN_STEP) n += 1 + (draw.between(0, 20) == 0);  // now and then a step is dropped
    play(remap, call, options.components, clocked, sim_time({clock.steps, clock.seconds}, n).ns);
  }
  evenstep_remap_counts counts;
  counts.struct_size = sizeof counts;
  must(evenstep_remap_get_counts(remap, &counts));
  put_counts(counts);
  evenstep_remap_destroy(remap);
}

}  // namespace

int main(int count_of_words, char** words) try {
  if (count_of_words < 2) throw std::runtime_error("usage: remap_calls COUNT [PLANT]");
  const std::int32_t runs = std::atoi(words[1]);
  evenstep_remap_options defaults;
  must(evenstep_remap_options_init(&defaults, sizeof defaults));
  put_options(defaults);
  put(runs);
  for (std::int32_t seed = 0; seed < runs; ++seed) {
    play_all(static_cast<std::uint64_t>(seed), defaults);
    if (count_of_words > 2 && seed == runs - 1) bytes[bytes.size() - sizeof(std::uint64_t)] ^= 1;
    if (std::fwrite(bytes.data(), 1, bytes.size(), stdout) != bytes.size()) throw std::runtime_error("nobody reads this");
    bytes.clear();
  }
  return std::fflush(stdout) == 0 ? 0 : 3;
} catch (const std::exception& error) {
  std::fprintf(stderr, "remap_calls: %s\n", error.what());
  return 3;
}
