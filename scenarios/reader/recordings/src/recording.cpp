#include "evenstep/recordings/recording.h"

#include "evenstep/recordings/timing_csv.h"
#include "evenstep/text/text_file.h"
#include "profiles/bytes.h"

namespace evenstep {
namespace {

bool begins_with_header(std::string_view bytes, std::string_view header) {
  return bytes.substr(0, bytes.find_first_of("\r\n")) == header;
}

}  // namespace

bool is_timing_csv(const std::string& path) {
  const std::unique_ptr<internal::Bytes> bytes = internal::bytes_of_file(path);
  std::string_view first = internal::without_byte_order_mark(bytes->next());
  while (first.starts_with('#')) first.remove_prefix(std::min(first.find('\n'), first.size() - 1) + 1);
  for (const char* header :
       {"segment,kind,index,begin_ns,end_ns", "segment,kind,index,begin_ns,end_ns,simulated_ns", "begin_ns,end_ns"})
    if (begins_with_header(first, header)) return true;
  return false;
}

Recording read_recording(const std::string& path, const RecordingOptions& options, bool steps_too) {
  if (is_timing_csv(path)) return steps_too ? read_timing_or_steps(path) : read_timing_csv(path);
  const ProfileResult profile = read_profile(path, options.profile);
  if (!profile) return Failure(profile.error());
  AssignedRolesResult assigned = assign_roles(*profile, options.roles);
  if (!assigned) return Failure(assigned.error());
  return std::move(assigned->segments);
}

}  // namespace evenstep
