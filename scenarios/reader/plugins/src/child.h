#pragma once
/// A process of our own, fed and heard through its three standard streams.

#include <sys/types.h>

#include <string>
#include <string_view>
#include <vector>

#include "evenstep/time/time.h"

namespace evenstep::internal {

/// A file descriptor that is closed when it is no longer used.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(other.number_) { other.number_ = -1; }
  Descriptor& operator=(Descriptor&& other) noexcept;
  ~Descriptor() { close(); }
  void close();
  int number() const { return number_; }

 private:
  int number_ = -1;
};

/// Any function may throw std::runtime_error, which says what the process did instead, its exit status, and the last line of
/// its standard error. From then on the process only waits to be ended.
class Child {
 public:
  /// Starts `program` with these words (the first is its name) in `folder`. `shown_as` is put before each line of its
  /// standard error in the log. No answer may take longer than `limit`.
  Child(const std::string& program, const std::vector<std::string>& words, const std::string& folder, std::string shown_as,
        Duration limit);
  /// Closes its input, gives it a second to end, and kills what is left of its group.
  ~Child();
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// Sends `bytes`, and waits for a line of at most `most` bytes, which is returned without its end.
  std::string ask_line(std::string_view bytes, std::size_t most);
  /// Sends `bytes`, and waits for `size` bytes.
  std::string ask(std::string_view bytes, std::size_t size);
  /// `what` with the last line of its standard error.
  std::string with_last_error(const std::string& what);

 private:
  enum class Heard { enough, closed, nothing };
  template <class Enough>
  Heard hear(std::string_view bytes, Enough enough);
  void send_some(std::string_view& bytes);
  bool read_some();
  void read_errors();
  void take_error_lines(bool all);
  bool has_ended(double wait_s);
  [[noreturn]] void fail(const std::string& what);
  std::string how_it_ended();

  std::string shown_as_;
  Duration limit_;
  pid_t process_ = -1, watcher_ = -1;
  Descriptor in_, out_, err_, life_;
  std::string heard_;                   // of its standard output, not yet returned
  std::string error_text_, last_line_;  // of its standard error: the rest that has no line end, the last whole line
  int lines_shown_ = 0;
  bool failed_ = false;
};

}  // namespace evenstep::internal
