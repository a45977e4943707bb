#pragma once
/// What the kernel has logged since a moment.

#include <fcntl.h>
#include <unistd.h>

#include <string>

class KernelLog {
 public:
  KernelLog() : fd_(open("/dev/kmsg", O_RDONLY | O_NONBLOCK | O_CLOEXEC)) { lseek(fd_, 0, SEEK_END); }
  ~KernelLog() { close(fd_); }
  KernelLog(const KernelLog&) = delete;
  KernelLog& operator=(const KernelLog&) = delete;

  /// All lines since it was made or last asked.
  std::string said() const {
    std::string lines;
    char record[8192];
    for (ssize_t size = 0; (size = read(fd_, record, sizeof record)) > 0;)
      lines.append(record, static_cast<std::size_t>(size));
    return lines;
  }

 private:
  int fd_;
};
