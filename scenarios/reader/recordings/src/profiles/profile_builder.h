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
inline constexpr std::size_t kMostTracks = 100'000;

class ProfileBuilder {
 public:
  explicit ProfileBuilder(std::string file) { profile_.file = std::move(file); }

  Profile& profile() { return profile_; }
  std::uint32_t name(std::string_view text, std::string_view category);
  std::uint32_t track(std::string_view source, std::string_view lane = "", TrackOrder order = TrackOrder::any);
  /// Leaves it out if it ends before it begins. Times are at most kFurthestTime_ns from zero.
  void add(std::uint32_t name, std::uint32_t track, std::int64_t begin_ns, std::int64_t end_ns);
  void leave_out(std::string_view what, std::string_view first, bool on_purpose = false, std::int64_t count = 1);
  /// As it is kept: without control characters, and not too long.
  static std::string shown(std::string_view text);
  void fail(std::string message, std::int64_t line = 0, std::int64_t column = 0);
  /// A reader stops when this is set: after an error, or at a limit, which is an error too.
  bool failed() const { return !errors_.empty(); }

  ProfileResult finish();

 private:
  std::uint32_t source(const std::string& text);

  Profile profile_;
  std::map<std::pair<std::string, std::string>, std::uint32_t, std::less<>> names_;
  std::map<std::string, std::uint32_t, std::less<>> sources_;
  std::map<std::pair<std::string, std::string>, std::uint32_t, std::less<>> tracks_[3];  ///< by order; source and lane
  std::map<std::string, std::size_t, std::less<>> left_out_;
  std::size_t name_bytes_ = 0;
  std::vector<Diagnostic> errors_;
};

/// What files owe and some do not keep: of equal intervals one is kept, and the ends that run over the next begin of their
/// track are clipped to it, as trace viewers do. The intervals are then in order of time.
/// Returns how many were there twice.
std::int64_t mend_tracks(Profile& profile);

}  // namespace evenstep::internal
