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
/// A step that holds a visualization and another step of its own thread or queue, or a visualization that holds a step and
/// another visualization, has lost its end: it is clipped to the first of them.
///
/// An interval that matches both `visualization` and `step` is a visualization. Expressions are POSIX extended regular
/// expressions (as of grep -E), matched anywhere in the name. "kernel:EXPRESSION" means names of that category only, if the
/// recording has such a category.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "evenstep/recordings/profile.h"
#include "evenstep/scheduler/step_timing.h"

namespace evenstep {

struct Roles {
  std::string segment, visualization, step;  ///< all empty: guess_roles()
  std::string step_begin;
  std::string process;  ///< if a role's intervals come from several sources or queues: only those that match this
  /// For a recording without steps: how many to put after each visualization, and how long each is.
  std::int64_t steps = 0;
  Duration step_time;
  bool optional = false;  ///< a role that no name matches is left out; not if it is the step, or all of them

  /// Whether no expression is given.
  bool unset() const { return segment.empty() && visualization.empty() && step.empty(); }
};

/// The names that an engine gives to its steps and its drawing, so that one need not look for them.
struct RolePreset {
  const char *name, *segment, *visualization, *step, *step_begin;
  const char* source;  ///< where these names were read
};
std::span<const RolePreset> role_presets();
/// `roles` with those of the preset where they are empty.
Roles with_preset(Roles roles, const std::string& name);

/// One name, or several that differ in a number after '#' ("ProfilerStep#N"), as a person who chooses roles wants to see it.
struct NameSummary {
  std::string text, category;
  std::int64_t count = 0;
  Duration median;                 ///< of the lengths
  std::optional<Duration> period;  ///< median from one begin to the next; none for a single one
};
/// "ProfilerStep#N" for "ProfilerStep#12"; other names as they are.
std::string summary_text(const std::string& name);
/// The most frequent first; equally frequent ones in order of name.
std::vector<NameSummary> summarize(const Profile& profile);

/// The roles guessed for a recording if no expression is given. Names with numbers that count up, such as "ProfilerStep#N",
/// are the segment. Names that speak of drawing are the visualization, or else the longest kernel that recurs and is rarer
/// than the others. All other kernels are steps. Empty if nothing can be guessed.
Roles guess_roles(const Profile& profile);

/// Tells of each name which of the roles match it: "step", "visualization", … or nothing. Errors as of assign_roles.
using RoleMarks = Result<std::vector<std::string>, std::vector<Diagnostic>>;
RoleMarks mark_roles(const Profile& profile, const Roles& roles, const std::vector<NameSummary>& names);

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
  std::int64_t clipped = 0;             ///< steps and visualizations that ran over the next begin of their track
  std::vector<LeftOut> left_out;        ///< including Profile::left_out
  /// Of `judged` intervals (those that match, and what was left out), those that were merged only because they overlap, were
  /// clipped, or were left out although nobody asked for it.
  std::int64_t lost = 0, judged = 0;

  /// More than 1 %.
  bool damaged() const { return 100 * lost > judged; }
  /// That as a sentence; empty if it is not.
  std::string damage() const;
};

using AssignedRolesResult = Result<AssignedRoles, std::vector<Diagnostic>>;
/// Errors: an expression that is invalid or matches no name (the error lists the names, the most frequent first); a role
/// with intervals of several sources (the error lists them); no roles given and none that can be guessed.
AssignedRolesResult assign_roles(const Profile& profile, const Roles& roles);

}  // namespace evenstep
