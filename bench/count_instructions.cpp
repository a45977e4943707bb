// Runs one core path under valgrind, which counts the instructions between entering and leaving measured():
//   valgrind --tool=callgrind --collect-atstart=no --toggle-collect=measured build/bench/count_instructions NAME
// Without a name it lists the paths. --passages prints how often measured() takes the path.
#include <cstdio>
#include <cstring>

#include "core_paths.h"

using evenstep::bench::CorePath;

constexpr int kPassages = 5'000;

extern "C" [[gnu::noinline]] void measured(CorePath& path) { path.run(kPassages); }

int main(int argc, char** argv) {
  if (argc != 2) {
    for (const std::string& name : evenstep::bench::core_path_names()) std::puts(name.c_str());
    return 0;
  }
  if (std::strcmp(argv[1], "--passages") == 0) return std::printf("%d\n", kPassages) < 0;
  const auto path = evenstep::bench::make_core_path(argv[1]);
  if (!path) return 2;
  path->run(kPassages);  // the first use grows memory and binds shared libraries
  measured(*path);
}
