// Any bytes as a profiler's file, with the roles that are guessed and with some that match everything.
#include "evenstep/recordings/roles.h"
#include "evenstep/recordings/timing_csv.h"
#include "property.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

/// An error is about the whole file or has a place. (A database has no lines.)
void require_read_or_said(bool read, const std::vector<Diagnostic>& errors) {
  require(read == errors.empty(), "neither read nor refused");
  for (const Diagnostic& error : errors) require(!error.message.empty(), "an error without words");
}

void require_sound(const Profile& profile) {
  require(!profile.intervals.empty(), "a profile has no interval");
  RealTime last{INT64_MIN};
  std::vector<std::vector<ProfileInterval>> open(profile.tracks.size());
  for (const ProfileInterval& interval : profile.intervals) {
    require(interval.begin <= interval.end && interval.begin >= last, "intervals are not in order");
    require(interval.name < profile.names.size() && interval.track < profile.tracks.size() &&
                profile.source_of(interval) < profile.sources.size(),
            "an index is past its list");
    last = interval.begin;
    // On a queue they follow each other; in a thread they nest. Those that begin together do neither.
    const TrackOrder order = profile.tracks[interval.track].order;
    std::vector<ProfileInterval>& running = open[interval.track];
    std::erase_if(running, [&](const ProfileInterval& one) { return one.end <= interval.begin; });
    for (const ProfileInterval& one : running)
      require(
          order == TrackOrder::any || one.begin == interval.begin || (order == TrackOrder::nest && interval.end <= one.end),
          "an interval runs over the next begin of its track");
    if (order != TrackOrder::any && running.size() < 100) running.push_back(interval);
  }
}

/// The assigned roles make a recording that timing.csv can hold.
void require_recording(const Profile& profile, const Roles& roles) {
  const AssignedRolesResult assigned = assign_roles(profile, roles);
  require_read_or_said(assigned.ok(), assigned.error_or({}));
  if (!assigned) return;
  const std::string csv = format_timing_csv(assigned->segments);
  const TimingCsv read = parse_timing_csv(csv, "timing.csv");
  require(read.ok() && format_timing_csv(*read) == csv, "what was assigned does not read back");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  // No reader is hurt by what is not for it, or by any line as the header.
  for (const std::string& format : profile_formats()) {
    const ProfileResult forced = parse_profile(bytes, "profile", {format, {}, size == 0 ? 0 : data[0] % 4});
    require_read_or_said(forced.ok(), forced.error_or({}));
    if (forced) require_sound(*forced);
  }
  const ProfileResult profile = parse_profile(bytes, "profile");
  require_read_or_said(profile.ok(), profile.error_or({}));
  if (!profile) return 0;
  require_sound(*profile);
  Roles everything, segments, pictures;
  everything.step = ".";
  segments.segment = segments.step = ".";
  pictures.visualization = ".";
  pictures.steps = 3;
  pictures.step_time = {1000};
  for (const Roles& roles : {Roles{}, everything, segments, pictures}) require_recording(*profile, roles);
  return 0;
}
