#pragma once
// What a profile has, as text that a test compares.

#include <string>

#include "catch.h"
#include "evenstep/recordings/profile.h"

namespace evenstep::test {

/// The first error; empty for a file that is read.
inline std::string refusal(const std::string& bytes) {
  const ProfileResult profile = parse_profile(bytes, "x");
  return profile ? "" : text(profile.error().front());
}

inline Profile profile_of(const std::string& bytes) {
  const ProfileResult profile = parse_profile(bytes, "x");
  INFO((profile ? "" : text(profile.error().front())) << "\n" << bytes.substr(0, 2000));
  REQUIRE(profile);
  return *profile;
}

/// "name begin end" of each interval.
inline std::string intervals_text(const Profile& profile, std::int64_t unit_ns) {
  std::string all;
  for (const ProfileInterval& one : profile.intervals)
    all += profile.names[one.name].text + " " + std::to_string(one.begin.ns / unit_ns) + " " +
           std::to_string(one.end.ns / unit_ns) + "\n";
  return all;
}
/// The same, or the first error.
inline std::string intervals_text(const ProfileResult& profile, std::int64_t unit_ns) {
  return profile ? intervals_text(*profile, unit_ns) : text(profile.error().front());
}

}  // namespace evenstep::test
