#pragma once
/// Forks. What runs between fork and exec may only make calls that are safe in a signal handler: another thread may have
/// held any lock at the fork.

#include <sys/types.h>

#include <string>
#include <vector>

namespace evenstep::internal {

/// The ends of the pipes that the process gets as its standard streams, and where it tells the watcher its group.
struct ChildEnds {
  int in, out, err, life;
};

/// Starts the watcher: a process that waits until nobody holds the other end of `life` any more, which happens however
/// this program ends, and then kills the group whose number it was told. -1, and errno, if it cannot.
pid_t start_watcher(int life);

/// Starts `program`. Returns when it runs; -1, and errno, if it does not.
pid_t start_program(const std::string& program, const std::vector<std::string>& words, const std::string& folder,
                    const ChildEnds& ends);

}  // namespace evenstep::internal
