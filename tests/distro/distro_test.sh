#!/usr/bin/env bash
# distro_test.sh SOURCE_DIR BUILD_DIR RELEASE [COMPILER] : goes from a bare clone of the committed state to ./run.sh and
# ./test.sh in a new Debian of this release (e.g. trixie), with its g++ or another compiler of it (e.g. clang++-19). Nothing
# may be warned of, every test must pass, ctest must know the same tests as in BUILD_DIR, and the scenarios of the paper must
# have the trace hashes that the program of BUILD_DIR gives them. With its own compiler the Debian packages are made and
# tried, too. Exit status 77 where such a Debian cannot be made.
# EVENSTEP_TESTS='-L ^docs$' : arguments of ./test.sh, in place of all tests
set -euo pipefail
source_dir=$1 build_dir=$2 release=$3 compiler=${4-}
source "$source_dir/tests/distro/new_debian.sh"

tests_of() { sed -nE 's/^ *Test +#[0-9]+: //p' | sort; }
# timed COMMAND : in the clone; its output is in $work/log, and shown if it fails. The build before it may not warn. Another
# compiler links the libstdc++ that the program will have: the one that g++ 13 brings lacks what Debian 13's libraries need.
timed() {
  local start=$SECONDS
  within env ${compiler:+"CXX=$compiler" LDFLAGS=-L/srv/lib} sh -c "cd /srv/evenstep && $1" >"$work/log" 2>&1 ||
    { tail -n 60 -- "$work/log"; return 1; }
  ! grep -nE 'warning: |^CMake.* Warning' "$debian"/srv/evenstep/build/{configure,build}.log || fail "the build warns"
  echo "$1: $((SECONDS - start)) s, with packages and build"
}

new_debian "$release"
quietly within apt-get update
# Who has a clone has git.
quietly within apt-get install -y --no-install-recommends git ${compiler:+"${compiler/clang++/clang}"}
within mkdir /srv/lib
within ln -s "$(within sh -c 'ls /usr/lib/*/libstdc++.so.6')" /srv/lib/libstdc++.so
git clone -q -- "$source_dir" "$debian/srv/evenstep"   # where tests that become another user can read it

timed './run.sh run scenarios/paper --out /srv/runs' || fail './run.sh'
quietly "$build_dir/apps/evenstep" run "$source_dir/scenarios/paper" --out "$work/runs"
trace_hashes "$work/runs" >"$work/hashes"
[[ -s $work/hashes ]] || fail "no trace hashes"
diff -- "$work/hashes" <(trace_hashes "$debian/srv/runs") || fail "other trace hashes (> $release)"

if [[ ! $compiler ]]; then
  quietly within apt-get install -y --no-install-recommends dpkg-dev file
  quietly within sh -c 'cd /srv/evenstep && cmake --build build && cpack --config build/CPackConfig.cmake -B /packages'
  try_packages
fi

if ! timed "./test.sh ${EVENSTEP_TESTS-}"; then
  # A test of a wall clock can fail beside other programs: what failed must pass alone, and is named.
  sed -n '/^The following tests FAILED/,$p' "$work/log" | grep . || fail "./test.sh"
  timed 'ctest --test-dir build --rerun-failed --no-tests=error --output-on-failure' || fail "tests, also alone"
fi
sed -n '/tests passed/,$p' "$work/log"
within sh -c '. /etc/os-release; echo "$PRETTY_NAME"; ${1:-c++} --version | head -1; cmake --version | head -1
  dpkg-query -W "*catch2*" 2>/dev/null || true' sh "$compiler"

ctest --test-dir "$build_dir" -N | tests_of >"$work/tests"
diff -- "$work/tests" <(within ctest --test-dir /srv/evenstep/build -N | tests_of) || fail "other tests (> $release)"
