#!/usr/bin/env bash
# Other people's engines under figure 1, in the catalogue, in a study and in `check --cost`.
#   engines_test.sh PROGRAM SOURCE_DIR ENGINE...
set -euo pipefail
program=$1
here=$2/tests/engines
engines=("${@:3}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

fail() { echo "engines: $*" >&2; exit 1; }
# holds TEXT COMMAND... : the command succeeds and prints TEXT; its output is in $out
holds() {
  local text=$1
  shift
  out=$("$program" "$@" 2>&1) || fail "$* exits with $?: $out"
  grep -qF -- "$text" <<<"$out" || fail "$* does not say '$text': $out"
}
trace() { sed -n 's/^trace \([0-9a-f]*\) .*/\1/p' <<<"$out"; }

for engine in "${engines[@]}"; do
  for scenario in "$here/$engine"-*.toml; do
    # Two runs in one process, strategies in parallel, give the same trace; so does a process with one strategy at a time.
    holds PASS run "$scenario" --repeat --threads 2 --out run
    hash=$(trace)
    [[ $hash ]] || fail "$scenario has no trace: $out"
    if [[ $scenario == *-tool.toml || $scenario == *-rod.toml || $scenario == *-soft.toml || $scenario == *-box.toml ]]; then
      holds PASS run "$scenario" --threads 1 --permute-ties 1 --out run
      [[ $(trace) == "$hash" ]] || fail "$scenario: $hash, and $(trace) in another process"
    fi
  done
  tool=$here/$engine-tool.toml short=(--set 'run.duration="1 s"')
  holds 'own, '"$engine" study "$tool" "${short[@]}" --set study.repeats=1 --cache cache --out study
  holds "'$engine', a solver that the program registered" check "$tool" "${short[@]}" --set expect=[] --cost
  grep -q 'state digest .*% of a step' <<<"$out" || fail "check --cost does not say what the digest costs: $out"
done
echo "engines: figure 1, the catalogue, a study and the cost on ${engines[*]}"
