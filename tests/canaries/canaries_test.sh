#!/usr/bin/env bash
# canaries_test.sh PROGRAM_WITH_CANARIES EVENSTEP REPOSITORY [all] : every canary makes at least one shipped scenario fail
# with exit status 1, and without a canary none fails. Prints which scenario finds which canary. EVENSTEP itself must not
# know the canaries. The scenarios take less than a second each; with `all`, all those of the folders timing, safety and
# recovery are run.
set -uo pipefail
with_canaries=$1 evenstep=$2 repository=$3
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
canaries=(short-ring newest-sample late-after-regime no-ramp latency-stays)
scenarios=(scenarios/timing/{stall,hitch,jitter-1,sine-5,visualization-doubles,latency-adaptive-renderer}.toml
  scenarios/safety/{stale-hand,stale-force,switches-mask,faults-reference-hidraw}.toml)
mapfile -t recoveries < <(cd "$repository" && ls scenarios/recovery/*.toml)
scenarios+=("${recoveries[@]}")
if [ "${4:-}" = all ]; then
  mapfile -t scenarios < <(cd "$repository" && ls scenarios/{timing,safety,recovery}/*.toml)
fi
wrong=0

# run_all LOG PROGRAM : writes "STATUS FILE" for each scenario
run_all() {
  local log=$1 program=$2 scenario status
  : >"$log"
  for scenario in "${scenarios[@]}"; do
    "$program" run "$repository/$scenario" --out "$scratch/run" >"$scratch/said" 2>&1
    status=$?
    rm -rf "$scratch/run"
    echo "$status $scenario" >>"$log"
    if [ "$status" -ne 0 ] && [ "$status" -ne 1 ]; then sed 's/^/    /' "$scratch/said" >>"$log"; fi
  done
}

run_all "$scratch/none" "$with_canaries"
if grep -v '^0 ' "$scratch/none"; then
  echo "FAILED: without a canary these scenarios must pass"
  wrong=1
fi
for canary in "${canaries[@]}"; do
  EVENSTEP_CANARY=$canary run_all "$scratch/$canary" "$with_canaries"
  found=$(sed -n 's/^1 //p' "$scratch/$canary")
  if [ -z "$found" ]; then
    echo "FAILED: no scenario finds the canary $canary"
    wrong=1
  else
    echo "$canary: found by $(wc -l <<<"$found") of ${#scenarios[@]} scenarios"
    sed 's/^/  /' <<<"$found"
  fi
done

# The program that users get knows no canaries.
scenario=$repository/scenarios/safety/stale-hand.toml
EVENSTEP_CANARY=no-ramp "$evenstep" run "$scenario" --out "$scratch/run" >/dev/null 2>&1 || {
  echo "FAILED: evenstep itself has a canary"
  wrong=1
}
if grep -qa EVENSTEP_CANARY "$evenstep"; then
  echo "FAILED: evenstep itself knows EVENSTEP_CANARY"
  wrong=1
fi
EVENSTEP_CANARY=no-such "$with_canaries" run "$repository/scenarios/timing/stall.toml" --out "$scratch/run" >/dev/null 2>&1
if [ $? -ne 3 ]; then
  echo "FAILED: a canary that does not exist must be refused"
  wrong=1
fi
exit $wrong
