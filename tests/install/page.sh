# shellcheck shell=bash disable=SC2154
# Runs the commands and listings of docs/begin/install.md exactly as they are there, in the home of a user who has nothing
# yet. install_test.sh sources this file. Only the block that builds all of evenstep is not run again, except for its last
# line.
page=$source_dir/docs/begin/install.md

# block NAME : the lines of the block below <!-- page: NAME -->
block() {
  awk -v mark="<!-- page: $1 -->" \
    '$0 == mark { found = 1 } found && /^```/ { if (inside) exit; inside = 1; next } inside' "$page"
}
named=$(sed -nE 's/^<!-- page: (.*) -->$/\1/p' "$page" | tr '\n' ' ')
[[ $named == 'all run small CMakeLists.txt main.cpp find pkg-config fetch debian ' ]] || fail "other blocks: $named"
[[ $(grep -c '^```[a-z]' "$page") == 9 ]] || fail "a block without a name"

export HOME=$here

[[ $(block all | head -2) == $'cmake --preset release\ncmake --build build' ]] || fail "another way to build"
block all | tail -1 | sed "s@ build @ $(basename -- "$build_dir") @" >all.sh
(cd -- "$(dirname -- "$build_dir")" && quietly bash "$here/all.sh")
mkdir -p elsewhere
(cd elsewhere && block run >"$here/run.sh" && quietly bash -euo pipefail "$here/run.sh")

mkdir source
tar -C "$source_dir" --exclude=./build --exclude=./.git --exclude='./build-*' -c . | tar -C source -x
# Without optimization and with all sources of a room as one, which takes a quarter of the time.
cmake() {
  if [[ $1 == -S ]]; then set -- "$@" -D CMAKE_UNITY_BUILD=ON; fi
  command cmake "$@"
}
(export -f cmake && cd source && block small >"$here/small.sh" &&
  CMAKE_BUILD_TYPE=None CMAKE_BUILD_PARALLEL_LEVEL=2 quietly bash -euo pipefail "$here/small.sh")

mkdir mine
cd mine
block CMakeLists.txt >CMakeLists.txt
block main.cpp >main.cpp
block find >../find.sh
quietly bash -euo pipefail ../find.sh
grep -q '^ready$' ../log || fail "the page's program does not run"
if command -v pkg-config >/dev/null; then
  block pkg-config >../pkg-config.sh
  quietly bash -euo pipefail ../pkg-config.sh
  [[ $(./my_simulator) == ready ]] || fail "the page's program does not run"
fi

{ sed '/find_package/d; /target_link/d' CMakeLists.txt; block fetch; } >fetch.txt
mv fetch.txt CMakeLists.txt
rm -r build
quietly cmake -S . -B build -D FETCHCONTENT_SOURCE_DIR_EVENSTEP="$source_dir"

cmp <(block debian) <(bash "$source_dir/tests/install/debian_test.sh" commands) || fail "debian_test.sh runs other commands"
