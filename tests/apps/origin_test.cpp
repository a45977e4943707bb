#include "evenstep/apps/origin.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <map>

#include "catch.h"
#include "temporary_folder.h"

using namespace evenstep;
using evenstep::testing::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

const std::string kOne(40, '1'), kTwo(40, '2'), kLong(64, 'a');

Environment environment(std::map<std::string, std::string> variables = {}) {
  return [variables](const char* name) {
    const auto found = variables.find(name);
    return found == variables.end() ? nullptr : found->second.c_str();
  };
}
std::string commit(const TemporaryFolder& folder, const std::string& file) {
  return commit_of(folder / file, environment());
}

}  // namespace

TEST_CASE("a date is written in UTC, for every year that four digits can hold") {
  CHECK(utc_text(0) == "1970-01-01T00:00:00Z");
  CHECK(utc_text(951'782'399) == "2000-02-28T23:59:59Z");
  CHECK(utc_text(951'782'400) == "2000-02-29T00:00:00Z");
  CHECK(utc_text(1'795'431'913) == "2026-11-23T11:05:13Z");
  CHECK(utc_text(253'402'300'799) == "9999-12-31T23:59:59Z");
  CHECK(utc_text(INT64_MAX) == "9999-12-31T23:59:59Z");
  CHECK(utc_text(INT64_MIN) == "1970-01-01T00:00:00Z");
}

TEST_CASE("SOURCE_DATE_EPOCH is the date of a run, and an error if it is no number") {
  CHECK(date_of_run(environment(), 951'782'400).value() == "2000-02-29T00:00:00Z");
  CHECK(date_of_run(environment({{"SOURCE_DATE_EPOCH", "0"}}), 951'782'400).value() == "1970-01-01T00:00:00Z");
  for (const char* wrong : {"x", "1 ", "-1", "1.5", "99999999999999999999", "253402300800"})
    CHECK_FALSE(date_of_run(environment({{"SOURCE_DATE_EPOCH", wrong}}), 0).ok());
}

TEST_CASE("the commit is that of the branch, or of the detached head, above the scenario's folder") {
  const TemporaryFolder folder;
  CHECK(commit(folder, "a/b/x.toml").empty());
  folder.write(".git/HEAD", "ref: refs/heads/main\n");
  CHECK(commit(folder, "a/b/x.toml").empty());  // no commit yet
  folder.write(".git/packed-refs", "# pack-refs with: peeled fully-peeled sorted \n" + kTwo + " refs/heads/main\n^" + kOne +
                                       "\n" + kOne + " refs/heads/mai\n");
  CHECK(commit(folder, "a/b/x.toml") == kTwo);
  folder.write(".git/refs/heads/main", kOne + "\n");  // newer than the packed one
  CHECK(commit(folder, "a/b/x.toml") == kOne);
  folder.write(".git/HEAD", kLong + "\n");
  CHECK(commit(folder, "a/b/x.toml") == kLong);
}

TEST_CASE("a worktree and a submodule name the folder that has their head") {
  const TemporaryFolder folder;
  folder.write("main/.git/HEAD", "ref: refs/heads/main\n");
  folder.write("main/.git/refs/heads/main", kOne);
  folder.write("main/.git/refs/heads/side", kTwo);
  folder.write("main/.git/worktrees/side/HEAD", "ref: refs/heads/side\n");
  folder.write("main/.git/worktrees/side/commondir", "../..\n");
  folder.write("side/.git", "gitdir: " + (folder / "main/.git/worktrees/side") + "\n");
  CHECK(commit(folder, "side/x.toml") == kTwo);
  CHECK(commit(folder, "main/x.toml") == kOne);
  folder.write("main/.git/modules/lib/HEAD", kLong);
  folder.write("main/lib/.git", "gitdir: ../.git/modules/lib\n");
  CHECK(commit(folder, "main/lib/x.toml") == kLong);
}

TEST_CASE("a damaged or hostile repository has no commit, and is left in finite time") {
  const TemporaryFolder folder;
  folder.write("secret", kOne);
  for (const std::string& head :
       {std::string(), std::string("ref: "), std::string("ref: refs/../../secret"), std::string("ref: secret"),
        std::string("ref: refs/heads/a\0b", 19), std::string(39, '1'), std::string(40, 'G'), std::string(100'000, 'a')}) {
    folder.write(".git/HEAD", head);
    CHECK(commit(folder, "x.toml").empty());
  }
  folder.write(".git/HEAD", "ref: refs/heads/a");
  folder.write(".git/refs/heads/a", "ref: refs/heads/a");  // names itself
  CHECK(commit(folder, "x.toml").empty());
  fs::remove_all(folder / ".git");
  folder.write(".git", "gitdir: nowhere");
  CHECK(commit(folder, "x.toml").empty());
}

TEST_CASE("without a repository the service that runs the job names the commit, of files in its workspace alone") {
  const TemporaryFolder folder;
  const std::string inside = folder / "work/a/x.toml", outside = folder / "other/x.toml";
  const Environment github = environment({{"GITHUB_WORKSPACE", folder / "work"}, {"GITHUB_SHA", kOne}});
  const Environment gitlab = environment({{"CI_PROJECT_DIR", folder / "work/"}, {"CI_COMMIT_SHA", kTwo}});
  CHECK(commit_of(inside, github) == kOne);
  CHECK(commit_of(inside, gitlab) == kTwo);
  CHECK(commit_of(outside, github).empty());
  CHECK(commit_of(outside, gitlab).empty());
  CHECK(commit_of(inside, environment({{"GITHUB_WORKSPACE", folder / "work"}, {"GITHUB_SHA", "<script>"}})).empty());
  folder.write("work/.git/HEAD", kLong);  // the commit that is checked out comes before the one built
  CHECK(commit_of(inside, github) == kLong);
}
