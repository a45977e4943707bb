#!/usr/bin/env bash
# Throws damaged input at every way in from outside, with libFuzzer under the address and undefined behaviour sanitizers:
#   scripts/fuzz.sh SECONDS [TARGET...]     so long for each of the targets (default: all in tests/fuzz)
# An input that crashes, hangs, grows without bound or breaks a property is kept in found/ of the build folder, beside the
# corpus that each run goes on from. Exit status 1 if there is one. Put it into tests/fuzz/kept with its fix.
# Needs clang and its runtime (Debian 12: clang libclang-rt-14-dev; 13: clang libclang-rt-dev).
set -euo pipefail
repo=$(dirname -- "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")")
source "$repo/scripts/setup.sh"
[[ ${1-} =~ ^[1-9][0-9]*$ ]] || fail "usage: scripts/fuzz.sh SECONDS [TARGET...]"
seconds=$1 targets=("${@:2}")
if ((${#targets[@]} == 0)); then
  mapfile -t targets < <(cd -- "$repo/tests/fuzz" && printf '%s\n' *_fuzz.cpp | sed 's/_fuzz\.cpp$//')
fi
command -v clang++ >/dev/null || fail "clang++ is not installed (Debian 12: libclang-rt-14-dev; 13: libclang-rt-dev)"

set_up fuzz "${targets[@]/#/fuzz_}"
mkdir -p -- "$build/found"

# fuzz TARGET : its log is corpus/TARGET.log. A time limit of 20 s is far above what any input of this size takes (10 ms),
# also on a busy machine.
fuzz() {
  local corpus=$build/corpus/$1 log=$build/corpus/$1.log shipped=()
  mkdir -p -- "$corpus"
  case $1 in scenario | timing_csv) shipped=("$repo/scenarios") ;; esac
  "$build/tests/fuzz/fuzz_$1" -max_total_time="$seconds" -max_len=4096 -timeout=20 -rss_limit_mb=1024 -malloc_limit_mb=256 \
    -dict="$repo/tests/fuzz/$1.dict" -artifact_prefix="$build/found/$1-" -print_final_stats=1 \
    "$corpus" "$repo/tests/fuzz/kept/$1" "${shipped[@]}" >"$log" 2>&1
}

# report TARGET STATUS : one line, and the end of the log if something was found
report() {
  local log=$build/corpus/$1.log executed
  executed=$(sed -n 's/^stat::number_of_executed_units: //p' "$log")
  if (($2 == 0)); then
    printf 'fuzz: %s: passed, %d inputs\n' "$1" "$executed"
  else
    tail -n 60 -- "$log"
    printf 'fuzz: %s: failed, see %s/found\n' "$1" "$build"
  fi
}

worst=0 running=()
for target in "${targets[@]}"; do
  fuzz "$target" &
  running+=($!)
  while (($(jobs -rp | wc -l) >= $(nproc))); do sleep 1; done
done
for i in "${!targets[@]}"; do
  status=0
  wait "${running[i]}" || status=$?
  report "${targets[i]}" "$status"
  ((status == 0)) || worst=1
done
exit "$worst"
