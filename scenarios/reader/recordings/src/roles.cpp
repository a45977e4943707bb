#include "evenstep/recordings/roles.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "expression.h"

namespace evenstep {
namespace {

using internal::Expression;

constexpr std::int64_t kLongestRecording_ns = 1'000'000'000'000'000;  // 1e6 s, as of timing.csv

enum RoleBit : std::uint8_t { kIsSegment = 1, kIsVisualization = 2, kIsStep = 4, kBeginsStep = 8 };

/// A run of visualizations, or one step.
struct Group {
  Interval interval;
  bool is_step = false;
};

class Assignment {
 public:
  Assignment(const Profile& profile, const Roles& roles) : profile_(profile) {
    result_.roles = roles;
    result_.left_out = profile.left_out;
  }

  AssignedRolesResult run() {
    find_roles_of_names();
    if (errors_.empty()) choose_sources();
    if (!errors_.empty()) return Failure(std::move(errors_));
    count_names();
    clip_what_holds_both();
    collect_groups();
    add_segments();
    add_given_steps();
    check_length();
    if (result_.segments.empty() && errors_.empty()) fail("no segment is whole: the roles match too few intervals");
    if (!errors_.empty()) return Failure(std::move(errors_));
    shift_to_zero();
    judge();
    return std::move(result_);
  }

  RoleMarks marks(const std::vector<NameSummary>& names) {
    find_roles_of_names();
    if (!errors_.empty()) return Failure(std::move(errors_));
    std::map<std::pair<std::string, std::string>, std::uint8_t> of_summary;
    for (std::size_t i = 0; i < profile_.names.size(); ++i)
      of_summary[{summary_text(profile_.names[i].text), profile_.names[i].category}] |= roles_of_name_[i];
    std::vector<std::string> all;
    for (const NameSummary& name : names) {
      const std::uint8_t bits = of_summary[{name.text, name.category}];
      all.emplace_back((bits & kIsVisualization) != 0 ? "visualization"
                       : (bits & kBeginsStep) != 0    ? "begins a step"
                       : (bits & kIsStep) != 0        ? "step"
                       : (bits & kIsSegment) != 0     ? "segment"
                                                      : "");
    }
    return all;
  }

 private:
  void fail(std::string message) { errors_.push_back({profile_.file, 0, 0, std::move(message)}); }
  void leave_out(std::string what, const std::string& first, bool on_purpose = true) {
    for (LeftOut& left : result_.left_out) {
      if (left.what == what) return void(++left.count);
    }
    result_.left_out.push_back({std::move(what), 1, first, on_purpose});
  }

  void find_roles_of_names();
  void take_role(const char* role, std::string& text, RoleBit bit);
  void choose_sources();
  bool taken(const ProfileInterval& interval, RoleBit bit) const;
  void count_names();
  void clip_what_holds_both();
  void collect_groups();
  void add_group(const ProfileInterval& interval, bool is_step, bool begins_step);
  void add_boundary(Interval interval);
  bool boundaries_are_ranges() const;
  void add_segments();
  void add_segment(std::size_t from, std::size_t to, RealTime least_end);
  void check_length();
  void add_given_steps();
  void shift_to_zero();
  void judge();

  const Profile& profile_;
  AssignedRoles result_;
  std::vector<Diagnostic> errors_;
  std::vector<std::uint8_t> roles_of_name_;
  std::map<RoleBit, std::vector<bool>> tracks_of_role_;  ///< which of them are taken
  std::map<std::size_t, RealTime> ends_;                 ///< of intervals that were clipped here
  std::int64_t overlapped_ = 0;                          ///< merged for no other reason
  std::vector<Group> groups_;                            ///< in order of begin
  std::optional<std::size_t> last_step_, last_shown_;    ///< in groups_
  std::vector<Interval> boundaries_;                     ///< a segment begins where each of them does
};

/// "'a' (12), 'b' (3)": the names there are, the most frequent first.
std::string names_text(const Profile& profile) {
  constexpr std::size_t kMostShown = 12;
  const std::vector<NameSummary> names = summarize(profile);
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMostShown); ++i)
    text += fmt::format("{}'{}' ({})", i == 0 ? "" : ", ", names[i].text.substr(0, 80), names[i].count);
  return names.size() > kMostShown ? fmt::format("{} and {} more names", text, names.size() - kMostShown) : text;
}

void Assignment::take_role(const char* role, std::string& text, RoleBit bit) {
  if (text.empty()) return;
  std::string category;
  for (const ProfileName& name : profile_.names) {
    if (!name.category.empty() && text.starts_with(name.category + ":")) category = name.category;
  }
  const Result<Expression> expression = Expression::of(text.substr(category.empty() ? 0 : category.size() + 1));
  if (!expression)
    return fail(fmt::format("{}: '{}' is no extended regular expression: {}", role, text, expression.error()));
  bool any = false;
  for (std::size_t i = 0; i < profile_.names.size(); ++i) {
    if (!category.empty() && profile_.names[i].category != category) continue;
    if (!expression->matches(profile_.names[i].text)) continue;
    any = true;
    roles_of_name_[i] = static_cast<std::uint8_t>(roles_of_name_[i] | bit);
  }
  if (!any && result_.roles.optional && bit != kIsStep) return text.clear();
  if (!any) fail(fmt::format("no name matches the {} '{}'; there are {}", role, text, names_text(profile_)));
}

void Assignment::find_roles_of_names() {
  roles_of_name_.assign(profile_.names.size(), 0);
  if (result_.roles.unset()) {
    const Roles guess = guess_roles(profile_);
    if (guess.unset())
      return fail(
          fmt::format("which of its names are the steps? Say --step REGEX, and --visualization REGEX or --segment "
                      "REGEX if there are any; there are {}",
                      names_text(profile_)));
    result_.guessed = true;
    result_.roles.segment = guess.segment;
    result_.roles.visualization = guess.visualization;
    result_.roles.step = guess.step;
  }
  Roles& roles = result_.roles;
  take_role("segment", roles.segment, kIsSegment);
  take_role("visualization", roles.visualization, kIsVisualization);
  take_role("step", roles.step, kIsStep);
  take_role("begin of a step", roles.step_begin, kBeginsStep);
  for (std::uint8_t& bits : roles_of_name_) {
    if ((bits & kIsVisualization) != 0) bits = static_cast<std::uint8_t>(bits & ~(kIsStep | kBeginsStep));
    if ((bits & kBeginsStep) != 0) bits |= kIsStep;
  }
}

void Assignment::choose_sources() {
  std::optional<Expression> chosen;
  if (!result_.roles.process.empty()) {
    Result<Expression> expression = Expression::of(result_.roles.process);
    if (!expression)
      return fail(
          fmt::format("process: '{}' is no extended regular expression: {}", result_.roles.process, expression.error()));
    chosen.emplace(std::move(expression).value());
  }
  for (const auto& [bit, role] :
       {std::pair{kIsSegment, "segment"}, {kIsVisualization, "visualization"}, {kIsStep, "step"}}) {
    std::vector<std::int64_t> of_track(profile_.tracks.size()), counts(profile_.sources.size());
    for (const ProfileInterval& interval : profile_.intervals)
      of_track[interval.track] += (roles_of_name_[interval.name] & bit) != 0;
    std::vector<bool>& taken = tracks_of_role_[bit];
    taken.resize(of_track.size());
    std::vector<bool> source_taken(counts.size());
    for (std::size_t i = 0; i < of_track.size(); ++i) {
      const ProfileTrack& track = profile_.tracks[i];
      counts[track.source] += of_track[i];
      const std::string& source = profile_.sources[track.source];
      taken[i] = of_track[i] > 0 && (!chosen || chosen->matches(source) ||
                                     (!track.lane.empty() && chosen->matches(fmt::format("{}, {}", source, track.lane))));
      if (taken[i]) source_taken[track.source] = true;
    }
    const auto several = std::count_if(counts.begin(), counts.end(), [](std::int64_t count) { return count > 0; });
    const auto left = std::count(source_taken.begin(), source_taken.end(), true);
    if (several == 1 && left == 0) {
      for (std::size_t i = 0; i < of_track.size(); ++i) taken[i] = of_track[i] > 0;
    }
    std::string text;
    for (std::size_t i = 0; i < counts.size() && text.size() < 1000; ++i) {
      if (counts[i] > 0) text += fmt::format("{}'{}' ({})", text.empty() ? "" : ", ", profile_.sources[i], counts[i]);
    }
    if (several > 1 && left != 1) {
      fail(fmt::format("the {}s come from {} processes{}; choose one with --process REGEX: {}", role, several,
                       chosen ? fmt::format(", and '{}' matches {} of them", result_.roles.process, left) : "", text));
    }
  }
}

bool Assignment::taken(const ProfileInterval& interval, RoleBit bit) const {
  return (roles_of_name_[interval.name] & bit) != 0 && tracks_of_role_.at(bit)[interval.track];
}

/// A step that is still running when a picture and then another step begin on its own track is a step without its end.
void Assignment::clip_what_holds_both() {
  struct Open {
    std::size_t index;
    RealTime end;
    bool is_step, holds_step = false, holds_picture = false;
    RealTime first{INT64_MAX};  ///< begin of the first that it holds
  };
  std::vector<std::vector<Open>> tracks(profile_.tracks.size());
  const auto close = [&](std::vector<Open>& open) {
    const Open last = open.back();
    open.pop_back();
    if (last.holds_step && last.holds_picture) ends_[last.index] = last.first;
    if (open.empty() || last.end > open.back().end) return;
    open.back().holds_step |= last.holds_step || last.is_step;
    open.back().holds_picture |= last.holds_picture || !last.is_step;
  };
  for (std::size_t i = 0; i < profile_.intervals.size(); ++i) {
    const ProfileInterval& interval = profile_.intervals[i];
    if (profile_.tracks[interval.track].order == TrackOrder::any) continue;
    const bool step = taken(interval, kIsStep);
    if (!step && !taken(interval, kIsVisualization)) continue;
    std::vector<Open>& open = tracks[interval.track];
    while (!open.empty() && open.back().end <= interval.begin) close(open);
    if (!open.empty() && interval.end <= open.back().end) open.back().first = std::min(open.back().first, interval.begin);
    open.push_back({i, interval.end, step});
  }
  for (std::vector<Open>& open : tracks) {
    while (!open.empty()) close(open);
  }
  result_.clipped += static_cast<std::int64_t>(ends_.size());
}

/// Which names became what, and how many intervals have no role.
void Assignment::count_names() {
  std::vector<std::int64_t> counts[3];
  for (std::vector<std::int64_t>& of_role : counts) of_role.resize(profile_.names.size());
  for (const ProfileInterval& interval : profile_.intervals) {
    const bool segment = taken(interval, kIsSegment), shown = taken(interval, kIsVisualization),
               step = taken(interval, kIsStep);
    counts[0][interval.name] += segment;
    counts[1][interval.name] += shown;
    counts[2][interval.name] += step;
    if (segment || shown || step) continue;
    const bool other_source = roles_of_name_[interval.name] != 0;
    leave_out(other_source ? "intervals of other processes" : "intervals of other names",
              profile_.names[interval.name].text);
  }
  constexpr const char* kNames[] = {"segment", "visualization", "step"};
  for (std::size_t role = 0; role < 3; ++role) {
    const std::size_t first = result_.became.size();
    for (std::size_t i = 0; i < counts[role].size(); ++i) {
      if (counts[role][i] > 0) result_.became.push_back({kNames[role], profile_.names[i].text, counts[role][i]});
    }
    std::stable_sort(result_.became.begin() + static_cast<std::ptrdiff_t>(first), result_.became.end(),
                     [](const RoleCount& a, const RoleCount& b) { return a.count > b.count; });
  }
}

/// Adds an interval to the last group of its role, or opens another one.
void Assignment::add_group(const ProfileInterval& interval, bool is_step, bool begins_step) {
  std::optional<std::size_t>& last = is_step ? last_step_ : last_shown_;
  Group* const same = last ? &groups_[*last] : nullptr;
  if (profile_.only_visualizations && same != nullptr) {
    // The GPU may begin a picture before the one before is done; this picture then begins where that one ends.
    if (interval.end <= same->interval.end) return leave_out("pictures within the time of the one before", {}, false);
    result_.cut += interval.begin < same->interval.end;
    groups_.push_back({{std::max(interval.begin, same->interval.end), interval.end}});
    *last = groups_.size() - 1;
    return;
  }
  const bool overlaps = same != nullptr && interval.begin < same->interval.end;
  const bool of_one_step = is_step && !result_.roles.step_begin.empty() && same != nullptr && !begins_step;
  const bool of_one_picture = !is_step && !result_.roles.step.empty() && same != nullptr && same == &groups_.back();
  if (overlaps || of_one_step || of_one_picture) {
    same->interval.end = std::max(same->interval.end, interval.end);
    ++result_.merged;
    overlapped_ += !of_one_step && !of_one_picture;
    return;
  }
  last = groups_.size();
  groups_.push_back({{interval.begin, interval.end}, is_step});
}

void Assignment::add_boundary(Interval interval) {
  if (!boundaries_.empty() && (interval.begin < boundaries_.back().end || interval.begin <= boundaries_.back().begin))
    return;
  boundaries_.push_back(interval);
}

void Assignment::collect_groups() {
  for (std::size_t i = 0; i < profile_.intervals.size(); ++i) {
    ProfileInterval interval = profile_.intervals[i];
    const auto clipped = ends_.find(i);
    if (clipped != ends_.end()) interval.end = clipped->second;
    if (taken(interval, kIsSegment)) add_boundary({interval.begin, interval.end});
    const bool step = taken(interval, kIsStep);
    if (step || taken(interval, kIsVisualization))
      add_group(interval, step, (roles_of_name_[interval.name] & kBeginsStep) != 0);
  }
  if (!result_.roles.segment.empty()) return;
  for (const Group& group : groups_) {
    if (!group.is_step) add_boundary(group.interval);
  }
}

/// Whether the intervals of segments last as long as the segments do, so that the last one has an end, too. Otherwise they
/// only mark where one begins.
bool Assignment::boundaries_are_ranges() const {
  if (result_.roles.segment.empty()) return false;
  if (boundaries_.size() < 2) return true;
  double covered_ns = 0;
  for (std::size_t i = 0; i + 1 < boundaries_.size(); ++i)
    covered_ns += static_cast<double>((boundaries_[i].end - boundaries_[i].begin).ns);
  return 2 * covered_ns > static_cast<double>((boundaries_.back().begin - boundaries_.front().begin).ns);
}

/// The groups from `from` to before `to`, all of which begin in one segment.
void Assignment::add_segment(std::size_t from, std::size_t to, RealTime least_end) {
  SegmentTiming segment;
  std::size_t shown = to;  // the longest visualization
  const auto length = [&](std::size_t i) { return groups_[i].interval.end - groups_[i].interval.begin; };
  for (std::size_t i = from; i < to; ++i) {
    if (groups_[i].is_step) segment.steps.push_back(groups_[i].interval);
    if (!groups_[i].is_step && (shown == to || length(i) > length(shown))) shown = i;
  }
  for (std::size_t i = from; i < to; ++i) {
    if (!groups_[i].is_step && i != shown) leave_out("visualizations beside a longer one in the same segment", {}, false);
  }
  if (shown != to) segment.visualization = groups_[shown].interval;
  if (!segment.visualization && segment.steps.empty()) return leave_out("segments in which nothing ran", {});
  segment.begin = segment.steps.empty() ? segment.visualization->begin : segment.steps.front().begin;
  segment.end = least_end;
  if (segment.visualization) {
    segment.begin = std::min(segment.begin, segment.visualization->begin);
    segment.end = std::max(segment.end, segment.visualization->end);
  }
  if (!segment.steps.empty()) segment.end = std::max(segment.end, segment.steps.back().end);
  segment.index = static_cast<std::int64_t>(result_.segments.size());
  if (!result_.segments.empty()) result_.segments.back().end = std::max(result_.segments.back().end, segment.begin);
  result_.segments.push_back(std::move(segment));
}

void Assignment::add_segments() {
  if (boundaries_.empty()) return add_segment(0, groups_.size(), RealTime{INT64_MIN});
  const bool ranges = boundaries_are_ranges();
  std::size_t next = 0;
  for (; next < groups_.size() && groups_[next].interval.begin < boundaries_.front().begin; ++next)
    leave_out("steps and visualizations before the first segment", {});
  for (std::size_t k = 0; k + (ranges ? 0 : 1) < boundaries_.size(); ++k) {
    const bool last = k + 1 == boundaries_.size();
    const RealTime until =
        last ? std::max(boundaries_[k].end, boundaries_[k].begin + Duration{1}) : boundaries_[k + 1].begin;
    const std::size_t from = next;
    while (next < groups_.size() && groups_[next].interval.begin < until) ++next;
    add_segment(from, next, last ? boundaries_[k].end : boundaries_[k + 1].begin);
  }
  for (; next < groups_.size(); ++next)
    leave_out(ranges ? "steps and visualizations after the last segment"
                     : "steps and visualizations of the last segment, which the file may cut off",
              {});
}

void Assignment::check_length() {
  if (result_.segments.empty()) return;
  RealTime end = result_.segments.front().end;
  for (const SegmentTiming& segment : result_.segments) end = std::max(end, segment.end);
  if (end - result_.segments.front().begin > Duration{kLongestRecording_ns})
    fail("the recording is longer than 1e6 s; is its unit of time right?");
}

/// Lays the steps that were given behind the visualizations, as many as end before the next segment begins.
void Assignment::add_given_steps() {
  const Roles& roles = result_.roles;
  if (roles.steps == 0) return;
  if (roles.step_time.ns > kLongestRecording_ns / roles.steps) return fail("the given steps are longer than 1e6 s");
  for (std::size_t k = 0; k < result_.segments.size(); ++k) {
    SegmentTiming& segment = result_.segments[k];
    if (!segment.steps.empty()) return fail("--steps is for a recording without steps; this one has some");
    RealTime at = segment.visualization->end;
    // A picture that lasts its whole frame gives the end of it to the steps.
    if (profile_.whole_frames) {
      const Duration whole = segment.visualization->end - segment.visualization->begin;
      at = at - Duration{std::min(roles.steps, whole.ns / roles.step_time.ns) * roles.step_time.ns};
      segment.visualization->end = at;
    }
    for (std::int64_t i = 0; i < roles.steps; ++i, at = at + roles.step_time) {
      if (k + 1 < result_.segments.size() && result_.segments[k + 1].begin < at + roles.step_time) {
        leave_out("given steps that do not fit between two visualizations", {});
        continue;
      }
      segment.steps.push_back({at, at + roles.step_time});
    }
    if (!segment.steps.empty()) segment.end = std::max(segment.end, segment.steps.back().end);
  }
}

void Assignment::shift_to_zero() {
  const Duration origin = result_.segments.front().begin - RealTime{};
  const auto shift = [&](Interval& interval) { interval = {interval.begin - origin, interval.end - origin}; };
  for (SegmentTiming& segment : result_.segments) {
    segment.begin = segment.begin - origin;
    segment.end = segment.end - origin;
    if (segment.visualization) shift(*segment.visualization);
    for (Interval& step : segment.steps) shift(step);
  }
}

/// How much of the recording is not what the file says it is.
void Assignment::judge() {
  for (std::size_t i = 0; i < profile_.clipped.of_name.size(); ++i) {
    if ((roles_of_name_[i] & (kIsVisualization | kIsStep)) != 0) result_.clipped += profile_.clipped.of_name[i];
  }
  result_.lost = overlapped_ + result_.clipped;
  for (const LeftOut& left : result_.left_out) {
    if (left.on_purpose) continue;
    result_.lost += left.count;
    result_.judged += left.count;
  }
  for (const RoleCount& one : result_.became) result_.judged += one.role == "segment" ? 0 : one.count;
}

}  // namespace

std::string AssignedRoles::damage() const {
  if (!damaged()) return "";
  return fmt::format("{} of {} intervals ({:.1f} %) were merged, clipped or left out; is the recording damaged?", lost,
                     judged, 100.0 * static_cast<double>(lost) / static_cast<double>(judged));
}

AssignedRolesResult assign_roles(const Profile& profile, const Roles& roles) { return Assignment(profile, roles).run(); }

RoleMarks mark_roles(const Profile& profile, const Roles& roles, const std::vector<NameSummary>& names) {
  return Assignment(profile, roles).marks(names);
}

}  // namespace evenstep
