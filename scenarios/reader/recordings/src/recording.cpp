#include "evenstep/recordings/recording.h"

#include "evenstep/recordings/step_list.h"
#include "evenstep/recordings/timing_csv.h"
#include "evenstep/text/text_file.h"
#include "profiles/bytes.h"

namespace evenstep {
namespace {

enum class Csv { other, segments, steps };

Csv kind_of(const std::string& path) {
  const std::unique_ptr<internal::Bytes> bytes = internal::bytes_of_file(path);
  std::string_view first = internal::without_byte_order_mark(bytes->next());
  while (first.starts_with('#')) first.remove_prefix(std::min(first.find('\n'), first.size() - 1) + 1);
  const std::string_view header = first.substr(0, first.find_first_of("\r\n"));
  if (header == "begin_ns,end_ns") return Csv::steps;
  const bool segments =
      header == "segment,kind,index,begin_ns,end_ns" || header == "segment,kind,index,begin_ns,end_ns,simulated_ns";
  return segments ? Csv::segments : Csv::other;
}

Recording read_profiled(const std::string& path, const RecordingOptions& options, std::string* damage) {
  const ProfileResult profile = read_profile(path, options.profile);
  if (!profile) return Failure(profile.error());
  AssignedRolesResult assigned = assign_roles(*profile, with_preset(options.roles, options.preset));
  if (!assigned) return Failure(assigned.error());
  if (damage != nullptr) *damage = assigned->damage();
  return std::move(assigned->segments);
}

}  // namespace

bool is_timing_csv(const std::string& path) { return kind_of(path) != Csv::other; }

bool is_step_list(const std::string& path) { return kind_of(path) == Csv::steps; }

Recording read_recording(const std::string& path, const RecordingOptions& options, bool as_one_segment,
                         std::string* damage) {
  const Csv kind = kind_of(path);
  Recording recording = kind == Csv::other ? read_profiled(path, options, damage) : read_timing_or_steps(path);
  if (!recording || kind != Csv::steps || as_one_segment) return recording;
  return cut_steps(recording->front().steps, cycle_of(*recording)).segments;
}

}  // namespace evenstep
