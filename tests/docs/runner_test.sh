#!/usr/bin/env bash
# runner_test.sh PROGRAM BUILD_DIR : checks that docs_test.py reports what is wrong with a page, and nothing that is right.
set -uo pipefail
program=$1
build=$2
here=$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")
source_dir=$(dirname -- "$(dirname -- "$here")")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/docs" "$work/loop"
ln -s "$source_dir/scenarios" "$source_dir/cmake" "$work"
cp "$source_dir/README.md" "$source_dir/run.sh" "$work"
printf 'int one_line = 1;\n' >"$work/loop/a.cpp"

fail() { echo "FAILED: $*"; cat "$work/out"; exit 1; }
# page INFO LINES... : a page with this block
page() { printf '# Page\n\n```%s\n' "$1" >"$work/docs/page.md"; printf '%s\n' "${@:2}" '```' >>"$work/docs/page.md"; }
check() { python3 "$here/docs_test.py" "$program" "$work" "$build" docs/page.md >"$work/out" 2>&1; }
right() { page "$@"; check || fail "a right page is refused: $*"; }
wrong() {  # wrong MESSAGE INFO LINES...
  page "${@:2}"
  check && fail "a wrong page is accepted: ${*:2}"
  grep -q "^docs/page.md:[0-9]*: $1" "$work/out" || fail "another message than '$1': ${*:2}"
}

right console '$ evenstep --version' 'evenstep ...'
right console '$ echo a; echo b; echo c' '...' 'b' '...'
right console '$ echo progress >&2; echo a' 'a'
right console '$ false' '$ echo $?' '1' '$ X=7' '$ echo $X' '7'
wrong 'prints something else' console '$ evenstep --version' 'evenstep 99.0'
wrong 'prints something else' console '$ echo a; echo b' 'a'
wrong 'exit 1: false' console '$ false' '$ echo now'
wrong 'exit 2: evenstep run --sed' console '$ evenstep run --sed 7'
right sh './run.sh check my.toml   # a comment'
wrong 'exit 2: evenstep check gone.toml' sh 'evenstep check my.toml' 'evenstep check gone.toml'
wrong 'no such file: scripts/bench.sh' sh 'scripts/bench.sh'
right toml '[remap]' 'latency = "20 ms"'
wrong '`evenstep check` exits with 2' toml '[remap]' 'latncy = "20 ms"'
wrong '`evenstep check` exits with 2' toml 'format = 1' 'name = "x"' '[timing]' 'steps = 0'
right cpp 'int one_line = 1;'
wrong 'no source has this line' cpp 'int one_line = 2;'
right cmake 'evenstep_add_scenarios(DIRECTORY x)'
wrong 'no such function' cmake 'evenstep_add_sonatas(DIRECTORY x)'
right text 'anything'
wrong "a block of ''" '' 'evenstep run'
echo ok
