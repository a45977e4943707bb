#!/usr/bin/env bash
# The examples of docs/parts/extending.md as patches:
#   extending_test.sh SOURCE_DIR count              each patch applies and changes no more existing code files than promised
#   extending_test.sh SOURCE_DIR build WORK_DIR     with all patches, a copy builds, keeps the room rules, and each example
#                                                   works
# Code files are those of the product: sources and headers, neither tests nor docs nor lists of files (CMakeLists.txt).
set -euo pipefail
source_dir=$(realpath "$1")
here=$source_dir/tests/extending
# Existing code files that a change of this kind may touch.
declare -A allowed=([strategy]=3 [scene]=3 [driver]=2 [timing-model]=4 [command]=1 [metric]=2)

fail() { echo "extending: $*" >&2; exit 1; }

# copy_tree TO : copies what git tracks here or, without git, everything except build folders
copy_tree() {
  mkdir -p "$1"
  (cd "$source_dir" && { git ls-files -z 2>/dev/null || find . -path './build*' -prune -o -type f -print0; } |
    xargs -0 cp --parents -t "$1")
}

# touched PATCH : the existing code files that it changes
touched() {
  sed -nE 's|^--- a/(.*)$|\1|p' "$1" | grep -E '\.(h|hpp|cpp|cl)$' | grep -vE '^(tests|docs|bench|examples)/' || true
}

count() {
  local kind files number
  copy=$(mktemp -d)
  trap 'rm -rf "$copy"' EXIT
  copy_tree "$copy"
  for kind in "${!allowed[@]}"; do
    [[ -e $here/$kind.patch ]] || fail "there is no $kind.patch"
    (cd "$copy" && git apply --check "$here/$kind.patch") || fail "$kind.patch does not apply any more"
    files=$(touched "$here/$kind.patch")
    number=$(grep -c . <<<"$files" || true)
    ((number <= allowed[$kind])) ||
      fail "a new $kind changes $number existing code files, not ${allowed[$kind]}:"$'\n'"$files"
    echo "$kind: $number existing code files (at most ${allowed[$kind]})"
  done
}

build() {
  local kind evenstep out
  copy=$1/copy
  rm -rf "$copy"
  copy_tree "$copy"
  for kind in "${!allowed[@]}"; do
    # Without the ceiling, git would find the repository around the build folder and leave out files that are not below that
    # folder.
    (cd "$copy" && GIT_CEILING_DIRECTORIES=$(realpath "$1") git apply "$here/$kind.patch") ||
      fail "$kind.patch does not apply beside the others"
  done
  (cd "$copy" && cmake --preset release -D EVENSTEP_BUILD_TESTS=OFF) >"$1/configure.log" 2>&1 ||
    { cat "$1/configure.log"; fail "the copy cannot be configured"; }
  cmake --build "$copy/build" --target evenstep --parallel "$(nproc)" >"$1/build.log" 2>&1 ||
    { tail -50 "$1/build.log"; fail "the copy does not build"; }
  python3 "$copy/tests/room_rules/room_rules.py" "$copy" || fail "the examples break a room rule"
  evenstep=$copy/build/apps/evenstep
  "$evenstep" run "$here/examples.toml" --out "$1/run" || fail "examples.toml fails"
  out=$("$evenstep" units)
  grep -q 'N/m' <<<"$out" || fail "the command 'units' does not list N/m: $out"
  echo "extending: all six examples build, keep the rules and work"
}

case ${2:-} in
  count) count ;;
  build) build "$3" ;;
  *) echo 'usage: extending_test.sh SOURCE_DIR count | build WORK_DIR' >&2; exit 2 ;;
esac
