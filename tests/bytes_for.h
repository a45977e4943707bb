#pragma once
// How much memory something needs, measured in a process of its own. Not with sanitizers, whose allocators keep what was
// freed.

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdint>

#include "catch.h"

namespace evenstep::test {

/// The most memory that a separate process needs for this work, which returns whether it succeeded: it must. It begins with
/// what this process has.
template <class Work>
std::int64_t bytes_for(Work work) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(work() ? 0 : 1);
  int status = 0;
  rusage used{};
  REQUIRE(::wait4(child, &status, 0, &used) == child);
  REQUIRE((WIFEXITED(status) && WEXITSTATUS(status) == 0));
  return used.ru_maxrss * std::int64_t{1024};
}

}  // namespace evenstep::test
