#pragma once
/// Turns a profiler's intervals into the segments of a recording, by what their names match.
///
/// - A *visualization* is a run of intervals that match `visualization`, with no step between them: from the begin of the
///   first to the end of the last.
/// - A *step* is an interval that matches `step`. Intervals that overlap (streams of a GPU do) are one step: their union.
///   With `step_begin`, a step goes from an interval that matches it to the last one before the next that does.
/// - A *segment* begins with each interval that matches `segment`; without it, with each visualization. What stands before
///   the first segment is left out, and so is what follows the begin of the last one, because the file ends within it.
///   Without segments and visualizations, all steps are one segment.
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
  std::string process;  ///< where a role's intervals come from several sources: of those that match this
  /// Steps to put after each visualization of a recording that has none: so many, of this length each.
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
/// The most frequent first; equally frequent ones by name.
std::vector<NameSummary> summarize(const Profile& profile);

/// A guess for a recording about which nothing was said: a `segment` for names with numbers that count up, as
/// "ProfilerStep#N"; names that speak of drawing are the visualization; else, of kernels, the longest one that recurs and is
/// rarer than the others. All other kernels are steps. Empty where nothing can be guessed.
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
  std::int64_t cut = 0;                 ///< pictures that begin before the one before them ends: taken to begin there
  std::vector<LeftOut> left_out;        ///< that of the profile included
};

using AssignedRolesResult = Result<AssignedRoles, std::vector<Diagnostic>>;
/// Errors: an expression that is none, or that matches no name (with the names there are, the most frequent first); a role
/// with intervals of several sources (with the sources); nothing that could be guessed.
AssignedRolesResult assign_roles(const Profile& profile, const Roles& roles);

}  // namespace evenstep
