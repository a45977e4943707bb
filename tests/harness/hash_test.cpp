// The trace hash: the same for the same scenario and seed, whatever the host does.

#include <set>

#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

std::uint64_t hash_of(std::vector<std::string> set, RunOptions options = {}) {
  set.push_back("expect=[]");
  return run_all(read("paper/figure-1.toml", set), options).trace_hash;
}

}  // namespace

TEST_CASE("tissue: the hash does not depend on solver, threads, worker or work-group size", "[sweep]") {
  const std::uint64_t reference = hash_of(small_tissue("cpu"));
  CHECK(hash_of(small_tissue("cpu")) == reference);
  CHECK(hash_of(small_tissue("opencl")) == reference);
  for (const char* size : {"8", "64", "256"}) {
    auto set = small_tissue("opencl");
    set.push_back(std::string("scene.work_group_size=") + size);
    CHECK(hash_of(set) == reference);
  }
  for (const int threads : {1, 2, 4}) {
    RunOptions options;
    options.threads = threads;
    CHECK(hash_of(small_tissue("opencl"), options) == reference);
  }
  RunOptions worker;
  worker.control.worker_thread = true;
  CHECK(hash_of(small_tissue("opencl"), worker) == reference);
  CHECK(hash_of(small_tissue("cpu-double")) != reference);  // other arithmetic gives another hash
}

TEST_CASE("with jitter the hash is that of the seed") {
  const std::string jitter = "timing.jitter={ visualization = \"lognormal 10 %\", step = \"lognormal 10 %\" }";
  std::set<std::uint64_t> hashes;
  for (const char* seed : {"1", "2", "3"}) {
    const std::vector<std::string> set{jitter, std::string("run.seed=") + seed, "expect=[]", "run.duration=\"1 s\""};
    const std::uint64_t first = run_all(read("paper/figure-1-spring.toml", set)).trace_hash;
    CHECK(run_all(read("paper/figure-1-spring.toml", set)).trace_hash == first);
    hashes.insert(first);
  }
  CHECK(hashes.size() == 3);
}

TEST_CASE("a hand a few nanometres away changes the hash") {
  const std::uint64_t reference =
      run_all(read("paper/figure-1-spring.toml", {"expect=[]", "run.duration=\"0.4 s\""})).trace_hash;
  const std::uint64_t other =
      run_all(read("paper/figure-1-spring.toml", {"expect=[]", "run.duration=\"0.4 s\"",
                                                  "device.left.motion.velocity=[\"0.1 m/s\", \"0 m/s\", \"20 um/s\"]"}))
          .trace_hash;
  CHECK(reference != other);
}

TEST_CASE("permuting the order of simultaneous events keeps every expectation") {
  for (const std::uint64_t seed : {1ULL, 2ULL, 3ULL, 4ULL, 5ULL}) {
    RunOptions options;
    options.control.permute_ties = seed;
    for (const char* file : {"paper/figure-1-spring.toml", "paper/ties.toml"})
      CHECK(run_scenario(read(file), options).exit == ExitCode::pass);
  }
}
