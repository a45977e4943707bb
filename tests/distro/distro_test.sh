#!/usr/bin/env bash
# distro_test.sh SOURCE_DIR BUILD_DIR RELEASE : goes from a bare clone of the committed state to ./run.sh and ./test.sh in a
# new Debian of this release (e.g. trixie). Nothing may be warned of, every test must pass, ctest must know the same tests as
# in BUILD_DIR, and the scenarios of the paper must have the trace hashes that the program of BUILD_DIR gives them. Exit
# status 77 where such a Debian cannot be made. EVENSTEP_TESTS='-L ^docs$' : arguments of ctest, in place of all tests
set -euo pipefail
source_dir=$1 build_dir=$2 release=$3
source "$source_dir/tests/distro/new_debian.sh"

trace_hashes() { grep -rho '"trace_hash":"[0-9a-f]*"' --include=summary.json "$1" | sort; }
tests_of() { sed -nE 's/^ *Test +#[0-9]+: //p' | sort; }
without_warnings() {
  ! grep -n 'warning: ' "$debian/srv/evenstep/build/build.log" "$debian/srv/evenstep/build/configure.log" ||
    fail "the build of $1 has warnings"
}

new_debian "$release"
quietly within apt-get update
quietly within apt-get install -y --no-install-recommends git   # who has a clone has it
# Where tests that become another user can read it.
git clone -q -- "$source_dir" "$debian/srv/evenstep"
start=$SECONDS
quietly within sh -c 'cd /srv/evenstep && ./run.sh run scenarios/paper --out ~/runs'
without_warnings ./run.sh
echo "./run.sh run scenarios/paper: $((SECONDS - start)) s, with packages and build"
within sh -c '. /etc/os-release; echo "$PRETTY_NAME"; c++ --version | head -1; cmake --version | head -1
  grep -h "^#define CATCH_VERSION_M" /dev/null $(find /usr/include/catch2 -name "catch_version_macros.hpp")' || true

"$build_dir/apps/evenstep" run "$source_dir/scenarios/paper" --out "$work/runs" >"$work/log" 2>&1 ||
  fail "the paper's scenarios fail with the program of $build_dir"
diff <(trace_hashes "$work/runs") <(trace_hashes "$debian/root/runs") || fail "other trace hashes (> $release)"

start=$SECONDS
# shellcheck disable=SC2086   # words
within sh -c 'cd /srv/evenstep && ./test.sh "$@"' sh ${EVENSTEP_TESTS-} >"$work/log" 2>&1 ||
  { sed -n '/tests passed/,$p' "$work/log"; fail "./test.sh"; }
without_warnings ./test.sh
sed -n '/tests passed/,$p' "$work/log"
echo "./test.sh: $((SECONDS - start)) s, with packages and build"
diff <(ctest --test-dir "$build_dir" -N | tests_of) <(within ctest --test-dir /srv/evenstep/build -N | tests_of) ||
  fail "ctest has other tests (> $release)"
