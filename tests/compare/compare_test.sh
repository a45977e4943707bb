#!/usr/bin/env bash
# compare_test.sh PROGRAM SOURCE_DIR CASE : tests `evenstep compare`, `evenstep index` and what summary.json says about the
# origin of a run. Runs one case; prints what differed and exits 1 on failure, 77 when it cannot run here.
set -uo pipefail
evenstep=$1
source_dir=$2
work=$(mktemp -d "${TMPDIR:-/tmp}/evenstep compare XXXXXX")
trap 'chmod -R u+w "$work"; rm -rf "$work"' EXIT
cd "$work" || exit 1
unset GITHUB_ACTIONS GITHUB_WORKSPACE GITHUB_SHA GITHUB_STEP_SUMMARY CI_PROJECT_DIR CI_COMMIT_SHA EVENSTEP_CALLED_AS
unset SOURCE_DATE_EPOCH "${!GIT_@}"
export GIT_CONFIG_GLOBAL=/dev/null GIT_CONFIG_SYSTEM=/dev/null GIT_AUTHOR_NAME=a GIT_AUTHOR_EMAIL=a@b \
  GIT_COMMITTER_NAME=a GIT_COMMITTER_EMAIL=a@b
spring=$source_dir/scenarios/paper/figure-1-spring.toml

fail() { printf 'FAILED: %s\n--- stdout\n%s\n--- stderr\n%s\n' "$1" "$(head -c 3000 out)" "$(head -c 3000 err)"; exit 1; }
# expect CODE TEXT ARGUMENTS... : the program ends with this exit code and prints TEXT on stderr or stdout
expect() {
  local code=$1 text=$2
  shift 2
  "$evenstep" "$@" >out 2>err
  local got=$?
  [ "$got" -eq "$code" ] || fail "exit $got instead of $code: evenstep $*"
  grep -qF -- "$text" err out || fail "no '$text': evenstep $*"
}
# run OUT [SET]... : a short run of the spring
run() {
  local out=$1
  shift
  "$evenstep" run "$spring" --out "$out" --set run.duration="0.6 s" "$@" >out 2>err || [ $? -eq 1 ] || fail "run $out"
}
slower() { run "$1" --set timing.visualization="13 ms"; }
# a repository with one commit, in folder $1
repository() {
  command -v git >/dev/null || { echo "skipped: git is not installed"; exit 77; }
  git init -q -b main "$1" && cd "$1" || exit 1
}
# a scenario of a user, with visualizations of $1, in spring.toml
scenario() {
  printf '%s\n' 'format = 1' "extends = [\"$spring\"]" 'name = "mine"' \
    'expect = [{ signal = "left.force.phase_locked", metric = "late", equals = 0 }]' \
    '[run]' 'duration = "0.6 s"' 'strategies = ["phase_locked"]' '[timing]' "visualization = \"$1\"" >spring.toml
}
commit() { git add -A && git commit -qm "$1" || exit 1; }

case_equal_runs_are_bit_equal() {
  run a
  run b
  expect 0 "1 run bit-equal in all" compare a b
  grep -q 'worse' out && ! grep -q ' 0 worse' out && fail "something is worse"
  expect 0 "PASS" compare a b --fail-if 'worse > +0 %' --fail-if trace --fail-if missing --fail-if verdict
}
case_what_got_worse_stands_first_and_breaks_a_threshold() {
  run a
  slower b
  expect 1 "FAIL  latency > +5 %: so in 3 of" compare a b --fail-if 'latency > +5 %'
  sed -n '/^signal/{n;p}' out | grep -q 'latency .*worse; latency > +5 %' || fail "the broken threshold is not the first row"
  grep -q '^!  .*the scenarios differ: B has timing.visualization = .13 ms' out || fail "the change is not said"
  expect 0 "PASS" compare a b --fail-if 'latency > +50 %'
  expect 0 "better" compare b a --fail-if 'latency > +5 %'
  expect 1 '"breaks":["latency > +5 %"]' compare a b --fail-if 'latency > +5 %' --json
  python3 -c 'import json; json.load(open("out"))' || fail "no JSON"
}
case_usage_and_bad_input_exit_with_2() {
  run a
  expect 2 "--fail-if:1:1: error: 'latncy' is no metric; did you mean 'latency'?" compare a a --fail-if 'latncy > +5 %'
  expect 2 "no such file" compare a gone
  mkdir empty && expect 2 "has no run (summary.json) in it" compare a empty
  mkdir broken && echo '{"format":1' >broken/summary.json
  expect 2 "broken/summary.json:2:1: error: is not JSON" compare a broken
  mkdir new && sed 's/"format":1/"format":2/' a/summary.json >new/summary.json
  expect 2 "is of format 2, and this evenstep reads format 1" compare a new
  expect 3 "cannot be written" compare a a --markdown nowhere/x.md
  expect 2 "b is missing: " compare a
}
case_folders_lists_and_summaries_are_compared() {
  "$evenstep" run "$source_dir/scenarios/paper/figure-1-spring.toml" "$source_dir/scenarios/timing/jitter-1.toml" \
    --set run.duration="0.6 s" --out all >out 2>err
  [ -e all/figure-1-spring/summary.json ] || fail "no runs"
  expect 0 "2 runs bit-equal in all" compare all all
  "$evenstep" run "$source_dir/scenarios/paper/figure-1-spring.toml" "$source_dir/scenarios/timing/jitter-1.toml" \
    --set run.duration="0.6 s" --out again --json >all.json 2>err
  expect 0 "2 runs bit-equal in all" compare all all.json
  expect 0 "1 run bit-equal in all" compare all/figure-1-spring again/figure-1-spring/summary.json
  rm -r again/jitter-1
  expect 1 "is only in A: B has no such run" compare all again
  expect 0 "is only in A: B has no such run" compare all again --allow-missing
  expect 0 "is only in B: there is nothing to compare it with" compare again all
}
case_markdown_and_page_say_the_same() {
  run a
  slower b
  expect 1 "FAIL" compare a b --fail-if 'latency > +5 %' --markdown c.md --html c.html
  grep -q '^### evenstep: FAIL' c.md || fail "no headline"
  grep -q '^| left.force.phase\\_locked | ' c.md || fail "no row"
  grep -qF '</html>' c.html || fail "no page"
  grep -qF "compare a b --fail-if &#39;latency &gt; +5 %&#39; --html c.html" c.html || fail "no command"
}
case_index_of_a_folder_of_runs() {
  SOURCE_DATE_EPOCH=1700000000 run runs/1/spring
  SOURCE_DATE_EPOCH=1700086400 slower runs/2/spring
  rm -f runs/*/spring/report.html
  expect 0 "2 runs: runs/index.html" index runs
  grep -q '2023-11-14T22:13:20Z' runs/index.html || fail "no date"
  grep -q '<polyline' runs/index.html || fail "no trend"
  grep -qF 'href="./2/spring/summary.json"' runs/index.html || fail "no link"
  touch runs/2/spring/report.html
  expect 0 "2 runs" index runs
  grep -qF 'href="./2/spring/report.html"' runs/index.html || fail "no link to the report"
  echo '<p>mine</p>' >runs/index.html
  expect 2 "index\`, and is left alone" index runs
  expect 2 "is no folder" index runs/index.html
  mkdir empty && expect 2 "has no run" index empty
  rm runs/index.html && echo '{' >runs/1/spring/summary.json
  expect 2 "1 runs: runs/index.html" index runs
  expect 0 "1 runs: runs/2/spring/index.html" index runs/2/spring
}
case_a_run_bears_the_date_and_the_commit_of_the_users_repository() {
  SOURCE_DATE_EPOCH=0 run a
  grep -q '"date":"1970-01-01T00:00:00Z","commit":' a/summary.json || fail "no date"
  run b
  grep -qE "\"date\":\"20[0-9]{2}-.*Z\"" b/summary.json || fail "no date of today"
  SOURCE_DATE_EPOCH=soon expect 2 "SOURCE_DATE_EPOCH: error: 'soon' is no number of seconds" run "$spring"
  repository repo
  scenario "11.1 ms"
  "$evenstep" run spring.toml --out ../none >out 2>err
  grep -q '"commit":null' ../none/summary.json || fail "a commit before the first"
  commit one
  mkdir elsewhere && cd elsewhere || exit 1
  "$evenstep" run ../spring.toml --out ../../one >out 2>err
  grep -q "\"commit\":\"$(git rev-parse HEAD)\"" ../../one/summary.json || fail "another commit"
  cd .. && git pack-refs --all && git worktree add -q ../tree -b side && cd ../tree || exit 1
  git commit -q --allow-empty -m two
  "$evenstep" run spring.toml --out ../two >out 2>err
  grep -q "\"commit\":\"$(git rev-parse HEAD)\"" ../two/summary.json || fail "another commit in a worktree"
  cd ../repo && git checkout -q --detach side
  "$evenstep" run spring.toml --out ../three >out 2>err
  grep -q "\"commit\":\"$(git rev-parse side)\"" ../three/summary.json || fail "another commit with a detached head"
}
case_git_bisect_finds_the_commit_that_made_it_slower() {
  repository repo
  for number in 1 2 3 4 5 6 7 8 9; do
    [ "$number" -lt 6 ] && scenario "11.1 ms" || scenario "13 ms"
    [ "$number" -ne 4 ] || echo 'broken = yes' >spring.toml   # a commit that cannot be judged
    echo "$number" >number
    commit "commit $number"
    [ "$number" -ne 1 ] || "$evenstep" run spring.toml --out ../before >/dev/null 2>&1
  done
  git bisect start HEAD HEAD~8 >/dev/null || exit 1
  export evenstep
  git bisect run sh -c '"$evenstep" run spring.toml --out ../now || test $? = 1 || exit 125
    "$evenstep" compare ../before ../now --fail-if "latency > +5 %"' >out 2>err || fail "bisect"
  local found
  found=$(git show -s --format=%s refs/bisect/bad)
  [ "$found" = "commit 6" ] || fail "another commit: $found"
}
case_every_summary_fits_the_schema() {
  python3 -c 'import jsonschema' 2>/dev/null || { echo "skipped: python3-jsonschema is not installed"; exit 77; }
  "$evenstep" schema summary >schema.json || fail "no schema"
  cmp -s schema.json "$source_dir/docs/schema/summary-1.json" || fail "another schema than docs/schema/summary-1.json"
  expect 2 "there is no such schema" schema summery
  # Shipped scenarios, each shorter than its expectations need. They fail, but their summaries must fit the schema. (.ci/run
  # validates the summaries of the scenarios that it runs, which it does not shorten.)
  "$evenstep" run "$source_dir"/scenarios/{paper,timing,sizing,safety} --long --out all \
    --set run.duration="0.4 s" --set run.warmup="0.1 s" >out 2>err
  # Only the cases that take a second at most, as the summaries of all cases have the same form.
  "$evenstep" run "$source_dir"/scenarios/extreme/{diverged,hand-jump,unstable-step,s16-degenerate,s18-devices}.toml \
    --out cases >>out 2>>err
  "$evenstep" run --clock wall "$source_dir/scenarios/live/figure-1-spring.toml" --set run.duration="0.4 s" --out live \
    >>out 2>>err
  mkdir bad && echo 'format = 2' >bad/a.toml && echo 'format = 1' >bad/b.toml
  "$evenstep" run bad --out broken >>out 2>>err
  python3 "$source_dir/tests/compare/validate.py" --every-key schema.json all cases live broken >out 2>err ||
    fail "summaries and schema"
}

declare -F "case_$3" >/dev/null || { echo "no case '$3'"; exit 1; }
"case_$3"
