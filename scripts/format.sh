#!/usr/bin/env bash
# The layout of the sources:
#   scripts/format.sh             lists what differs from .clang-format and what is longer than 125 columns
#   scripts/format.sh columns     only the long lines
#   scripts/format.sh layout      only what differs from .clang-format
#   scripts/format.sh fix         lays out all C++ sources by .clang-format; long lines elsewhere are left to the author
# Exit status 1 if anything is listed. clang-format 14, Debian 12's, decides: other versions lay out some lines differently.
# Exit status 77 where it is not installed.
# EVENSTEP_FORMAT_ROOT: the folder to look at, instead of this clone.
set -euo pipefail
repo=$(dirname -- "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")")
cd -- "${EVENSTEP_FORMAT_ROOT:-$repo}"
readonly columns=125

# files NAME... : those with these names, except in build folders, hidden folders and other people's code
files() {
  local name names=()
  for name in "$@"; do names+=(-o -name "$name"); done
  find . \( -path './build*' -o -path './.git' -o -name third_party \) -prune -o -type f \( "${names[@]:1}" \) -print0 |
    sort -z
}

clang_format() {
  local tool
  for tool in clang-format-14 clang-format; do
    if command -v "$tool" >/dev/null && "$tool" --version | grep -q 'version 14\.'; then
      printf '%s\n' "$tool"
      return 0
    fi
  done
  echo 'skipped: clang-format 14 is not installed' >&2
  exit 77
}

# Characters are counted, not bytes.
long_lines() {
  local found
  found=$(files '*.cpp' '*.h' '*.in' '*.cl' '*.sh' '*.cmake' CMakeLists.txt run |
    LC_ALL=C.UTF-8 xargs -0 grep -nE "^.{$((columns + 1)),}" /dev/null |
    sed -E "s/^([^:]*:[0-9]+):.*/\1: longer than $columns columns/") || true
  [[ ! $found ]] || { printf '%s\n' "$found"; return 1; }
}

other_layout() {
  local tool found
  tool=$(clang_format) || return
  found=$(files '*.cpp' '*.h' | xargs -0 "$tool" --style=file --dry-run 2>&1 |
    sed -nE 's/: warning: .*/: not as clang-format 14 lays it out (scripts\/format.sh fix)/p' | sort -V)
  [[ ! $found ]] || { printf '%s\n' "$found"; return 1; }
}

case ${1-} in
  columns) long_lines ;;
  layout) other_layout ;;
  fix) tool=$(clang_format) && files '*.cpp' '*.h' | xargs -0 -P "$(nproc)" -n 16 "$tool" --style=file -i ;;
  '')
    status=0
    long_lines || status=1
    other_layout || status=$?
    exit "$status"
    ;;
  *) echo "usage: scripts/format.sh [columns|layout|fix]" >&2; exit 2 ;;
esac
