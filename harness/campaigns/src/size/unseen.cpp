#include "unseen.h"

#include <algorithm>

namespace evenstep::internal {

std::vector<SizeUnseen> play_unseen(std::span<const SegmentNeed> needs) {
  constexpr std::size_t kParts = 6;
  std::vector<SizeUnseen> out;
  if (std::ssize(needs) < kLeastUnseen) return out;
  const auto end_of = [&](std::size_t parts) { return needs.size() * parts / kParts; };
  Duration lead = needs.front().lead, delay = needs.front().delay;
  for (std::size_t part = 1; part < kParts; ++part) {
    for (const SegmentNeed& need : needs.subspan(end_of(part - 1), end_of(part) - end_of(part - 1))) {
      lead = std::max(lead, need.lead);
      delay = std::max(delay, need.delay);
    }
    const auto played = needs.subspan(end_of(part), end_of(part + 1) - end_of(part));
    SizeUnseen& one = out.emplace_back();
    one.sized = static_cast<std::int64_t>(end_of(part));
    one.played = std::ssize(played);
    one.from = played.front().begin;
    one.latency = lead + delay;
    one.lead = lead;
    for (const SegmentNeed& need : played) {
      if (need.lead > lead || need.delay > delay) ++one.late;
      one.late_by = std::max(one.late_by, need.delay - delay);
      one.missing_by = std::max(one.missing_by, need.lead - lead);
    }
  }
  return out;
}

}  // namespace evenstep::internal
