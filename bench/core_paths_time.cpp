// The time of one passage through each core path.
//   scripts/bench.sh paths
#include <benchmark/benchmark.h>

#include "core_paths.h"

int main(int argc, char** argv) {
  for (const std::string& name : evenstep::bench::core_path_names()) {
    benchmark::RegisterBenchmark(name.c_str(), [name](benchmark::State& state) {
      const auto path = evenstep::bench::make_core_path(name);
      constexpr std::int64_t kBatch = 1'000;
      while (state.KeepRunningBatch(kBatch)) path->run(kBatch);
    });
  }
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
