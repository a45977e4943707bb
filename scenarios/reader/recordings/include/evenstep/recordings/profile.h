#pragma once
/// What a profiler recorded, whatever the format of its file: named intervals of real time. The readers of the formats are
/// in scenarios/reader/recordings/src/profiles; roles.h decides, for all formats alike, which intervals are segments,
/// visualizations and steps.
///
/// Files are not trusted. At most 10 million intervals (of 24 bytes) and a million names of 64 MB together are kept, however
/// long the file is. Intervals outside the format's rules (an end that is missing or before the begin, the same one twice)
/// are left out and counted; ends that run over the next begin of their track are clipped and counted (Clipped).

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "evenstep/text/diagnostic.h"
#include "evenstep/time/result.h"
#include "evenstep/time/time.h"

namespace evenstep {

struct ProfileName {
  std::string text;      ///< as the file has it, cut after 1,000 bytes
  std::string category;  ///< what it names: "kernel", "copy", "range", "frame"; empty where the file does not say
};

/// What the intervals of a track can be to each other.
enum class TrackOrder {
  any,     ///< the file does not say on which thread or queue they ran, or it may run several at a time
  nest,    ///< of a thread: each lies within another one or follows it
  follow,  ///< of a queue: one after the other
};

/// A thread or a queue of a source.
struct ProfileTrack {
  std::uint32_t source = 0;  ///< index in Profile::sources
  std::string lane;          ///< "queue 1"; empty where the file does not say
  TrackOrder order = TrackOrder::any;
};

struct ProfileInterval {
  RealTime begin, end;
  std::uint32_t name = 0, track = 0;  ///< index in Profile::names, Profile::tracks
};

/// What could not be used, and why.
struct LeftOut {
  std::string what;  ///< "rows without an end"
  std::int64_t count = 0;
  std::string first;        ///< the first of them, as far as it can be shown
  bool on_purpose = false;  ///< as was asked for, or at the edges of the recording: nothing is wrong with the file
};

/// The intervals that ran more than a microsecond over the next begin of their track, and now end there.
struct Clipped {
  std::int64_t count = 0;
  std::string first;                  ///< the name of the first of them
  std::vector<std::int64_t> of_name;  ///< how many, by index in Profile::names
};

struct Profile {
  std::string file, format;          ///< format: "Nsight Systems SQLite, schema 3.13.2"
  std::string time_base;             ///< how its times became ns: "us, as trace events have them"
  bool only_visualizations = false;  ///< a recording of pictures: there can be no steps in it
  bool whole_frames = false;         ///< its pictures last till the next one: nothing says how long drawing them took
  std::vector<ProfileName> names;
  std::vector<std::string> sources;  ///< processes, swap chains, devices; "" where the file does not say
  std::vector<ProfileTrack> tracks;
  std::vector<ProfileInterval> intervals;  ///< in order of `begin`; times of the file's own clock
  Clipped clipped;
  std::vector<LeftOut> left_out;

  std::uint32_t source_of(const ProfileInterval& interval) const { return tracks[interval.track].source; }
};

/// The columns of a CSV file whose format no reader knows, named as in its header.
struct CsvColumns {
  std::string name, begin, end, duration, process;  ///< `begin` and one of `end` and `duration`; the others may be empty
  std::string unit;                                 ///< of the times: "ns", "us", "ms", "s"
};

struct ProfileOptions {
  std::string format;  ///< one of profile_formats(); empty: recognized by how the file begins
  CsvColumns columns;
  std::int64_t header = 0;  ///< of a CSV: the line that names its columns, from 1; 0: found by its cells
};

using ProfileResult = Result<Profile, std::vector<Diagnostic>>;
ProfileResult read_profile(const std::string& path, const ProfileOptions& options = {});
/// The same for bytes in memory; `name` stands for the file in errors.
ProfileResult parse_profile(std::string_view bytes, const std::string& name, const ProfileOptions& options = {});

/// The formats, by the word that ProfileOptions::format takes.
std::vector<std::string> profile_formats();

}  // namespace evenstep
