#!/usr/bin/env bash
# Counts the instructions of the core paths under valgrind and compares them with instructions.txt.
#   instructions.sh PROGRAM BUILD            exit 1 if a path takes 10 % more than in the file, or 10 % less: then the file
#                                            is out of date and would not show it if the path grew again
#   instructions.sh PROGRAM BUILD --update   writes the file
# PROGRAM: build/bench/count_instructions. BUILD: the compiler, processor and build type to which the counts belong.
# Exit status 77: skipped, with the reason.
set -euo pipefail
program=$1 build=$2 mode=${3:-compare}
file=$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/instructions.txt
skip() { printf 'skipped: %s\n' "$*"; exit 77; }

command -v valgrind >/dev/null || skip 'valgrind is not installed (apt-get install valgrind)'
on_file=$(sed -n 's/^# build: //p' "$file" 2>/dev/null || true)
if [[ $mode != --update && $build != "$on_file" ]]; then
  skip "the counts on file are those of '$on_file', this is '$build'"
fi

# count NAME : the instructions of one passage through the path, rounded
count() {
  local out
  out=$(valgrind --tool=callgrind --callgrind-out-file=/dev/null --collect-atstart=no --toggle-collect=measured \
    "$program" "$1" 2>&1) || { printf '%s\n' "$out" >&2; return 1; }
  # "==123== Collected : 3345000"
  awk -v passages="$("$program" --passages)" '
    /Collected/ { found = 1; printf "%.0f\n", $4 / passages }
    END { exit !found }' <<<"$out" ||
    { printf 'valgrind counted nothing for %s:\n%s\n' "$1" "$out" >&2; return 1; }
}

if [[ $mode == --update ]]; then
  {
    printf '# Instructions of one passage of each core path; written by instructions.sh --update.\n'
    printf '# build: %s\n' "$build"
    for name in $("$program"); do printf '%-28s %6d\n' "$name" "$(count "$name")"; done
  } >"$file.new"
  mv -- "$file.new" "$file"
  cat -- "$file"
  exit 0
fi

wrong=0
printf '%-28s %8s %8s %8s\n' path 'on file' now change
for name in $("$program"); do
  now=$(count "$name")
  before=$(awk -v name="$name" '$1 == name { print $2 }' "$file")
  verdict=
  if [[ -z $before ]]; then verdict='not on file: run instructions.sh --update' before=0
  elif ((now * 10 > before * 11)); then verdict='more than 10 % more: find out why, or accept it with --update'
  elif ((now * 10 < before * 9)); then verdict='more than 10 % less: keep it with --update'
  fi
  printf '%-28s %8d %8d %+7.1f%% %s\n' "$name" "$before" "$now" \
    "$(awk -v a="$before" -v b="$now" 'BEGIN { print a ? 100 * (b - a) / a : 0 }')" "$verdict"
  if [[ $verdict ]]; then wrong=$((wrong + 1)); fi
done
for name in $(awk '!/^#/ { print $1 }' "$file"); do
  "$program" | grep -qxF -- "$name" && continue
  printf '%-28s is on file and no path: run instructions.sh --update\n' "$name"
  wrong=$((wrong + 1))
done
((wrong == 0)) || { printf '%d paths do not take what is on file\n' "$wrong"; exit 1; }
