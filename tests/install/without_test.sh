#!/usr/bin/env bash
# without_test.sh PROGRAM SOURCE_DIR : PROGRAM is evenstep as it is built with neither OpenCL nor hidapi
set -euo pipefail
evenstep=$1 scenarios=$2/scenarios
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
cd -- "$work"

# expect CODE TEXT ARGUMENTS... : the exit code, and TEXT on stdout or stderr
expect() {
  local code=$1 text=$2 got=0
  shift 2
  "$evenstep" "$@" >out 2>&1 || got=$?
  ((got == code)) && grep -qF -- "$text" out && return
  printf 'evenstep %s: exit status %d instead of %d, or no "%s":\n' "$*" "$got" "$code" "$text"
  cat out
  exit 1
}

expect 0 PASS run "$scenarios/paper/figure-1-spring.toml"
expect 3 'stopped: this evenstep is built without OpenCL' run "$scenarios/paper/figure-1.toml"
expect 1 'must fail: this evenstep is built without OpenCL' check "$scenarios/paper/figure-1.toml"
expect 1 'or build it with EVENSTEP_OPENCL=ON' check "$scenarios/paper/figure-1.toml"
expect 0 'scene ' check "$scenarios/paper/figure-1.toml" --set scene.solver=cpu
expect 0 PASS run "$scenarios/paper/figure-1.toml" --set scene.solver=cpu
expect 3 'this evenstep is built without hidapi' devices
expect 3 'this evenstep is built without hidapi' run --clock wall --device /dev/hidraw0 \
  "$scenarios/live/figure-1-spring.toml"
