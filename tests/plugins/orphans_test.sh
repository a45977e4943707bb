#!/usr/bin/env bash
# However evenstep ends in the middle of a step, the process of its solver must end with it, and so must what that process
# has started.
#   orphans_test.sh EVENSTEP TEST_PROCESS
set -euo pipefail
program=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp "$2" "$work/solver"
cd "$work"
# The solver has a unique path, by which it is found among all processes.
mark=$work/solver
cat >hangs.toml <<TOML
format = 1
[run]
duration = "0.5 s"
strategies = ["direct"]
[timing]
segment = "30 Hz"
visualization = "11.1 ms"
steps = 15
[scene]
command = ["$mark", "hangs"]
[[device]]
name = "left"
[[expect]]
signal = "left.force.direct"
metric = "underruns"
equals = 0
TOML

fail() { echo "orphans: $*" >&2; exit 1; }
# The processes that run the solver's program. (The watcher runs evenstep's.)
solvers() { find /proc -maxdepth 2 -name exe -lname "$mark" 2>/dev/null || true; }

for signal in KILL ABRT TERM INT; do
  "$program" run hangs.toml --out out >/dev/null 2>&1 &
  evenstep=$!
  for ((i = 0; i < 200; ++i)); do
    [[ -n $(solvers) ]] && break
    sleep 0.05
  done
  [[ -n $(solvers) ]] || fail "the solver did not start"
  sleep 0.2
  kill -"$signal" "$evenstep"
  # The first TERM or INT asks evenstep to end after the step, the second one ends it at once.
  [[ $signal == TERM || $signal == INT ]] && sleep 0.2 && kill -"$signal" "$evenstep" 2>/dev/null || true
  wait "$evenstep" 2>/dev/null || true
  for ((i = 0; i < 100; ++i)); do
    [[ -z $(solvers) ]] && break
    sleep 0.05
  done
  [[ -z $(solvers) ]] || fail "after SIG$signal it still runs: $(solvers)"
done
echo 'orphans: nothing is left after KILL, ABRT, TERM and INT'
