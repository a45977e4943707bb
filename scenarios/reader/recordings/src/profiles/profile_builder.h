#pragma once
/// What every reader of a profiler's file fills: it keeps the names once, counts what is left out, and holds the limits.

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "evenstep/recordings/profile.h"

namespace evenstep::internal {

inline constexpr std::size_t kMostIntervals = 10'000'000;
inline constexpr std::size_t kMostNames = 1'000'000;
inline constexpr std::size_t kMostNameBytes = std::size_t{64} << 20;
inline constexpr std::size_t kLongestName = 1000;

class ProfileBuilder {
 public:
  explicit ProfileBuilder(std::string file) { profile_.file = std::move(file); }

  Profile& profile() { return profile_; }
  std::uint32_t name(std::string_view text, std::string_view category);
  std::uint32_t source(std::string_view text);
  /// Leaves it out if it ends before it begins. Times are at most kFurthestTime_ns from zero.
  void add(std::uint32_t name, std::uint32_t source, std::int64_t begin_ns, std::int64_t end_ns);
  void leave_out(std::string_view what, std::string_view first);
  void fail(std::string message, std::int64_t line = 0, std::int64_t column = 0);
  /// A reader stops when this is set: after an error, or at a limit, which is an error too.
  bool failed() const { return !errors_.empty(); }

  ProfileResult finish();

 private:
  Profile profile_;
  std::map<std::pair<std::string, std::string>, std::uint32_t, std::less<>> names_;
  std::map<std::string, std::uint32_t, std::less<>> sources_;
  std::map<std::string, std::size_t, std::less<>> left_out_;
  std::size_t name_bytes_ = 0;
  std::vector<Diagnostic> errors_;
};

}  // namespace evenstep::internal
