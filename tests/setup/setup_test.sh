#!/usr/bin/env bash
# setup_test.sh SOURCE_DIR CASE : runs one case; prints what differed and exits 1 on failure, 77 when it cannot run here.
#
# Nothing is installed and nothing of the project is built. dpkg-query, apt-get, sudo, id and sleep are stand-ins that write
# each call into $work/calls. The project is a CMake project whose program is a shell script that prints what it was given.
# shellcheck disable=SC2016   # what is quoted here is expanded in the scripts into which it is written
set -uo pipefail
source_dir=$1
work=$(realpath -- "$(mktemp -d "${TMPDIR:-/tmp}/evenstep setup XXXXXX")")
trap 'chmod -R u+w "$work"; rm -rf "$work"' EXIT
chmod 755 "$work"   # some cases run as another user
cd "$work" || exit 1
unset XDG_CACHE_HOME EVENSTEP_LONG POCL_CACHE_DIR DEBIAN_FRONTEND
export EVENSTEP_TURN=all   # what .ci/run takes
touch out err calls

fail() {
  printf 'FAILED: %s\n' "$1"
  tail -n +1 calls out err
  exit 1
}
expect_status() { [[ $status == "$1" ]] || fail "exit $status instead of $1"; }
expect_out() { [[ $(cat out) == "$1" ]] || fail "stdout is not '$1'"; }
expect_err() { grep -qF -- "$1" err || fail "stderr does not say '$1'"; }
expect_calls() { [[ $(grep -v '^dpkg-query\|^apt-cache' calls) == "$1" ]] || fail "calls are not: $1"; }

# --- stand-ins for the system -----------------------------------------------------------------------------------------

# stand_in NAME <SCRIPT : makes a program in $work/bin that first writes its name and arguments into $work/calls
stand_in() {
  mkdir -p bin
  { printf '#!/bin/bash\nwork=%q\necho "${0##*/}${1:+ $*}" >>"$work/calls"\n' "$work"; cat; } >"bin/$1"
  chmod +x "bin/$1"
}

# system UID MISSING... : a Debian on which these packages are missing, as this user sees it
system() {
  local tool
  stand_in id <<<"echo $1"
  shift
  printf '%s\n' "$@" >missing
  stand_in dpkg-query <<'END'
status=0
for name in "${@:4}"; do   # after -W -f FORMAT
  if [[ $name == none ]] || grep -qxF -- "$name" "$work/missing"; then status=1; else echo "installed $name"; fi
done
exit "$status"
END
  stand_in apt-get <<'END'
echo "apt-get speaks on stdout"
[ "$DEBIAN_FRONTEND" = noninteractive ] || { echo "would ask questions"; exit 100; }
case " $* " in *" $(cat "$work/apt_fails" 2>/dev/null || echo nothing) "*) echo "E: it did not work"; exit 100 ;; esac
if [ -s "$work/lock_held" ]; then
  sed -i 1d "$work/lock_held"
  echo "E: Could not get lock /var/lib/apt/lists/lock. It is held by process 1 (apt-get)"
  exit 100
fi
if [[ " $* " == *" install "* ]]; then
  still_missing=$(grep -vxF -f <(printf '%s\n' "$@") -- "$work/missing")
  echo "$still_missing" >"$work/missing"
fi
END
  stand_in sleep <<<''
  stand_in apt-cache <<<''   # every package exists
  for tool in bash env sed sort comm grep mktemp tee rm cat tr true; do ln -sf "$(type -P "$tool")" bin/; done
}

sudo_here() {  # sudo_here accepts|refuses
  stand_in sudo <<<'[ "$1" = -n ] && shift
'"$([[ $1 == accepts ]] && echo 'exec "$@"' || echo 'echo "sudo: a password is required" >&2; exit 1')"
}

cat >install <<'END'
set -euo pipefail
repo=$1 build=$2
source "$repo/scripts/setup.sh"
if [[ ${WITH_TESTS-} ]]; then with_tests; fi
if [[ ${LIST-} ]]; then package_lists=("$LIST"); fi
install_packages
if [[ ${TWICE-} ]]; then with_tests; install_packages; fi
END
install() {
  PATH=$work/bin bash install "$source_dir" "$work/build" >out 2>err </dev/null
  status=$?
  [[ ! -s out ]] || fail "something was written to stdout"
}

readonly update='apt-get -o DPkg::Lock::Timeout=300 update'
readonly add='apt-get -o DPkg::Lock::Timeout=300 install -y --no-install-recommends'
readonly as_sudo='env DEBIAN_FRONTEND=noninteractive LC_ALL=C'

case_nothing_missing_means_no_apt_and_no_sudo() {
  sudo_here accepts
  system 1000
  install
  expect_status 0
  expect_calls ''
  [[ ! -s err ]] || fail "something was said"
}
# listed LIST : the packages that a list names, each alternative by itself
listed() { sed 's/#.*//; s/ | /\n/g; s/ *$//; /^$/d' "$source_dir/scripts/$1.txt"; }
asked_for() { grep -q -- "^dpkg-query .* $1\( \|$\)" calls; }

case_every_listed_package_is_asked_for() {
  local name
  system 0
  install
  [[ $(listed packages | wc -l) -ge 10 ]] || fail "no package list"
  while read -r name; do asked_for "$name" || fail "$name is not asked for"; done < <(listed packages)
}
case_what_only_tests_need_is_asked_for_only_by_them() {
  local name
  system 0 valgrind
  install
  expect_calls ''
  while read -r name; do ! asked_for "$name" || fail "$name is asked for"; done < <(listed test-packages)
  WITH_TESTS=1 install
  expect_calls "$(printf '%s\n' 'id -u' "$update" "$add valgrind")"
  while read -r name; do asked_for "$name" || fail "$name is not asked for"; done < <(listed packages; listed test-packages)
}
case_no_package_is_in_both_lists() {
  [[ -z $(comm -12 <(listed packages | sort) <(listed test-packages | sort)) ]] || fail "listed twice"
}
case_root_installs_exactly_what_is_missing() {
  system 0 ninja-build libglm-dev
  install
  expect_status 0
  expect_calls "$(printf '%s\n' 'id -u' "$update" "$add libglm-dev ninja-build")"
}
case_each_single_missing_package_is_found() {
  (
    repo=$source_dir
    source "$repo/scripts/setup.sh"
    with_tests
    dpkg-query() { local name; for name in "${@:4}"; do [[ " $absent " == *" $name "* ]] || echo "installed $name"; done; }
    mapfile -t wanted < <(packages_wanted)
    ((${#wanted[@]} >= 30)) || fail "no package lists"
    for absent in "${wanted[@]}"; do
      [[ $(packages_missing) == "$absent" ]] || fail "with $absent missing: $(packages_missing)"
    done
  ) || fail "not only that one is found"
}
case_on_a_bare_system_everything_is_installed() {
  local names
  mapfile -t names < <(listed packages | sort)
  system 0 "${names[@]}"
  install
  expect_calls "$(printf '%s\n' 'id -u' "$update" "$add ${names[*]}")"
}
case_the_lists_of_what_there_is_are_fetched_once() {
  system 0 libglm-dev valgrind
  TWICE=1 install
  expect_status 0
  expect_calls "$(printf '%s\n' 'id -u' "$update" "$add libglm-dev" 'id -u' "$add valgrind")"
}
# alternatives KNOWN... : one package is listed with two names, and another that a release may not have. Both are missing on
# a new system, which after apt-get update knows of these.
alternatives() {
  printf '%s\n' 'libold | libnew # one of the two' 'rare | none # a tool of a test' >list
  system 0 libold libnew rare
  printf '%s\n' "$@" >known
  stand_in apt-cache <<<'grep -q " update$" "$work/calls" && grep -qxF -e "$2" -- "$work/known"'
  LIST=list install
  expect_status 0
}
case_of_alternatives_the_first_is_installed_that_the_release_has() {
  alternatives libold libnew rare
  expect_calls "$(printf '%s\n' 'id -u' "$update" "$add libold rare")"
}
case_an_alternative_that_takes_the_place_of_the_first_is_named() {
  alternatives libnew rare
  expect_calls "$(printf '%s\n' 'id -u' "$update" "$add libnew rare")"
  expect_err 'this system has no package libold: libnew is installed in its place'
}
case_what_may_be_missing_from_a_release_is_left_out_and_named() {
  alternatives libnew
  expect_calls "$(printf '%s\n' 'id -u' "$update" "$add libnew")"
  expect_err 'this system has no package rare: what needs it is left out'
}
case_without_any_alternative_apt_says_what_is_missing() {
  alternatives rare
  expect_calls "$(printf '%s\n' 'id -u' "$update" "$add libold rare")"
}
case_where_nothing_is_left_to_install_apt_installs_nothing() {
  alternatives
  : >calls
  echo libnew >missing
  echo rare >>missing
  LIST=list install
  expect_status 0
  expect_calls "$(printf '%s\n' 'id -u' "$update")"
}
case_one_installed_alternative_is_enough() {
  printf '%s\n' 'libold | libnew' >list
  system 0 libold
  LIST=list install
  expect_status 0
  expect_calls ''
}
case_without_a_terminal_sudo_is_not_let_ask() {
  sudo_here accepts
  system 1000 libglm-dev
  install
  expect_status 0
  expect_calls "$(printf '%s\n' 'id -u' 'sudo -n true' \
    "sudo -n $as_sudo $update" "$update" "sudo -n $as_sudo $add libglm-dev" "$add libglm-dev")"
}
case_on_a_terminal_sudo_may_ask() {
  command -v script >/dev/null || { echo "skipped: no script(1) to make a terminal"; exit 77; }
  sudo_here accepts
  system 1000 libglm-dev
  export source_dir work
  SHELL=/bin/bash script -qec 'PATH=$work/bin bash install "$source_dir" "$work/build" >out' err >/dev/null </dev/null
  expect_out ''
  expect_calls "$(printf '%s\n' 'id -u' 'sudo true' \
    "sudo $as_sudo $update" "$update" "sudo $as_sudo $add libglm-dev" "$add libglm-dev")"
}
case_sudo_that_refuses_leaves_one_line_to_paste() {
  sudo_here refuses
  system 1000 libglm-dev cmake
  install
  expect_status 2
  expect_calls "$(printf '%s\n' 'id -u' 'sudo -n true')"
  [[ $(tail -1 err) == 'sudo apt-get update && sudo apt-get install -y --no-install-recommends cmake libglm-dev' ]] ||
    fail "no line to paste"
}
case_without_sudo_the_line_to_paste_uses_su() {
  system 1000 libglm-dev
  install
  expect_status 2
  expect_calls 'id -u'
  [[ $(tail -1 err) == "su -c 'apt-get update && apt-get install -y --no-install-recommends libglm-dev'" ]] ||
    fail "no line to paste"
}
case_a_failing_update_is_said_and_nothing_is_installed() {
  system 0 libglm-dev
  echo update >apt_fails
  install
  expect_status 2
  expect_err 'E: it did not work'
  expect_err 'apt-get update failed'
  expect_calls "$(printf '%s\n' 'id -u' "$update")"
}
case_a_failing_install_is_said() {
  system 0 libglm-dev
  echo install >apt_fails
  install
  expect_status 2
  expect_err 'E: it did not work'
  expect_err 'apt-get install failed'
}
case_a_lock_that_another_program_holds_is_waited_for() {
  system 0 libglm-dev
  printf 'once\ntwice\n' >lock_held
  install
  expect_status 0
  expect_err 'another program is using apt-get'
  expect_calls "$(printf '%s\n' 'id -u' "$update" 'sleep 5' "$update" 'sleep 5' "$update" "$add libglm-dev")"
}
case_elsewhere_than_on_debian_the_packages_are_named_and_the_build_goes_on() {
  system 0
  rm bin/dpkg-query
  install
  expect_status 0
  expect_calls ''
  expect_err 'not a Debian system'
  expect_err 'libglm-dev'
}

# --- a stand-in for the project ---------------------------------------------------------------------------------------

clone() {  # clone FOLDER
  mkdir -p "$1/scenarios/paper" "$1/scenarios/recorded"
  cp -r "$source_dir/run.sh" "$source_dir/test.sh" "$source_dir/CMakePresets.json" \
    "$source_dir/scripts" "$source_dir/.ci" "$1"
  cat >"$1/evenstep" <<'END'
#!/bin/bash
printf '[%s]' "$@"; echo
for ((i = 1; i < $#; i++)); do
  if [[ ${!i} == --out ]]; then j=$((i + 1)); mkdir -p "${!j}/a" "${!j}/b"; out=${!j}; fi
done
[[ ${out-} ]] || exit 0
echo '{"verdict":"pass","trace_hash":"0","expectations":[{"verdict":"pass"}]}' >"$out/a/summary.json"
echo '{"verdict":"pass","trace_hash":"0","expectations":[]}' >"$out/b/summary.json"
cd "$(dirname "$0")/../.."   # from build/apps or build/PRESET/apps
[[ -e scenarios/broken || -e ../scenarios/broken ]] || exit 0
echo '{"verdict":"fail","trace_hash":"0","expectations":[{"verdict":"pass"}]}' >"$out/b/summary.json"
exit 1
END
  cat >"$1/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.25)
project(stand_in LANGUAGES NONE)
set(program ${CMAKE_BINARY_DIR}/apps/evenstep)
add_custom_command(OUTPUT ${program} DEPENDS ${CMAKE_SOURCE_DIR}/evenstep VERBATIM
  COMMAND bash -n ${CMAKE_SOURCE_DIR}/evenstep COMMAND install ${CMAKE_SOURCE_DIR}/evenstep ${program}
  COMMAND bash -c "echo built >>builds")
file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/apps)
file(GLOB checked_by_every_build CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/scenarios/*)
add_custom_target(evenstep ALL DEPENDS ${program})
option(EVENSTEP_BUILD_TESTS "" ON)
if(EVENSTEP_BUILD_TESTS)
find_package(OnlyTestsNeedThis REQUIRED PATHS ${CMAKE_SOURCE_DIR} NO_DEFAULT_PATH)
add_subdirectory(tests/clock)
add_subdirectory(tests/compare)
foreach(name IN ITEMS faults test_clock test_scheduler test_ring test_remapper test_harness)
  add_custom_target(${name})
endforeach()
enable_testing()
add_test(NAME short COMMAND true)
add_test(NAME "clock: breakable" COMMAND bash -c "! cat broken" WORKING_DIRECTORY ${CMAKE_SOURCE_DIR})
add_test(NAME "setup: not under sanitizers" COMMAND test ${CMAKE_BINARY_DIR} = ${CMAKE_SOURCE_DIR}/build)
add_test(NAME slow COMMAND true)
set_tests_properties(slow PROPERTIES LABELS long)
foreach(label IN ITEMS million mutation newcomer distro)
  add_test(NAME ${label} COMMAND true)
  set_tests_properties(${label} PROPERTIES LABELS ${label})
endforeach()
endif()
END
  touch "$1/OnlyTestsNeedThisConfig.cmake"
  mkdir -p "$1"/tests/{clock,compare}
  for folder in clock compare; do
    printf '%s\n' 'add_custom_command(OUTPUT built COMMAND touch built)' "add_custom_target(of_$folder ALL DEPENDS built)" \
      >"$1/tests/$folder/CMakeLists.txt"
  done
  echo >"$1/tests/compare/validate.py"   # finds nothing to complain of
  stand_in dpkg-query <<<'shift 3; printf "installed %s\n" "$@"'
  PATH=$work/bin:$PATH
}
call() { "$@" >out 2>err </dev/null; status=$?; }

case_arguments_arrive_as_they_were_typed() {
  clone 'a clone'
  mkdir elsewhere
  ln -s "$work/a clone/run.sh" elsewhere/link
  cd elsewhere || exit 1
  "../a clone/run.sh" check 'two words' '' './relative.toml' '*' >../out 2>../err
  status=$?
  cd ..
  expect_status 0
  expect_out '[check][two words][][./relative.toml][*]'
  (cd elsewhere && ./link x >../out 2>../err) || fail "not through a symbolic link"
  expect_out '[x]'
}
case_relative_paths_start_where_the_caller_is() {
  clone c
  printf '#!/bin/sh\npwd\n' >c/evenstep
  mkdir elsewhere
  (cd elsewhere && ../c/run.sh a >../out 2>../err)
  expect_out "$work/elsewhere"
}
case_without_arguments_figure_1_is_run() {
  clone 'a clone'
  call 'a clone/run.sh'
  expect_status 0
  expect_out "[run][$work/a clone/scenarios/paper/figure-1.toml]"
}
case_what_is_built_is_not_built_again_until_a_source_changes() {
  clone c
  call c/run.sh a
  [[ -s err ]] || fail "the first build says nothing"
  call c/run.sh b
  [[ ! -s err ]] || fail "something is said when nothing is to do"
  [[ $(wc -l <c/build/builds) == 1 ]] || fail "built again"
  sed -i 's/\[%s\]/<%s>/' c/evenstep
  call c/run.sh c
  expect_out '<c>'
  expect_err 'building'
}
case_a_moved_clone_is_configured_afresh() {
  clone before
  call before/run.sh a
  mv before after
  sed -i 's/\[%s\]/<%s>/' after/evenstep
  call after/run.sh b
  expect_status 0
  expect_err 'configuring'
  expect_out '<b>'
}
case_a_copied_clone_leaves_the_first_alone() {
  clone first
  call first/run.sh a
  cp -a first second
  rm first/build/builds
  sed -i 's/\[%s\]/<%s>/' second/evenstep
  call second/run.sh b
  expect_out '<b>'
  [[ ! -e first/build/builds ]] || fail "the first clone was built"
}
case_an_interrupted_configuration_is_done_again() {
  clone c
  mkdir c/build
  printf 'CMAKE_HOME_DIRECTORY:INTERNAL=%s\n' "$work/c" >c/build/CMakeCache.txt
  call c/run.sh a
  expect_status 0
}
case_a_failing_build_exits_2_and_shows_why() {
  clone c
  echo 'if' >>c/evenstep
  call c/run.sh
  expect_status 2
  expect_out ''
  expect_err 'syntax error'
  expect_err 'the build failed'
}
case_a_failing_configuration_exits_2_and_shows_why() {
  clone c
  echo 'find_package(NoSuchThing REQUIRED)' >>c/CMakeLists.txt
  call c/run.sh
  expect_status 2
  expect_out ''
  expect_err 'NoSuchThing'
}
case_no_home_is_needed() {
  clone c
  call env -u HOME c/run.sh a
  expect_status 0
  call env HOME=/nonexistent c/run.sh a
  expect_status 0
}
case_opencl_kernels_are_cached_in_the_build_folder() {
  clone c
  printf '#!/bin/sh\necho "$POCL_CACHE_DIR"; test -w "$POCL_CACHE_DIR"\n' >c/evenstep
  call c/run.sh a
  expect_status 0
  expect_out "$work/c/build/pocl-cache"
  call env POCL_CACHE_DIR="$work/mine" c/run.sh a
  expect_out "$work/mine"
}
case_a_read_only_clone_is_built_in_a_folder_of_the_user() {
  local as_user=()
  clone c
  mkdir -m 777 cache tmp
  chmod 555 c
  if (($(id -u) == 0)); then
    command -v setpriv >/dev/null || { echo "skipped: root writes everywhere and setpriv is not here"; exit 77; }
    chmod 666 calls
    as_user=(setpriv --reuid 65534 --regid 65534 --clear-groups)
  fi
  sed -i 's,>>builds,>>builds,' c/CMakeLists.txt
  call env HOME=/nonexistent TMPDIR="$work/tmp" "${as_user[@]}" c/run.sh a
  expect_status 0
  expect_out '[a]'
  compgen -G 'tmp/evenstep-build-*/apps/evenstep' >/dev/null || fail "not built below TMPDIR"
  call env HOME=/nonexistent TMPDIR="$work/tmp" XDG_CACHE_HOME="$work/cache" "${as_user[@]}" c/run.sh b
  expect_out '[b]'
  compgen -G 'cache/evenstep-build-*/apps/evenstep' >/dev/null || fail "not built below XDG_CACHE_HOME"
  [[ ! -e c/build ]] || fail "something was written into the clone"
}
case_two_calls_at_once_build_once() {
  local i
  clone c
  sed -i 's/COMMAND install/COMMAND sleep 1 COMMAND install/' c/CMakeLists.txt
  for i in 1 2 3; do c/run.sh "$i" >"out $i" 2>"err $i" & done
  wait
  for i in 1 2 3; do [[ $(cat "out $i") == "[$i]" ]] || fail "call $i: $(cat "out $i" "err $i")"; done
  [[ $(wc -l <c/build/builds) == 1 ]] || fail "built $(wc -l <c/build/builds) times"
}
case_tests_are_run_without_the_long_ones_unless_asked_for() {
  clone c
  call c/test.sh
  expect_status 0
  grep -q '100% tests passed, 0 tests failed out of 3' out || fail "not three tests"
  call env EVENSTEP_LONG=1 c/test.sh
  grep -q '100% tests passed, 0 tests failed out of 8' out || fail "not eight tests"
  call c/test.sh -R short
  grep -q '100% tests passed, 0 tests failed out of 1' out || fail "arguments do not reach ctest"
}
case_running_needs_nothing_that_only_tests_need() {
  clone c
  rm c/OnlyTestsNeedThisConfig.cmake
  call c/run.sh a
  expect_status 0
  expect_out '[a]'
  call c/test.sh
  expect_status 2
  expect_err OnlyTestsNeedThis
}
case_the_program_and_the_tests_take_turns_in_one_build() {
  clone c
  call c/run.sh a
  call c/test.sh -R short
  expect_status 0
  expect_err 'configuring'
  call c/run.sh a
  call c/test.sh -R short
  expect_status 0
  [[ ! -s err ]] || fail "something is said when nothing is to do"
  [[ $(wc -l <c/build/builds) == 1 ]] || fail "the program was built again"
}
case_a_benchmark_begins_with_a_bare_clone_too() {
  clone c
  call c/scripts/bench.sh no-such-table
  expect_status 2
  expect_err 'configuring'
  expect_err "no table 'no-such-table'"
}
case_a_failing_test_and_no_test_at_all_are_failures() {
  clone c
  touch c/broken
  call c/test.sh
  expect_status 8
  rm c/broken
  call c/test.sh -R nothing_of_this_name
  [[ $status != 0 ]] || fail "no test at all counts as success"
}
case_the_check_installs_what_is_missing_and_counts_tests_and_scenarios() {
  clone c
  system 0 libglm-dev oclgrind
  call c/.ci/run
  expect_status 0
  # Tests: 4 (the long one too), 2 under asan-ubsan, 1 under tsan; 2 runs in each of 5 stages; the summaries.
  [[ $(tail -1 out) == '18 passed, 0 failed' ]] || fail "not 7 tests, 10 runs and the summaries"
  grep -qE '^ +[0-9]+ s +[0-9]+ s  scenarios: all, catalogue' out || fail "no seconds of a stage"
  grep -qE '^ +[0-9.]+ s  tsan, clock: breakable$' out || fail "no slowest tests"
  [[ $(grep '^apt-get' calls) == "$(printf '%s\n' "$update" "$add libglm-dev" "$add oclgrind")" ]] ||
    fail "not what the build needs, and then the rest"
}
case_the_check_counts_what_failed() {
  clone c
  touch c/scenarios/broken
  # The test that fails prints what ctest itself would print.
  printf '%s\n' '10% tests passed, 9 tests failed out of 10' 'The following tests FAILED:' '  1 - another (Failed)' >c/broken
  echo 'exit(1)' >c/tests/compare/validate.py
  call c/.ci/run
  expect_status 1
  [[ $(tail -1 out) == '9 passed, 9 failed' ]] || fail "not 4 tests, 5 runs and the summaries"
  [[ $(sed -n '/^== what failed/,/^$/p' out) == "== what failed
tests: release: 1
  clock: breakable (Failed)
scenarios: all: 1
scenarios: catalogue: 1"* ]] || fail "not what failed"
}
case_the_check_leaves_out_scenarios_that_are_long() {
  clone c
  mkdir c/scenarios/stiff c/scenarios/timing
  echo 'tags = ["paper"]' | tee c/scenarios/{stiff,timing}/short.toml >c/scenarios/timing/ten-minutes.toml
  echo 'tags = ["paper", "long"]' | tee c/scenarios/{stiff,timing}/minutes.toml >c/scenarios/recorded/hours.toml
  call c/.ci/run
  expect_status 0
  grep -qF '[run][scenarios/paper][scenarios/timing/short.toml][--repeat]' out || fail "not the short ones twice"
  grep -qF '[run][scenarios/stiff/short.toml][scenarios/extreme]' out || fail "not the catalogue without its long one"
  # All of recorded/ is left out, so the check passes the folder itself to the program, which says that nothing is left.
  grep -qF '[scenarios/sources][scenarios/recorded]' out || fail "not the folder"
  ! grep -qE 'minutes.toml|hours.toml' out || fail "a long scenario was run"
}
case_the_check_says_why_its_own_packages_could_not_be_installed() {
  clone c
  system 0 oclgrind
  echo install >apt_fails
  call c/.ci/run
  expect_status 2
  grep -qF 'E: it did not work' out || fail "apt-get's error is missing"
  expect_err 'what only the check needs could not be installed'
}
case_the_check_counts_a_stage_that_could_not_start() {
  clone c
  echo 'if' >>c/evenstep
  call c/.ci/run
  expect_status 1
  # The tests under tsan and the summaries pass.
  [[ $(tail -1 out) == '2 passed, 6 failed' ]] || fail "not 5 stages and a build failed"
}
case_the_check_counts_a_stage_that_ran_no_test() {
  clone c
  sed -i 's/clock: breakable/breakable/' c/CMakeLists.txt
  call c/.ci/run
  expect_status 1
  [[ $(tail -1 out) == '17 passed, 1 failed' ]] || fail "not the tests under tsan"
}
case_the_check_takes_one_turn_of_four() {
  local turn expected
  clone c
  cat >>c/CMakeLists.txt <<'END'
foreach(third IN ITEMS 1 2)
  add_test(NAME third-${third} COMMAND true)
  set_tests_properties(third-${third} PROPERTIES LABELS third-${third})
endforeach()
if(NOT CMAKE_BINARY_DIR MATCHES san)
  foreach(turn_and_name IN ITEMS 1-a 1-b 1-c 2-a 2-b 4-a)
    string(SUBSTRING ${turn_and_name} 0 1 turn)
    add_test(NAME turn-${turn_and_name} COMMAND true)
    set_tests_properties(turn-${turn_and_name} PROPERTIES LABELS turn-${turn})
  endforeach()
endif()
END
  # 6 tests and those of the turn (3, 2, 1), 8 runs and the summaries before any sanitizer. Then 3 tests and 2 runs, or one
  # test.
  for turn in 'third-1 23' 'third-2 22' 'threads 17'; do
    read -r turn expected <<<"$turn"
    rm -rf c/build
    EVENSTEP_TURN=$turn call c/.ci/run
    expect_status 0
    grep -qF "EVENSTEP_TURN=$turn .ci/run repeats it" out || fail "which turn it is"
    [[ $(tail -1 out) == "$expected passed, 0 failed" ]] || fail "not $expected passed"
    case $turn in
      third-1) [[ -e c/build/asan-ubsan/tests/clock/built && ! -e c/build/asan-ubsan/tests/compare/built ]] ;;
      third-2) [[ ! -e c/build/asan-ubsan/tests/clock/built && -e c/build/asan-ubsan/tests/compare/built ]] ;;
      threads) [[ ! -e c/build/asan-ubsan && -e c/build/tsan ]] ;;
    esac || fail "not what was to be built: $turn"
  done
  EVENSTEP_TURN= call c/.ci/run
  expect_status 0
  EVENSTEP_TURN=third-4 call c/.ci/run
  expect_status 2
  expect_err "EVENSTEP_TURN is 'third-4': expected all, third-1 third-2 third-3 threads"
}

declare -F "case_$2" >/dev/null || { echo "no case $2"; exit 2; }
"case_$2"
