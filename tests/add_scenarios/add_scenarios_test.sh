#!/usr/bin/env bash
# add_scenarios_test.sh PROGRAM SOURCE_DIR CASE : runs one case; prints what differed and exits with 1 if it fails.
# The projects here find a package that has only the program and the function. Other tests check that the real package can be
# installed and found.
set -uo pipefail
evenstep=$1
source_dir=$2
work=$(mktemp -d "${TMPDIR:-/tmp}/evenstep add XXXXXX")
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
unset GITHUB_ACTIONS

fail() { printf 'FAILED: %s\n--- log\n%s\n' "$1" "$(tail -c 4000 log 2>/dev/null)"; exit 1; }
has() { grep -qF -- "$1" log || fail "no '$1'"; }

mkdir package
cat >package/evenstepConfig.cmake <<END
add_executable(evenstep::evenstep IMPORTED)
set_target_properties(evenstep::evenstep PROPERTIES IMPORTED_LOCATION "$evenstep")
include("$source_dir/cmake/EvenstepScenarios.cmake")
END
cat >package/evenstepConfigVersion.cmake <<'END'
set(PACKAGE_VERSION 0.2.0)
set(PACKAGE_VERSION_COMPATIBLE TRUE)
END

# project LINES... : a CMakeLists.txt with these lines after enable_testing()
project() {
  { printf '%s\n' 'cmake_minimum_required(VERSION 3.25)' 'project(toy LANGUAGES NONE)' 'find_package(evenstep REQUIRED)' \
      'enable_testing()' "$@"; } >CMakeLists.txt
}
configure() { cmake -S . -B build -G Ninja -Devenstep_DIR="$work/package" >log 2>&1; }
# tests ARGUMENTS... : the names of the tests that ctest would run
tests() { ctest --test-dir build -N "$@" | sed -nE 's/^ *Test +#[0-9]+: //p'; }

# is_refused CALL WHY : whether CMake refuses a project with this call, and says why
is_refused() {
  project "$1"
  configure && fail "accepted: $1"
  tr '\n' ' ' <log | sed -E 's/ +/ /g' >flat && mv flat log
  has "$2"
}

# scenario FILE LINE... : writes a scenario that passes, with these lines added
scenario() {
  mkdir -p "$(dirname "$1")"
  { printf '%s\n' 'format = 1' "extends = [\"$source_dir/examples/ctest/scenarios/renderer.toml\"]" 'name = "toy"' \
      'expect = [{ signal = "left.force.phase_locked", metric = "underruns", equals = 0 }]'; printf '%s\n' "${@:2}"; } >"$1"
}
toy() {
  scenario scenarios/passing.toml 'tags = ["quick", "two words"]'
  scenario scenarios/failing.toml '[remap]' 'latency = "5 ms"'
  scenario scenarios/broken.toml '[remap]' 'latncy = "5 ms"'
  scenario scenarios/below/slow.toml 'tags = [' '  "long",  # minutes' ']'
  printf 'format = 1\nextends = ["slow.toml"]\nname = "y"\n' >scenarios/below/inherits.toml
}

case_a_test_per_scenario_with_its_verdict() {
  toy
  project 'evenstep_add_scenarios(DIRECTORY scenarios)'
  configure || fail "cannot be configured"
  [ "$(tests | xargs -d '\n' printf '%s, ')" = \
    'scenario: scenarios/broken.toml, scenario: scenarios/failing.toml, scenario: scenarios/passing.toml, ' ] ||
    fail "other names: $(tests)"
  ctest --test-dir build --output-on-failure >log 2>&1 && fail "a scenario that fails is no failure"
  has "2 tests failed out of 3"
  has "1 - scenario: scenarios/broken.toml (Failed)"
  has "scenarios/broken.toml:6:1: error: unknown key 'latncy'"
  has "scenarios/failing.toml:4"
  has "again: $(printf '%q' "$evenstep")"
  for name in passing failing; do
    [ -e build/evenstep-runs/scenarios/$name/summary.json ] || fail "no run folder of $name"
  done
  [ -z "$(find . -path ./build -prune -o -name summary.json -print)" ] || fail "something is written beside the sources"
}
case_labels_are_those_given_and_the_tags_also_inherited_ones() {
  toy
  project 'evenstep_add_scenarios(DIRECTORY scenarios RECURSE LABELS haptics nightly)'
  configure || fail "cannot be configured"
  [ "$(tests | wc -l)" -eq 5 ] || fail "not five: $(tests)"
  [ "$(tests -L '^haptics$' -L '^nightly$' | wc -l)" -eq 5 ] || fail "LABELS are missing"
  [ "$(tests -L '^long$')" = $'scenario: scenarios/below/inherits.toml\nscenario: scenarios/below/slow.toml' ] ||
    fail "long: $(tests -L '^long$')"
  [ "$(tests -L '^two words$')" = 'scenario: scenarios/passing.toml' ] || fail "a tag of two words is not one label"
}
case_a_new_scenario_is_found_by_the_next_build_and_run_folders_are_not_searched() {
  toy
  project 'evenstep_add_scenarios(DIRECTORY scenarios RECURSE)' 'add_custom_target(nothing ALL)'
  configure || fail "cannot be configured"
  scenario scenarios/new.toml
  "$evenstep" run scenarios/new.toml --out scenarios/runs/new >log 2>&1 || fail "the new scenario does not pass"
  cmake --build build >log 2>&1 || fail "no build"
  [ "$(tests | wc -l)" -eq 6 ] || fail "not the new one alone: $(tests)"
}
case_a_folder_elsewhere_is_named_by_its_last_part() {
  toy
  mkdir project && cd project || exit 1
  project 'evenstep_add_scenarios(DIRECTORY ../scenarios)'
  configure || fail "cannot be configured"
  [ "$(tests -R passing)" = 'scenario: scenarios/passing.toml' ] || fail "$(tests)"
  ctest --test-dir build -R passing >log 2>&1 || fail "does not pass"
  [ -e build/evenstep-runs/scenarios/passing/summary.json ] || fail "the run folder is elsewhere"
}
case_a_program_of_your_own_runs_them() {
  toy
  printf '#!/bin/sh\necho mine: "$@"\nexec "%s" "$@"\n' "$evenstep" >mine
  chmod +x mine
  project 'add_executable(mine IMPORTED)' \
    'set_target_properties(mine PROPERTIES IMPORTED_LOCATION "${CMAKE_SOURCE_DIR}/mine")' \
    'evenstep_add_scenarios(DIRECTORY scenarios PROGRAM mine)'
  configure || fail "cannot be configured"
  ctest --test-dir build -R passing -V >log 2>&1 || fail "does not pass"
  has "mine: run scenarios/passing.toml --out"
}
case_a_test_per_recording_says_whether_what_the_program_has_is_enough() {
  mkdir -p recordings
  cp "$source_dir"/scenarios/recorded/{small-paced30-basic,h100-contended}.csv recordings
  printf 'no recording\n' >recordings/README.md
  project 'evenstep_add_sizing(NAME arm RECORDINGS recordings LATENCY "45 ms" RINGS 128 64 MAP phase_locked LABELS nightly' \
    '  OPTIONS --sampling "2 kHz")' 'add_custom_target(nothing ALL)'
  configure || fail "cannot be configured"
  [ "$(tests -L '^nightly$')" = \
    $'sizing: arm: recordings/h100-contended.csv\nsizing: arm: recordings/small-paced30-basic.csv' ] || fail "$(tests)"
  ctest --test-dir build --output-on-failure >log 2>&1 && fail "a latency that is too little is no failure"
  has "1 tests failed out of 2"
  has "1 - sizing: arm: recordings/h100-contended.csv (Failed)"
  has "latency 45.000000 ms is 6.942434 ms too little: phase_locked needs 51.942434 ms."
  has "again: $(printf '%q' "$evenstep") size recordings/h100-contended.csv --sampling '2 kHz' --fits"
  "$evenstep" index build/evenstep-runs/sizing >log 2>&1 || fail "its run folders cannot be listed"
  has "2 runs: build/evenstep-runs/sizing/index.html"
  sed -i 's/ OPTIONS/ PER "1 h" CONFIDENCE "90 %" OPTIONS/' CMakeLists.txt
  cmake --build build >log 2>&1 || fail "no build"
  ctest --test-dir build --output-on-failure >log 2>&1 && fail "nobody knows an hour from 20 s of it"
  has "what phase_locked needs for so long cannot be known: "
  has ", per 1 h, confidence 90 %'"
  # What is no recording, or a new one, is not passed over.
  printf 'some notes\n' >recordings/notes.txt
  cmake --build build >log 2>&1 || fail "no build"
  ctest --test-dir build -R notes >log 2>&1 && fail "a file that cannot be read is no failure"
  has "1 tests failed out of 1"
}
case_mistakes_in_a_sizing_are_errors_with_a_remedy() {
  mkdir empty
  for wrong in 'NAME a RECORDINGS empty LATENCY "1 ms"@no recording in' 'NAME a LATENCY "1 ms"@RECORDINGS, or all' \
    'NAME a RECORDINGS empty@LATENCY, LEAD and RINGS are missing' \
    'NAME a RECORDINGS empty LATENCY "1 ms" LEAD@not understood' \
    'NAME a RECORDINGS empty LATENCY "1 ms" WITH x@not understood'; do
    is_refused "evenstep_add_sizing(${wrong%@*})" "${wrong#*@}"
  done
}
case_mistakes_are_errors_with_a_remedy() {
  mkdir empty
  for wrong in 'DIRECTORY empty@no scenario (*.toml) in' 'DIRECTORY nowhere@no scenario (*.toml) in' \
    'LABELS x@DIRECTORY is missing' 'DIRECTORY empty WITH x@not understood' \
    'DIRECTORY empty PROGRAM nobody@is not a'; do
    is_refused "evenstep_add_scenarios(${wrong%@*})" "${wrong#*@}"
  done
  project 'evenstep_add_scenarios(DIRECTORY empty)'
  sed -i '/^enable_testing/d' CMakeLists.txt
  configure && fail "accepted without enable_testing()"
  has "enable_testing()"
}
case_it_adds_nothing_where_testing_is_off() {
  project 'set(BUILD_TESTING OFF)' 'evenstep_add_scenarios(DIRECTORY nowhere)'
  configure || fail "an error where testing is off"
}
case_the_example_has_three_tests_and_all_pass() {
  cp -r "$source_dir/examples/ctest" example && cd example || exit 1
  configure || fail "the example cannot be configured"
  [ "$(tests -L '^haptics$' -LE '^long$')" = \
    $'scenario: scenarios/renderer.toml\nsizing: renderer: recordings/a-second.csv' ] || fail "$(tests)"
  [ "$(tests -L '^long$')" = 'scenario: scenarios/slow/jitter.toml' ] || fail "long: $(tests -L '^long$')"
  ctest --test-dir build --output-on-failure >log 2>&1 || fail "the example fails"
}

"case_$3"
