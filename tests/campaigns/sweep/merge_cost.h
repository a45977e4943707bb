#pragma once
// What a merge costs, compared with sha256sum of the same files, in the same run on the same machine. Times on a shared
// machine mean little, but their ratio means more.

#include <fmt/format.h>
#include <sys/resource.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>

#include "catch.h"

namespace evenstep::test {

struct Cost {
  double cpu_s = 0, wall_s = 0;
};

/// The cost of work in this process (RUSAGE_SELF) or in processes that it starts (RUSAGE_CHILDREN).
inline Cost cost_of(decltype(RUSAGE_SELF) who, const std::function<void()>& work) {
  const auto cpu = [who] {
    rusage used{};
    ::getrusage(who, &used);
    const auto seconds = [](const timeval& time) {
      return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
    };
    return seconds(used.ru_utime) + seconds(used.ru_stime);
  };
  const double cpu_before = cpu();
  const auto before = std::chrono::steady_clock::now();
  work();
  return {cpu() - cpu_before, std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count()};
}

/// Prints what the merge of the parts below `folder` costs, and checks how much memory this process has taken.
inline void report_merge(const std::string& folder, const std::string& out, double millions,
                         const std::function<void()>& merge) {
  const std::string command = fmt::format("find '{}' -name '*-of-*.jsonl' -exec cat {{}} + | sha256sum >/dev/null", folder);
  const Cost yardstick = cost_of(RUSAGE_CHILDREN, [&] { REQUIRE(std::system(command.c_str()) == 0); });
  const Cost cost = cost_of(RUSAGE_SELF, merge);
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  CHECK(used.ru_maxrss < 512 * 1024);  // kilobytes
  REQUIRE(yardstick.cpu_s > 0);
  WARN(fmt::format(
      "a million: {:.1f} s of processor time, {:.1f} s in all; cat | sha256sum of the same files {:.2f} s, {:.2f} s; ratio "
      "{:.1f}, {:.1f}; {} MB in the file, at most {} MB of memory",
      cost.cpu_s / millions, cost.wall_s / millions, yardstick.cpu_s / millions, yardstick.wall_s / millions,
      cost.cpu_s / yardstick.cpu_s, cost.wall_s / yardstick.wall_s, std::filesystem::file_size(out) / 1'000'000,
      used.ru_maxrss / 1024));
}

}  // namespace evenstep::test
