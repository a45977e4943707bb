#pragma once
/// Turns a profiler's intervals into the segments of a recording, by the expressions that their names match.
///
/// - A *visualization* is a run of intervals that match `visualization`, with no step between them: from the beginning of
///   the first to the end of the last.
/// - A *step* is an interval that matches `step`. Intervals that overlap (streams of a GPU do) are one step: their union.
///   With `step_begin`, a step goes from an interval that matches `step_begin` to the last step interval before the next
///   such match.
/// - A *segment* begins with each interval that matches `segment`; without that expression, with each visualization.
///   Whatever comes before the first segment is left out, and so is the last segment, because the file may end within it.
///   (Not if the intervals that match `segment` cover most of the time: they then show where the last segment ends.) Without
///   segments and visualizations, all steps are one segment.
///
/// An interval that matches both `visualization` and `step` is a visualization. Expressions are POSIX extended regular
/// expressions (as of grep -E), matched anywhere in the name. "kernel:EXPRESSION" means names of that category only, if the
/// recording has such a category.

#include <optional>
#include <string>
#include <vector>

#include "evenstep/recordings/profile.h"
#include "evenstep/scheduler/step_timing.h"

namespace evenstep {

struct Roles {
  std::string segment, visualization, step;  ///< all empty: guess_roles()
  std::string step_begin;
  std::string process;  ///< if a role's intervals come from several sources: only those sources that match this
  /// For a recording without steps: how many to put after each visualization, and how long each is.
  std::int64_t steps = 0;
  Duration step_time;

  /// Whether no expression is given.
  bool unset() const { return segment.empty() && visualization.empty() && step.empty(); }
};

/// One name, or several that differ in a number after '#' ("ProfilerStep#N"), as a person who chooses roles wants to see it.
struct NameSummary {
  std::string text, category;
  std::int64_t count = 0;
  Duration median;                 ///< of the lengths
  std::optional<Duration> period;  ///< median from one begin to the next; none for a single one
};
/// The most frequent first; equally frequent ones in order of name.
std::vector<NameSummary> summarize(const Profile& profile);

/// The roles guessed for a recording if no expression is given. Names with numbers that count up, such as "ProfilerStep#N",
/// are the segment. Names that speak of drawing are the visualization, or else the longest kernel that recurs and is rarer
/// than the others. All other kernels are steps. Empty if nothing can be guessed.
Roles guess_roles(const Profile& profile);

struct RoleCount {
  std::string role, name;  ///< "step", "par_ranged2d_kernel"
  std::int64_t count = 0;
};

struct AssignedRoles {
  Roles roles;  ///< those used, also where they were guessed
  bool guessed = false;
  std::vector<SegmentTiming> segments;  ///< shifted so that the first one begins at 0
  std::vector<RoleCount> became;        ///< which names became what; the most frequent first
  std::int64_t merged = 0;              ///< intervals that are part of another one's step or visualization
  std::int64_t cut = 0;                 ///< pictures that begin before the previous one ends: taken to begin at that end
  std::vector<LeftOut> left_out;        ///< including Profile::left_out
};

using AssignedRolesResult = Result<AssignedRoles, std::vector<Diagnostic>>;
/// Errors: an expression that is invalid or matches no name (the error lists the names, the most frequent first); a role
/// with intervals of several sources (the error lists them); no roles given and none that can be guessed.
AssignedRolesResult assign_roles(const Profile& profile, const Roles& roles);

}  // namespace evenstep
