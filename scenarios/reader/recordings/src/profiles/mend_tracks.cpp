// On a track, slices nest or follow one another. Profilers write others: a kernel whose end came from a late flush runs over
// all that came after it on its queue. Trace viewers let it end at the next begin, and so does this.
#include <algorithm>
#include <span>
#include <tuple>

#include "profile_builder.h"

namespace evenstep::internal {
namespace {

/// Times are rounded one by one, mostly to microseconds: what is less is no overlap.
constexpr Duration kRounding{1000};

class Mender {
 public:
  explicit Mender(Profile& profile) : profile_(profile) { profile_.clipped.of_name.resize(profile_.names.size()); }

  /// Of a queue.
  void follow(std::span<ProfileInterval> track) {
    for (std::size_t from = 0, next = 0; from < track.size(); from = next) {
      // Of those that begin together none is next to the others.
      while (next < track.size() && track[next].begin == track[from].begin) ++next;
      if (next == track.size()) return;
      for (std::size_t i = from; i < next; ++i) {
        if (track[i].end > track[next].begin) clip(track[i], track[next].begin);
      }
    }
  }

  /// Of a thread.
  void nest(std::span<ProfileInterval> track) {
    open_.clear();
    for (ProfileInterval& one : track) {
      while (!open_.empty() && open_.back()->end <= one.begin) open_.pop_back();
      while (!open_.empty() && open_.back()->end < one.end) {
        ProfileInterval& outer = *open_.back();
        if (one.end - outer.end <= kRounding && outer.end - one.begin > kRounding) {
          one.end = outer.end;
          break;
        }
        clip(outer, one.begin);
        open_.pop_back();
      }
      open_.push_back(&one);
    }
  }

 private:
  void clip(ProfileInterval& interval, RealTime end) {
    const bool rounded = interval.end - end <= kRounding;
    interval.end = end;
    if (rounded) return;
    Clipped& clipped = profile_.clipped;
    if (clipped.count++ == 0) clipped.first = profile_.names[interval.name].text.substr(0, 100);
    ++clipped.of_name[interval.name];
  }

  Profile& profile_;
  std::vector<ProfileInterval*> open_;
};

}  // namespace

std::int64_t mend_tracks(Profile& profile) {
  std::vector<ProfileInterval>& all = profile.intervals;
  // What holds others comes before them.
  std::sort(all.begin(), all.end(), [](const ProfileInterval& a, const ProfileInterval& b) {
    return std::tie(a.track, a.begin, b.end, a.name) < std::tie(b.track, b.begin, a.end, b.name);
  });
  const auto equal = [](const ProfileInterval& a, const ProfileInterval& b) {
    return std::tie(a.track, a.begin, a.end, a.name) == std::tie(b.track, b.begin, b.end, b.name);
  };
  const auto last = std::unique(all.begin(), all.end(), equal);
  const std::int64_t twice = all.end() - last;
  all.erase(last, all.end());
  Mender mender(profile);
  for (std::size_t from = 0, to = 0; from < all.size(); from = to) {
    while (to < all.size() && all[to].track == all[from].track) ++to;
    const std::span<ProfileInterval> track(all.data() + from, to - from);
    const TrackOrder order = profile.tracks[all[from].track].order;
    if (order == TrackOrder::follow) mender.follow(track);
    if (order == TrackOrder::nest) mender.nest(track);
  }
  std::sort(all.begin(), all.end(), [](const ProfileInterval& a, const ProfileInterval& b) {
    return std::tie(a.begin, a.end, a.name, a.track) < std::tie(b.begin, b.end, b.name, b.track);
  });
  return twice;
}

}  // namespace evenstep::internal
