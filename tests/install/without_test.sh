#!/usr/bin/env bash
# without_test.sh PROGRAM SOURCE_DIR : PROGRAM is evenstep as it is built with all options off. If something needs one of
# these options, it must say so before anything runs: it exits with 2, names what it lacks and the option of CMake, and does
# nothing.
set -euo pipefail
evenstep=$1 scenarios=$2/scenarios
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
cd -- "$work"

# expect CODE TEXT ARGUMENTS... : the program ends with this exit code and prints TEXT on stdout or stderr
expect() {
  local code=$1 text=$2 got=0
  shift 2
  "$evenstep" "$@" >out 2>&1 || got=$?
  ((got == code)) && grep -qF -- "$text" out && return
  printf 'evenstep %s: exit status %d instead of %d, or no "%s":\n' "$*" "$got" "$code" "$text"
  cat out
  exit 1
}
# refused PLACE OPTION BROUGHT ARGUMENTS... : the error has the place, what the option brings, and how to get it
refused() {
  local place=$1 option=$2 brought=$3
  shift 3
  expect 2 "$place" "$@"
  expect 2 "this evenstep is built without $brought; " "$@"
  expect 2 "build it with -D $option=ON, which needs " "$@"
  [[ ! -e runs ]] || { echo "evenstep $*: it left a run folder"; exit 1; }
}
spring=$scenarios/live/figure-1-spring.toml tissue=$scenarios/paper/figure-1.toml
line() { grep -n "^$1" "$2" | head -1 | cut -d: -f1; }
# scenario BASE LINES... : writes x.toml, which begins with three other lines
scenario() {
  printf 'format = 1\nextends = ["%s"]\nname = "x"\n' "$1" >x.toml
  shift
  printf '%s\n' "$@" >>x.toml
}
# A short run on the wall clock
on_wall=(--clock wall --set 'run.duration="0.4 s"' --set 'run.warmup="0.1 s"' --set 'expect=[]' --allow-no-expectations)

# OpenCL
solver="$tissue:$(line 'solver ' "$tissue"):13: error: 'solver': \"opencl\": "
refused "$solver" EVENSTEP_OPENCL OpenCL run "$tissue"
refused "$solver" EVENSTEP_OPENCL OpenCL check "$tissue"
refused "$solver" EVENSTEP_OPENCL OpenCL check --cost "$tissue"
refused "$solver" EVENSTEP_OPENCL OpenCL run "${on_wall[@]}" "$tissue"
refused "$solver" EVENSTEP_OPENCL OpenCL record "$tissue" -o timing.csv
refused "$solver" EVENSTEP_OPENCL OpenCL shrink "$tissue"
expect 2 'choose solver = "cpu", which computes the same bits, or build it' run "$tissue"
scenario "$tissue" '[sweep]' 'seeds = "1..2"'
refused "$solver" EVENSTEP_OPENCL OpenCL sweep x.toml
refused "$solver" EVENSTEP_OPENCL OpenCL check x.toml
sed '/^solver /d' "$tissue" >x.toml   # without this line a tissue has the default solver, which is "opencl"
refused "x.toml:$(line '\[scene\]' x.toml):1: error: 'solver': \"opencl\": " EVENSTEP_OPENCL OpenCL run x.toml
refused '--set scene.solver="opencl": error: ' EVENSTEP_OPENCL OpenCL \
  run "$tissue" --set 'scene.solver="cpu"' --set 'scene.solver="opencl"'
scenario "$spring" '[timing]' 'visualization = "burn 11.1 ms"'
refused "x.toml:5:17: error: 'visualization': \"burn\" " EVENSTEP_OPENCL OpenCL run "${on_wall[@]}" x.toml
refused "x.toml:5:17: error: 'visualization': \"burn\" " EVENSTEP_OPENCL OpenCL record x.toml -o timing.csv
expect 0 "wall clock   refused: x.toml:5:17: error: 'visualization': \"burn\" " check x.toml
expect 0 PASS run x.toml
rm -r runs
# If one of several scenarios is refused, the others run.
expect 2 '1 passed, 1 failed' catalogue "$tissue" "$scenarios/extreme/hand-jump.toml" --out catalogue
grep -qF "$solver" out || { cat out; exit 1; }
expect 0 'scene ' check "$tissue" --set scene.solver=cpu
expect 0 PASS run "$tissue" --set scene.solver=cpu
rm -r runs

# drawing
scenario "$tissue" '[timing]' 'visualization = "render 11.1 ms"' '[scene]' 'solver = "cpu"' 'lattice = [8, 7, 9]' \
  'particles = 490'
render="x.toml:5:17: error: 'visualization': \"render\" "
block=(--set 'device.0.grab={center=["10 mm","15 mm","40 mm"],radius="6 mm"}'
  --set 'device.1.grab={center=["25 mm","15 mm","40 mm"],radius="6 mm"}'
  --set 'remap.latency="40 ms"' --set 'remap.lead="5 ms"')
refused "$render" EVENSTEP_DRAW OpenGL run "${on_wall[@]}" "${block[@]}" x.toml
refused "$render" EVENSTEP_DRAW OpenGL record x.toml "${block[@]}" -o timing.csv
expect 2 'write a length or "burn 11.1 ms" in place of "render", or build it' record x.toml "${block[@]}" -o timing.csv
expect 0 "wall clock   refused: $render" check "${block[@]}" --set 'expect=[]' x.toml
expect 0 'figures and data' run "${block[@]}" --set 'expect=[]' --allow-no-expectations x.toml
rm -r runs

# devices
refused 'error: this' EVENSTEP_HIDAPI hidapi devices
refused 'error: --service ws://127.0.0.1:1: ' EVENSTEP_INVERSE3 'the connection to a Haply Inverse3' \
  devices --service ws://127.0.0.1:1
for driver in reference pid; do
  scenario "$spring" '[[device]]' 'name = "left"' "driver = \"$driver\"" 'pid = { travel = ["0.4 m", "0.4 m", "0 m"] }'
  [[ $driver == pid ]] || sed -i '/^pid /d' x.toml
  refused 'x.toml:6:10: error: --device left=/dev/hidraw0: ' EVENSTEP_HIDAPI hidapi \
    run "${on_wall[@]}" --device /dev/hidraw0 x.toml
done
scenario "$spring" '[[device]]' 'name = "left"' 'driver = "inverse3"' 'inverse3 = { origin = ["0 mm", "0 mm", "0 mm"] }'
refused 'x.toml:6:10: error: --device left=ws://127.0.0.1:1#1: ' EVENSTEP_INVERSE3 'the connection to a Haply Inverse3' \
  run "${on_wall[@]}" --device 'left=ws://127.0.0.1:1#1' x.toml
expect 2 'leave --device out, which simulates it, or build it' run "${on_wall[@]}" --device 'ws://127.0.0.1:1#1' x.toml
expect 0 'figures and data' run --set 'expect=[]' --allow-no-expectations x.toml
rm -r runs
# A device of Linux' input core needs none of these options. Here the device does not exist.
scenario "$spring" '[[device]]' 'name = "left"' 'driver = "evdev"' \
  'evdev = { travel = ["0.4 m", "0.4 m", "0 m"], full_scale = "10 N" }'
expect 3 "/dev/input/event-none: No such file" run "${on_wall[@]}" --device /dev/input/event-none x.toml
rm -rf runs

# --scope
refused '--scope: error: this' EVENSTEP_SCOPE 'the page of --scope' run "${on_wall[@]}" --scope "$spring"
expect 2 'leave --scope out: a line a second says the same, or build it' run "${on_wall[@]}" --scope "$spring"
expect 0 'lateness ' run "${on_wall[@]}" --allow-degraded "$spring"

# recordings
{ printf 'SQLite format 3\0'; head -c 100 /dev/zero; } >nsight.sqlite
printf '[{"ph":"X","name":"draw","ts":1,"dur":2}]' | gzip >chrome.json.gz
rm -r runs
for file in nsight.sqlite chrome.json.gz; do
  refused "$file: " EVENSTEP_PROFILES 'SQLite and zlib' import "$file" --list
  refused "$file: " EVENSTEP_PROFILES 'SQLite and zlib' size "$file"
  printf '%s\n' 'format = 1' 'name = "t"' '[timing]' "trace = \"$file\"" '[scene]' 'solver = "cpu-double"' \
    'kind = "spring"' 'stiffness = "1 N/m"' 'step_size = "450 Hz"' '[[device]]' 'name = "left"' 'rate = "1 kHz"' \
    'motion = { kind = "still" }' >x.toml
  refused "x.toml:4:9: " EVENSTEP_PROFILES 'SQLite and zlib' run x.toml
  refused "x.toml:4:9: " EVENSTEP_PROFILES 'SQLite and zlib' check x.toml
done
gunzip chrome.json.gz
expect 0 'draw' import chrome.json --list
expect 0 PASS run "$scenarios/paper/figure-1-spring.toml"
