#pragma once
/// When a run was made, and from which commit of the user's repository: the date and the commit in summary.json.

#include <cstdint>
#include <functional>
#include <string>

#include "evenstep/time/result.h"

namespace evenstep {

/// The variables of the environment: std::getenv, or a test's own.
using Environment = std::function<const char*(const char* name)>;

/// "2026-11-23T11:05:13Z". Years 1970 to 9999; a time outside them is moved to the nearer end.
std::string utc_text(std::int64_t seconds_since_1970);

/// The date that a run bears: SOURCE_DATE_EPOCH, if it is set, so that two runs can be the same byte for byte; or else `now`
/// (both in seconds since 1970). It is an error if SOURCE_DATE_EPOCH is not such a number.
Result<std::string> date_of_run(const Environment& environment, std::int64_t now);

/// The commit that is checked out in the repository in which `file` lies: 40 or 64 hex digits. Empty if there is none. The
/// repository's own files are read and git is not started, because a repository can name programs that git would run. So
/// nothing checks whether the files were changed since that commit. Where the folders above the file have no repository (a
/// checkout without .git), the commit is the one that GitHub (GITHUB_SHA) or GitLab (CI_COMMIT_SHA) gives, if the file lies
/// in its workspace.
std::string commit_of(const std::string& file, const Environment& environment);

}  // namespace evenstep
