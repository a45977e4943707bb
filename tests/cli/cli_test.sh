#!/usr/bin/env bash
# cli_test.sh PROGRAM SOURCE_DIR CASE : runs one case; prints what differed and exits 1 on failure, 77 when it cannot run
# here.
set -uo pipefail
evenstep=$1
source_dir=$2
work=$(mktemp -d "${TMPDIR:-/tmp}/evenstep cli XXXXXX")
trap 'chmod -R u+w "$work"; rm -rf "$work"' EXIT
cd "$work" || exit 1
spring=$source_dir/scenarios/paper/figure-1-spring.toml
unset GITHUB_ACTIONS GITHUB_WORKSPACE GITHUB_STEP_SUMMARY EVENSTEP_CALLED_AS   # set if a CI runs these tests

fail() { printf 'FAILED: %s\n--- stdout\n%s\n--- stderr\n%s\n' "$1" "$(head -c 3000 out)" "$(head -c 3000 err)"; exit 1; }
# expect CODE TEXT ARGUMENTS... : the program ends with this exit code and prints TEXT on stderr or stdout
expect() {
  local code=$1 text=$2
  shift 2
  "$evenstep" "$@" >out 2>err
  local got=$?
  [ "$got" -eq "$code" ] || fail "exit $got instead of $code: evenstep $*"
  grep -qF -- "$text" err out || fail "no '$text': evenstep $*"
}
# scenario LINES... : writes the spring with these changes into x.toml
scenario() {
  { printf 'format = 1\nextends = ["%s"]\nname = "x"\n' "$spring"; printf '%s\n' "$@"; } >x.toml
}
no_run_folder() { [ -z "$(ls -A runs 2>/dev/null)" ] || fail "a run folder was written: $(ls -A runs)"; }

case_help_and_version() {
  expect 0 "Exit: 0 pass" --help
  expect 0 "evenstep 0." --version
  expect 2 "a command is missing" ''
  expect 2 "scenario is missing: scenario files, or folders of them; see " run
  expect 2 "--clock" run x.toml --clock sundial
}
case_a_call_that_is_not_understood_is_refused_in_words_of_our_own() {
  scenario
  expect 2 "--threads: 'two' is not possible; write a whole number from 0 to 1024; see " run x.toml --threads two
  expect 2 "--clock: there is no 'x'; known: virtual, wall; see " run x.toml --clock x
  expect 2 "--seed needs a value; see " run x.toml --seed
  expect 2 "--seed is given twice; see " run x.toml --seed 1 --seed 2
  expect 2 "--json takes no value; see " run x.toml --json=7
  expect 2 "run has no option '-q'; see " run x.toml -q
  expect 2 "diff does not take one more argument, 'c'; see " diff a b c
  expect 2 "evenstep has no option '--frob'; known: --help, --version; see " --frob
  expect 2 "b is missing: after: the same, of the later run or runs; see " compare a
  no_run_folder
}
case_run_prints_a_line_per_strategy_what_does_not_hold_and_what_was_suffered() {
  local late=(--set 'timing.visualization="11 ms"' --set 'remap.latency="1 ms"')
  local asked='{ signal = "*.force.*", metric = "judged", min = 1 }'
  local jitter=$source_dir/scenarios/timing/jitter-10.toml
  expect 0 "went wrong   " run "$jitter" "${late[@]}" --set "expect=[$asked]"
  grep -qE '^strategy +latency +jump of hand +jump of force +late forces +missing samples +saturated$' out || fail "no table"
  grep -qE '^phase_locked +1\.00 ms .* [0-9]+ of [0-9]+ +0 +0$' out || fail "no late forces in the table"
  grep -qE '^went wrong   .*left\.phase_locked: [0-9]+ of [0-9]+ forces late; nothing asserts this$' out || fail "not said"
  grep -q '^expectations 1 of 1 hold; --verbose shows all$' out || fail "no count"
  ! grep -qE '^(growth|signal|solver waits)' out || fail "what --verbose prints"
  # Asked about, it is no surprise; what fails is shown.
  local underruns='{ signal = "*.force.*", metric = "underruns", max = 0 }'
  expect 1 "expectations 1 of 2 hold; --verbose shows all" run "$jitter" "${late[@]}" --set "expect=[$asked, $underruns]"
  grep -qE '^left\.force\.[a-z_]+ +underruns +[0-9]+ ' out || fail "what does not hold is not shown"
  ! grep -q "^[a-z_.]* *judged " out || fail "what holds is shown"
  ! grep -q '^went wrong.*forces late' out || fail "what is asserted is called not asserted"
  "$evenstep" run "$jitter" -v "${late[@]}" --set "expect=[$asked, $underruns]" -o here >out 2>err
  grep -q "^[a-z_.]* *judged " out && grep -q '^growth' out || fail "--verbose does not show all"
  [ -e here/summary.json ] || fail "-o is not --out"
}
case_unknown_key() {
  scenario '[timing]' 'vsualization = "1 ms"'
  expect 2 "x.toml:5:1: error: unknown key 'vsualization'" run x.toml
  grep -q "did you mean 'visualization'" err || fail "no suggestion"
  no_run_folder
}
case_wrong_unit() {
  scenario '[timing]' 'visualization = "11.1 msec"'
  expect 2 "x.toml:5:" run x.toml
  grep -q "msec" err || fail "does not name the unit"
  no_run_folder
}
case_bare_number() { scenario '[timing]' 'visualization = 11.1'; expect 2 "x.toml:5:" run x.toml; }
case_duplicate_key() { scenario '[timing]' 'steps = 3' 'steps = 4'; expect 2 "x.toml:6" run x.toml; }
case_nan() {
  scenario '[timing]' 'visualization = nan'
  expect 2 "x.toml:5:" run x.toml
  scenario '[[expect]]' 'signal = "run"' 'metric = "x"' 'max = "nan"'
  expect 2 "x.toml:" run x.toml
}
case_missing_file() { expect 2 "nowhere.toml" run nowhere.toml; mkdir empty; expect 2 "no scenario" run empty; }
traced() {  # a scenario that replays $1
  printf '%s\n' 'format = 1' 'name = "t"' '[timing]' "trace = \"$1\"" \
    '[scene]' 'solver = "cpu-double"' 'kind = "spring"' 'stiffness = "1 N/m"' 'step_size = "450 Hz"' \
    '[[device]]' 'name = "left"' 'rate = "1 kHz"' 'motion = { kind = "still" }' >t.toml
}
case_missing_trace() { traced gone.csv; expect 2 "gone.csv" run t.toml; }
case_include_cycle() {
  printf 'format = 1\nextends = ["b.toml"]\nname = "a"\n' >a.toml
  printf 'format = 1\nextends = ["a.toml"]\nname = "b"\n' >b.toml
  expect 2 "b.toml" run a.toml
  grep -q "a.toml -> b.toml -> a.toml" err || fail "does not name the chain"
}
swept() {  # a sweep of six points; those at 9 ms fail
  printf '%s\n' '# a' 'format = 1' "extends = [\"$spring\"]" 'name = "s"' \
    'expect = [{ signal = "left.force.phase_locked", metric = "underruns", equals = 0 }]' \
    '[run]' 'duration = "0.5 s"' 'strategies = ["phase_locked"]' \
    '[timing]' 'jitter = { step = "lognormal 10 %" }' \
    '[remap]' 'lead = "1 ms"' \
    '[sweep]' 'seeds = "0..3"' 'grid = { "remap.latency" = ["9 ms", "40 ms"] }' "$1" >s.toml
}
case_sweep_and_merge() {
  swept ''
  expect 1 "6 points" sweep s.toml
  for shard in 1/2 2/2; do
    "$evenstep" sweep s.toml --shard $shard --out parts >out 2>err
    [ $? -le 1 ] || fail "shard $shard"
  done
  expect 1 "6 points" merge parts/sweep-2-of-2.jsonl parts/sweep-1-of-2.jsonl --out merged.jsonl
  cmp -s merged.jsonl runs/s-sweep/sweep.jsonl || fail "merged bytes differ"
  expect 2 "lack 3 of 6 points" merge parts/sweep-2-of-2.jsonl --out gap.jsonl
  [ ! -e gap.jsonl ] || fail "a refused merge was written"
  swept 'find = { smallest = "remap.latency" }'
  expect 0 "smallest remap.latency: 40 ms" sweep s.toml --out found
  expect 2 "does not go with [sweep.find]" sweep s.toml --stop-after 1
  expect 2 "must be I/N" sweep s.toml --shard 3/2
  expect 2 "has no [sweep]" sweep "$spring"
  swept ''
  sed -i 's/equals = 0 }/equals = 0, clock = "wall" }/' s.toml
  expect 2 "a sweep runs on the virtual clock only" sweep s.toml
}
case_sweep_onto_a_full_disk() {
  swept ''
  trap '' XFSZ
  ulimit -S -f 1
  expect 3 "File too large" sweep s.toml --out full
  ulimit -S -f unlimited
  [ ! -e full/sweep.jsonl ] || fail "half a sweep has its name"
  expect 1 "6 points" sweep s.toml --out full --resume
}
case_shrink() {
  swept ''
  expect 0 "again: $evenstep run" shrink s.toml --seed 0 --set remap.latency="9 ms"
  expect 1 "FAIL" run runs/shrunk/s-shrunk.toml
  expect 2 "nothing to shrink" shrink s.toml --seed 0 --set remap.latency="40 ms"
}
case_step_counts() { for n in 0 1000000000 -3; do scenario '[timing]' "steps = $n"; expect 2 "x.toml:5:" run x.toml; done; }
case_negative_duration() {
  scenario '[run]' 'duration = "-1 s"'
  expect 2 "x.toml:5:" run x.toml
  scenario '[timing]' 'visualization = "-1 ms"'
  expect 2 "x.toml:5:" run x.toml
}
case_step_longer_than_segment() {
  scenario '[timing]' 'step = "40 ms"'
  expect 2 "x.toml:5:" run x.toml
  scenario '[timing]' 'visualization = "34 ms"'
  expect 2 "x.toml:5:" run x.toml
}
case_all_errors_at_once() {
  scenario '[timing]' 'vsualization = "1 ms"' '[scene]' 'stifness = "1 N/m"' '[run]' 'sed = 1'
  expect 2 "vsualization" run x.toml
  [ "$(grep -c ': error: ' err)" -eq 3 ] || fail "not all three errors"
}
case_trace_going_back() {
  printf 'segment,kind,index,begin_ns,end_ns\n0,visualization,0,0,1000\n0,step,0,1000,2000\n0,step,1,1500,2500\n' >t.csv
  traced t.csv
  expect 2 "t.csv:4" run t.toml
}
# loaded PATTERN ARGUMENTS... : whether a shared library of that name is loaded, as the dynamic linker reports it
loaded() {
  local pattern=$1
  shift
  LD_DEBUG=files LD_DEBUG_OUTPUT=$work/loaded "$evenstep" "$@" >out 2>err || fail "evenstep $*"
  grep -qE "calling init: .*/$pattern" loaded.*
  local found=$?
  rm -f loaded.*
  return $found
}
case_a_run_loads_only_the_libraries_that_it_uses() {
  loaded 'libfmt' --version || fail "the dynamic linker says nothing: this test sees nothing"
  ! loaded 'lib(OpenCL|hidapi|udev)' run "$spring" --out spring || fail "a spring's run loads a library for nothing"
  loaded 'libOpenCL' run "$source_dir/scenarios/paper/figure-1.toml" --out tissue || fail "OpenCL is not seen"
  small_block
  ! loaded 'lib(EGL|GL)' run block.toml --set 'timing.visualization="render 2 ms"' --allow-no-expectations --out drawn ||
    fail "OpenGL is loaded under the virtual clock"
  grep -q '<svg.*<title>block' drawn/tissue.svg || fail "no picture of the tissue"
  loaded 'libhidapi' devices || fail "hidapi is not seen"
}
case_a_run_says_what_was_saturated_asked_or_not() {
  scenario
  expect 0 "saturated    left.force.direct: " run x.toml --set 'device.left.force_limit="1 N"' --set 'expect=[]' \
    --allow-no-expectations
  grep -q "clamp first at [0-9.]* s" out || fail "not when and by what"
  expect 0 "trace" run x.toml --set 'expect=[]' --allow-no-expectations
  ! grep -q "^saturated" out || fail "what is within its limits is called saturated"
}
case_completion_and_the_manual_know_every_command_and_option() {
  local command option commands section
  expect 0 "complete" completion
  mv out completion
  expect 0 ".TH EVENSTEP 1" manual
  sed 's/\\-/-/g' out >manual
  commands=$("$evenstep" --help | sed -n '/^Test:/I,$p' | sed -nE 's/^  ([a-z]+) .*/\1/p')
  [ "$(wc -w <<<"$commands")" -ge 14 ] || fail "commands: $commands"
  # Lines of words, and after them what the shell must offer for the last of them
  local wanted=''
  for command in $commands; do
    wanted+="evenstep ${command:0:2} $command"$'\n'
    section=$(sed -n "/^\.SS $command\$/,/^\.S/p" manual)
    [ -n "$section" ] || fail "the manual lacks $command"
    for option in $("$evenstep" "$command" --help | grep -oE '^  (-h,)?--[a-z-]+' | grep -oE -- '--[a-z-]+'); do
      wanted+="evenstep $command $option $option"$'\n'
      [[ $section =~ $option([[:space:]]|$) ]] || fail "the manual lacks $command $option"
    done
  done
  complete() {  # complete <WANTED : prints the lines that the shell does not complete so
    bash -c 'source ./completion
      while read -ra words; do
        expected=${words[-1]} COMP_WORDS=("${words[@]::${#words[@]}-1}") COMP_CWORD=$((${#words[@]} - 2))
        _evenstep
        [[ " ${COMPREPLY[*]-} " == *" $expected "* ]] || echo "${words[*]}"
      done'
  }
  [ "$(complete <<<'evenstep run x x')" = 'evenstep run x x' ] || fail "files are not left to the shell"
  [ -z "$(printf %s "$wanted" | complete)" ] || fail "the shell does not complete: $(printf %s "$wanted" | complete)"
}
case_no_opencl_platform() {
  mkdir none
  OCL_ICD_VENDORS="$work/none" expect 3 "pocl-opencl-icd" \
    run "$source_dir/scenarios/paper/figure-1.toml" --set 'run.duration="0.5 s"'
}
case_unwritable_run_folder() {
  if [ "$(id -u)" -eq 0 ]; then
    command -v setpriv >/dev/null || { echo "skipped: root writes everywhere and setpriv is not here"; exit 77; }
    local as_user=(setpriv --reuid 65534 --regid 65534 --clear-groups)
    "${as_user[@]}" test -x "$evenstep" -a -r "$spring" || { echo "skipped: other users cannot read the clone"; exit 77; }
    chmod 755 "$work"; mkdir locked; chmod 555 locked; touch out err; chmod 666 out err
    "${as_user[@]}" "$evenstep" run "$spring" --out locked/run >out 2>err
  else
    mkdir locked; chmod 555 locked
    "$evenstep" run "$spring" --out locked/run >out 2>err
  fi
  local got=$?
  [ "$got" -eq 3 ] || fail "exit $got instead of 3"
  grep -q -- "--out" err || fail "no remedy"
  [ -z "$(ls -A locked)" ] || fail "something was written"
}
case_refuses_to_replace_other_folders() {
  mkdir mine
  echo x >mine/x
  expect 3 "not a run folder" run "$spring" --out mine
  [ -f mine/x ] || fail "mine/x is gone"
}
case_run_writes_a_verdict_and_a_folder() {
  expect 0 "PASS" run "$spring"
  head -1 out | grep -q "evenstep 0.*figure-1-spring.toml.*seed 1.*clock virtual" || fail "first line"
  for f in report.html summary.json junit.xml series.csv timing.csv events.bin resolved.toml \
    figure-1a-left.svg figure-1b-left.svg figure-2to4.svg; do
    [ -s "runs/figure-1-spring/$f" ] || fail "no $f"
  done
  grep -q '"verdict":"pass"' runs/figure-1-spring/summary.json || fail "summary verdict"
}
case_failing_expectation_names_the_line_and_the_command() {
  scenario '[[expect]]' 'signal = "left.interaction.direct"' 'metric = "velocity_jump"' 'max = "1 step"'
  expect 1 "x.toml:4" run x.toml
  grep -qF "again: $evenstep run x.toml --seed 1" out || fail "no command to run it again"
  grep -q '"verdict":"fail"' runs/x/summary.json || fail "summary verdict"
}
case_json() {
  "$evenstep" run "$spring" --json >out 2>err || fail "exit"
  command -v python3 >/dev/null || { echo "skipped: no python3 to check the JSON"; exit 77; }
  python3 -m json.tool out >/dev/null || fail "not JSON"
}
case_repeat_and_permute_ties_say_what_was_compared() {
  local trace
  expect 0 "PASS" run "$spring" --repeat
  trace=$(sed -n 's/^trace \([0-9a-f]*\) .*/\1/p' out)
  [ ${#trace} -eq 16 ] && grep -qx "repeated: 2 runs, both with the trace $trace" out || fail "not what was compared"
  ! grep -q '^permuted' out || fail "a permutation that was not asked for"
  expect 0 "PASS" run "$spring" --permute-ties 3
  grep -q '^permuted: 1 run, its simultaneous events in the order of seed 3; ' out || fail "does not say what was permuted"
  ! grep -q '^repeated' out || fail "a second run that was not asked for"
  expect 0 "repeated: 2 runs, both with the trace " run "$source_dir/scenarios/stiff/s1-oscillator-short-steps.toml" --repeat
}
case_a_folder_that_cannot_be_made_is_refused_before_anything_runs() {
  local place
  for place in /proc/x /dev/null/x; do
    expect 3 "error: cannot make the run folder '$place': " run "$spring" --out $place
    grep -q 'give a writable place with --out$' err || fail "no remedy"
    ! grep -q 'filesystem error\|\.writing-\|done\|^trace' out err || fail "it ran, or the error is raw"
    expect 3 "$place" advise "$source_dir/scenarios/recorded/small-paced30-basic.csv" --out $place
    ! grep -q 'filesystem error\|\.writing-' out err || fail "the error of advise is raw"
    swept ''
    expect 3 "$place" sweep s.toml --out $place
    ! grep -q 'filesystem error\|\.writing-' out err || fail "the error of sweep is raw"
    expect 3 "$place" init $place/mine
    ! grep -q 'filesystem error\|\.writing-' out err || fail "the error of init is raw"
  done
}
case_what_is_printed_to_run_again_writes_to_the_same_folder() {
  scenario '[[expect]]' 'signal = "left.force.direct"' 'metric = "underruns"' 'equals = 99'
  expect 1 "again: $evenstep run x.toml --seed 1 --out 'my runs/here'" run x.toml --out 'my runs/here'
  rm -r 'my runs'
  bash -c "$(sed -n 's/^again: //p' out)" >again 2>&1
  [ $? -eq 1 ] && [ -s 'my runs/here/summary.json' ] || fail "does not do the same: $(cat again)"
  # Of several scenarios each has a folder of its own in that of --out.
  mkdir two && cp x.toml two/a.toml && cp x.toml two/b.toml
  expect 1 "again: $evenstep run two/b.toml --seed 1 --out kept/b" run two --out kept
}
case_a_signal_that_cannot_be_judged_ends_check_and_run_alike() {
  scenario 'expect = [{ signal = "left.force.direct", metric = "jump_max", max = "1 N" }]' '[[device]]' 'name = "left"' \
    'force_limit = "1 N"' 'motion = { kind = "constant-velocity", velocity = ["0.1 m/s", "0 m/s", "0 m/s"] }'
  expect 2 "so its shape says nothing" run x.toml
  expect 2 "cannot be judged" check x.toml
}
case_options_may_come_before_the_file() {
  expect 0 "seed 3" run --seed 3 --set 'run.duration="1 s"' --set 'run.warmup="0.3 s"' "$spring"
}
case_devices_lists_what_is_there() {
  "$evenstep" devices >out 2>err || fail "devices"
  expect 0 "ws://127.0.0.1:1: no Haply Inverse3 there: is the Inverse Service running?" devices --service ws://127.0.0.1:1
  ! "$evenstep" devices | grep -q Inverse3 || fail "a service that nobody named, and that is not there, is no news"
  "$evenstep" devices --json >out 2>err || fail "devices --json"
  command -v python3 >/dev/null || { echo "skipped: no python3 to check the JSON"; exit 77; }
  python3 -m json.tool out >/dev/null || fail "not JSON"
}
case_a_device_that_is_none_is_refused() {
  local live=$source_dir/scenarios/live/figure-1-spring.toml
  expect 3 "not a hidraw device" run --clock wall --device /dev/null "$live"
  expect 3 'takes the address of a service with driver = "inverse3"' run --clock wall --device ws://127.0.0.1:1 "$live"
  expect 3 'takes an event node with driver = "evdev"' run --clock wall --device /dev/input/event0 "$live"
  local evdev=(--set 'device.left.driver="evdev"' --set 'expect=[]' --allow-no-expectations
    --set 'device.left.evdev={ travel = ["0.2 m", "0 m", "0 m"] }')
  expect 3 "/dev/null: not an evdev device (/dev/input/event*)" run --clock wall --device /dev/null "$live" "${evdev[@]}"
  expect 3 "/dev/input/event7777: No such file or directory" run --clock wall --device /dev/input/event7777 "$live" \
    "${evdev[@]}"
  local newtons='expect=[{ signal = "left.force.phase_locked", metric = "jump_max", max = "1 N" }]' driver
  for driver in pid evdev; do
    expect 2 "knows none; write full_scale (of a wheel: torque) in $driver = { ... } of device \"left\"" \
      check "$live" \
      --set "device.left.driver=\"$driver\"" --set "device.left.$driver={ travel = [\"0.2 m\", \"0 m\", \"0 m\"] }" \
      --set "$newtons"
  done
  expect 2 'no device "right", but left' run --clock wall --device right=/dev/hidraw0 "$live"
  expect 2 'given twice for "left"' run --clock wall --device /dev/hidraw0 --device left=/dev/hidraw1 "$live"
  expect 2 "needs --clock wall" run --device /dev/hidraw0 "$live"
}
case_seed_and_set_are_in_the_run() {
  expect 0 "seed 7" run "$spring" --seed 7 --set 'run.duration="1 s"'
  grep -q '"seed":7' runs/figure-1-spring/summary.json || fail "summary seed"
  expect 2 "--set" run "$spring" --set 'run.duratoin="1 s"'
}
case_several_files_worst_wins() {
  scenario '[[expect]]' 'signal = "left.interaction.direct"' 'metric = "velocity_jump"' 'max = "1 step"'
  mv x.toml fails.toml
  scenario '[run]' 'duration = "1 s"'
  mv x.toml passes.toml
  expect 1 "2 scenarios: 1 passed, 1 failed" run fails.toml passes.toml --out all
  [ -s all/fails/summary.json ] && [ -s all/passes/summary.json ] || fail "run folders"
  expect 2 "1 passed" run nowhere.toml passes.toml
}
case_nothing_asserted_is_not_a_pass() {
  scenario 'expect = []' '[run]' 'duration = "0.5 s"'
  expect 1 "NO VERDICT: nothing was asserted" run x.toml
  grep -q '"verdict":"none"' runs/x/summary.json || fail "summary verdict"
  expect 0 "NO VERDICT" run x.toml --allow-no-expectations
  expect 1 "2 scenarios: 1 passed, 0 failed, 1 without a verdict" run x.toml "$spring" --out two
}
case_forces_need_a_device_and_a_wall_clock() {
  for arguments in "" "--clock wall" "--device /dev/hidraw0"; do
    expect 2 "add --clock wall --device PATH" run "$spring" --forces $arguments
  done
  no_run_folder
}
case_run_folders_are_no_scenarios() {
  scenario '[run]' 'duration = "1 s"'
  expect 0 "PASS" run .
  expect 0 "PASS" run .
  grep -q "resolved" out && fail "its own run folder was run"
  [ "$(ls runs)" = x ] || fail "folders: $(ls runs)"
}
case_a_file_given_twice_runs_once() {
  scenario '[run]' 'duration = "1 s"'
  "$evenstep" run x.toml ./x.toml >out 2>err || fail "exit"
  [ "$(grep -c '^PASS' out)" -eq 1 ] || fail "not one run"
  [ "$(ls -A runs)" = x ] || fail "folders: $(ls -A runs)"
}
case_files_of_one_name_keep_their_runs() {
  scenario '[run]' 'duration = "1 s"'
  mkdir -p a/s b/s
  cp x.toml a/s; mv x.toml b/s
  expect 0 "2 passed" run a/s/x.toml b/s/x.toml
  [ "$(echo runs/*)" = "runs/a-s-x runs/b-s-x" ] || fail "folders: $(ls runs)"
  rm -r runs
  expect 0 "PASS" run a/s/x.toml
  expect 0 "runs/x has the run of a/s/x.toml; that of b/s/x.toml goes to runs/s-x" run b/s/x.toml
  grep -q '"file":"a/s/x.toml"' runs/x/summary.json || fail "the first run is gone"
  grep -q '"file":"b/s/x.toml"' runs/s-x/summary.json || fail "the second run is not there"
  expect 0 "figures and data in runs/x" run a/s/../s/x.toml  # the same file
  expect 0 "figures and data in mine" run b/s/x.toml --out mine
}
case_a_broken_file_of_a_folder_is_in_junit_and_json() {
  mkdir folder
  scenario '[run]' 'duration = "1 s"'
  mv x.toml folder/good.toml
  printf 'format = 1\nnmae = "<x>"\n' >folder/bad.toml
  expect 2 "2 scenarios: 1 passed, 1 failed" run folder --out all
  grep -q '<error .*bad.toml:2:1: error: unknown key .*nmae' all/bad/junit.xml || fail "not in JUnit"
  "$evenstep" run folder --json --out all >out 2>err
  command -v python3 >/dev/null || { echo "skipped: no python3 to check the JSON"; exit 77; }
  python3 -c 'import json; bad, good = json.load(open("out"))
assert bad["verdict"] == "error" and "unknown key" in bad["failure"] and bad["file"] == "folder/bad.toml"
assert good["verdict"] == "pass" and not good["failure"]' || fail "JSON"
}
case_a_broken_file_named_alone_is_in_json_and_in_the_place_it_was_given() {
  printf 'format = 1\nnmae = "<x>"\n' >bad.toml
  expect 2 "bad.toml:2:1: error: unknown key" run bad.toml
  no_run_folder
  expect 2 "bad.toml:2:1: error: unknown key" run bad.toml --out place
  grep -q '<error .*bad.toml:2:1: error: unknown key .*nmae' place/junit.xml || fail "not in JUnit"
  expect 2 '"verdict":"error"' run bad.toml --json
  no_run_folder
}
case_a_device_that_does_not_answer_the_pool_is_named() {
  "$evenstep" run "$source_dir/scenarios/safety/exit-pid.toml" >out 2>err
  ! grep -q "how many effects" out || fail "it did answer"
  "$evenstep" run "$source_dir/scenarios/safety/exit-pid.toml" --set 'device.left.pid.firmware="silent-pool"' >out 2>err
  [ "$(grep -c "^left  *did not say, or not believably, how many effects" out)" = 1 ] || fail "it is not named once"
}
case_a_failure_says_when_and_what_would_do() {
  scenario '[remap]' 'latency = "12 ms"'
  expect 1 "late first at step " run x.toml
  grep -Eq "^    late first at step [0-9]+, [0-9.]+ s, by [0-9.]+ [mun]s; .*latency [0-9.]+ ms would do" out ||
    fail "no remedy"
  grep -q "message=.*late first at step .* would do" runs/x/junit.xml || fail "not in JUnit"
  grep -q "failure</text>" runs/x/figure-1b-left.svg || fail "not in the figure"
  grep -q "worst failure</text>" runs/x/figure-2to4.svg || fail "not in the segment"
  local enough
  enough=$(sed -nE 's/^    late first .*; latency ([0-9.]+ ms) would do$/\1/p' out | sort -n | tail -1)
  expect 1 "must fail:" check x.toml
  grep -q "latency $enough would do" out || fail "check does not say what would do"
  expect 0 "expectations" check x.toml --set "remap.latency=\"$enough\""
  "$evenstep" run x.toml --set "remap.latency=\"$enough\"" >out 2>err
  ! grep -q "force.*underruns.*FAIL" out || fail "$enough does not do"
}
case_a_live_run_says_how_late_it_was_and_keeps_what_it_has() {
  local live=$source_dir/scenarios/live/figure-1-spring.toml
  "$evenstep" run --clock wall "$live" --set 'run.duration="60 s"' >out 2>err &
  local pid=$!
  for _ in $(seq 300); do grep -q Ctrl-C out && break; sleep 0.1; done
  grep -q "^runs for 60 s; Ctrl-C ends it earlier and keeps what was recorded until then" out || fail "no introduction"
  sleep 2
  kill -INT $pid
  wait $pid
  local got=$?
  [ "$got" -eq 130 ] || fail "exit $got instead of 130"
  grep -Eq "^live +phase_locked for [0-9.]+ s on the wall clock: [0-9]+ steps, [0-9]+ ticks, [0-9]+ ticks missed" out ||
    fail "no count of ticks"
  grep -Eq "^lateness +p50 [0-9.e-]+ ms, p99 [0-9.e-]+ ms, p99.9 [0-9.e-]+ ms, max [0-9.e-]+ ms" out || fail "no lateness"
  grep -Eq "^rights +device .*SCHED_FIFO 45.*, solver .*SCHED_FIFO 35.*, memory (not )?locked, timer slack [0-9]+ ns" out ||
    fail "nothing about real-time rights"
  grep -Eq "^rights .* ns, (cores kept|refused to keep cores) awake$" out || fail "nothing about cores that sleep"
  grep -Eq "^left +[0-9]+ forces: [0-9]+ sent, [0-9]+ overtaken by a newer one, [0-9]+ dropped, [0-9]+ due after" out ||
    fail "not what became of the forces"
  grep -Eq "^left +[0-9]+ samples missing, [0-9]+ forces late of [0-9]+ judged steps; [0-9]+ cuts" out || fail "no counts"
  grep -Eq " [0-9.]+ of 60 s simulated" out || fail "does not say how far it came"
  [ -s runs/figure-1-spring/summary.json ] || fail "nothing is kept"
}
case_long_scenarios_of_a_folder_run_only_when_asked_for() {
  mkdir folder
  printf '%s\n' 'format = 1' 'tags = ["long"]' '[case]' 'kind = "oscillator"' 'methods = ["symplectic-euler"]' \
    'values = [1, 3]' 'most_steps = 50' \
    '[[expect]]' 'signal = "case.*.*"' 'metric = "cells"' 'equals = 2' >folder/long.toml
  sed 's/"long"/"ci"/' folder/long.toml >folder/short.toml
  expect 0 "2 scenarios: 1 passed, 0 failed, 1 left out (long)" run folder
  expect 0 "2 scenarios: 2 passed, 0 failed" run --long folder
  expect 0 "refused" run folder/long.toml
}
case_a_case_writes_its_cells_and_its_strip() {
  printf '%s\n' 'format = 1' '[case]' 'kind = "oscillator"' 'methods = ["symplectic-euler"]' 'values = [1, 3]' \
    'most_steps = 50' '[[expect]]' 'signal = "case.*.*"' 'metric = "refused"' 'equals = 0' >x.toml
  expect 1 "symplectic-euler cpu" run x.toml
  grep -q '^symplectic-euler,cpu,3,refused,' runs/x/cells.csv || fail "cells.csv"
  grep -q '>refused<' runs/x/strip.svg || fail "strip.svg"
  grep -q '"case.symplectic-euler.cpu":{' runs/x/summary.json || fail "summary.json"
  grep -q '<failure' runs/x/junit.xml || fail "junit.xml"
  expect 0 "oscillator, 2 values from 1 to 3" check x.toml
  expect 2 "there is no clock" run --clock wall x.toml
}
case_diff_names_the_first_differing_event() {
  "$evenstep" run "$spring" --set 'run.duration="1 s"' --out a >out 2>err || fail "a"
  "$evenstep" run "$spring" --set 'run.duration="1 s"' --out b >out 2>err || fail "b"
  expect 0 "the same events" diff a b
  "$evenstep" run "$spring" --set 'run.duration="1 s"' --set 'timing.visualization="11.100001 ms"' --out c >out 2>err
  expect 1 "first difference at event" diff a c
  printf 'EVSTEP01 is not enough' >bad.bin
  expect 2 "bad.bin" diff a bad.bin
}
case_check_explains_without_running() {
  expect 0 "least: any device phase" check "$spring"
  expect 0 "for an hour, 95 % sure: 15.064444 ms with a lead of 0.259999 ms" check "$spring"
  no_run_folder
  expect 2 "error" check nowhere.toml
}
case_check_fails_what_cannot_start() {
  local tissue=$source_dir/scenarios/paper/figure-1.toml
  expect 1 'must fail: the step is above its limit, and the run will not start; substeps = "auto" or at least' check \
    "$tissue" --set scene.substeps=1
  expect 0 "expectations" check "$tissue" --set scene.substeps=1 --set scene.allow_unstable=true
  expect 0 "expectations" check "$source_dir/scenarios/extreme/unstable-step.toml"
}
case_run_refuses_the_scene_that_check_refuses() {
  local tissue=$source_dir/scenarios/paper/figure-1.toml command
  local wide='{ center = ["0 mm", "0 mm", "20 mm"], radius = "40 mm" }'
  for command in check run; do
    expect 2 "tool 0 holds no particle that can move" "$command" "$tissue" \
      --set 'device.left.grab.center=["9 m", "0 m", "0 m"]'
    grep -qE 'figure-1.toml:[0-9]+:[0-9]+: error' err || fail "no place: $command"
    expect 2 "both hold the particle" "$command" "$tissue" --set "device.left.grab=$wide" --set "device.right.grab=$wide"
  done
}
case_check_and_run_say_what_step_and_stiffness_are_stable() {
  local tissue=$source_dir/scenarios/paper/figure-1.toml
  expect 0 "ms in every configuration" check "$tissue"
  grep -Eq "dt_max [0-9.]+ ms .* k_max [0-9.]+ N/m" out || fail "no limits"
  grep -Eq "particle [0-9]+ at site \([0-9]+, [0-9]+, [0-9]+\) sets them" out || fail "which particle"
  expect 0 "implicit: stable at any step" check "$tissue" --set 'scene.method="implicit-euler"'
  grep -q inf out && fail "an infinite limit is printed"
  local small=(--set 'scene.lattice=[8, 7, 9]' --set scene.particles=490 --set 'run.duration="0.5 s"' --set 'expect=[]'
    --set scene.solver=cpu
    --set 'device.left.grab={ center = ["10 mm", "15 mm", "40 mm"], radius = "6 mm" }'
    --set 'device.right.grab={ center = ["25 mm", "15 mm", "40 mm"], radius = "6 mm" }')
  expect 0 "k_max " run "$tissue" "${small[@]}" --allow-no-expectations --verbose
  grep -q UNSTABLE out && fail "a stable step is called unstable"
  # A run that may start above the limit says that it does. For one that may not, the check says so.
  local above=("${small[@]}" --set scene.substeps=1 --set 'scene.stiffness="200 N/m"')
  "$evenstep" run "$tissue" "${above[@]}" --set scene.allow_unstable=true >out 2>err
  grep -Eq "UNSTABLE +the substep is [0-9.]+ times dt_max: allow_unstable lets it start" out || fail "not called unstable"
  "$evenstep" check "$tissue" "${above[@]}" >out 2>err
  grep -Eq "UNSTABLE .*a run is refused" out || fail "the check does not foresee the refusal"
}
small_study=(--set 'scene.lattice=[5, 5, 5]' --set 'device.left.grab.center=["10 mm", "10 mm", "20 mm"]'
  --set 'device.left.grab.radius="5.5 mm"' --set 'study.duration="8 ms"' --set study.repeats=1)
case_study_writes_table_csv_json_and_figures() {
  local block=$source_dir/scenarios/stiff/study-block.toml
  expect 0 "refused: above the limit of" study "$block" "${small_study[@]}" --set 'study.solvers=["cpu", "cpu-double"]' \
    --out s --advise "5 % force"
  grep -q "^cheapest for 5 % force: " out || fail "no advice"
  for file in report.html study.json study.csv resolved.toml position-error.svg force-error.svg energy-error.svg; do
    [ -s "s/$file" ] || fail "no $file"
  done
  expect 0 "figures and data" study s/resolved.toml --out s --set 'study.solvers=["cpu"]'  # its own folder is replaced
  mkdir t; echo mine >t/mine
  expect 3 "is not a run folder" study "$block" "${small_study[@]}" --out t
  [ -s t/mine ] || fail "somebody's folder was replaced"
  command -v python3 >/dev/null || { echo "skipped: no python3 to check the JSON"; exit 77; }
  "$evenstep" study "$block" "${small_study[@]}" --set 'study.solvers=["cpu"]' --json --out u >out 2>err || fail "exit"
  python3 -c 'import json, csv; d = json.load(open("out")); r = list(csv.DictReader(open("u/study.csv")))
assert len(d["cells"]) == len(r) == 51
assert all(c["state"] == x["state"] and ("error" in c) == bool(x["force"]) for c, x in zip(d["cells"], r))
assert 0 < d["reference"]["estimate"]["force"] < 0.01 and d["machine"] and d["compiler"]' || fail "JSON or CSV"
}
# in_shards TEXT KIND ARGUMENTS... : runs two shards, asks for their status and merges them. Except for what is measured, the
# merged lines must be those of one process. The merge prints TEXT, and so does `KIND --resume`, without running anything.
in_shards() {
  local text=$1 kind=$2 shard file
  shift 2
  "$evenstep" "$kind" "$@" --shard 1/1 --out one >out 2>err || fail "one process"
  expect 0 "$kind-2-of-2.jsonl" "$kind" "$@" --shard 2/2 --out parts
  expect 0 "1 of 2 shards have begun" "$kind" --status parts
  expect 2 "shard 1 of 2 is missing" merge parts/*.jsonl --out "whole/$kind.jsonl"
  expect 0 "$kind-1-of-2.jsonl" "$kind" "$@" --shard 1/2 --out parts
  expect 2 "leave it out" merge parts/*.jsonl --out "whole/$kind.jsonl" --junit j.xml
  [ ! -e "whole/$kind.jsonl" ] || fail "a refused merge was written"
  expect 0 "$text" merge "parts/$kind-2-of-2.jsonl" "parts/$kind-1-of-2.jsonl" --out "whole/$kind.jsonl"
  grep -q "in whole/$kind.jsonl" out || fail "the merge does not say where its lines are"
  "$evenstep" merge parts/*.jsonl --out "whole/$kind.jsonl" --json >out 2>err || fail "exit of --json"
  if command -v python3 >/dev/null; then python3 -c 'import json; json.load(open("out"))' || fail "not JSON"; fi
  for file in one whole; do sed 's/,"measured":{.*/}/' "$file/$kind.jsonl" >"$file.certain"; done
  [ "$(wc -l <one.certain)" -gt 2 ] || fail "there are no lines"
  cmp -s one.certain whole.certain || fail "merged lines differ"
  cp "whole/$kind.jsonl" before
  expect 0 "$text" "$kind" "$@" --resume --out whole
  cmp -s before "whole/$kind.jsonl" || fail "--resume changed a complete file"
  expect 2 "must be I/N" "$kind" "$@" --shard 3/2
  expect 2 "there is no folder 'nowhere'" "$kind" --status nowhere
  expect 2 "has no part of a sweep" sweep --status parts
  expect 2 "takes" "$kind" "$@" --status parts
  sed -i '2s/"index":0/"index":2/' "whole/$kind.jsonl"
  expect 3 "whole/$kind.jsonl:2: error: the line" "$kind" "$@" --resume --out whole
}
case_catalogue_in_shards() {
  local cases=("$source_dir/scenarios/stiff/s2-over-the-limit.toml" "$source_dir/scenarios/extreme/unstable-step.toml")
  in_shards "2 scenarios: 2 passed, 0 failed, 0 left out" catalogue "${cases[@]}"
  [ -s whole/s2-over-the-limit/strip.svg ] || fail "no strip"
  [ -s whole/catalogue/s2-over-the-limit/strip.svg ] || fail "no strip of the merge"
  expect 1 "0 passed, 1 failed" catalogue "${cases[0]}" \
    --set 'expect=[{ signal = "case.implicit-euler.cpu", metric = "diverged", equals = 1 }]'
}
# A merge gives the verdict of what it merges, and none if the scenario is no longer the one that the shards ran.
case_merge_of_a_catalogue_judges_it() {
  local shard
  mkdir cases
  cp "$source_dir/scenarios/stiff/s2-over-the-limit-allowed.toml" cases/a.toml
  cp "$source_dir/scenarios/stiff/s2-over-the-limit-allowed.toml" cases/long.toml
  sed -i 's/^tags .*/tags = ["long"]/' cases/long.toml
  local set='expect=[{ signal = "case.symplectic-euler.cpu", metric = "diverged", equals = 4 }]'
  for shard in 1 2; do expect 0 "5 of 5 points" catalogue cases --set "$set" --shard $shard/2 --out parts; done
  expect 1 "1 scenarios: 0 passed, 1 failed, 1 left out (long)" merge parts/*.jsonl --out c.jsonl
  grep -qx FAIL out || fail "no verdict"
  [ -s c/a/strip.svg ] || fail "no run folder beside the file"
  "$evenstep" merge parts/*.jsonl --out c.jsonl --json >out 2>err
  [ $? -eq 1 ] || fail "the exit code of --json is another one"
  grep -q '"verdict":"FAIL"' out && grep -q '"failed":1' out || fail "no verdict in JSON"
  for shard in 1 2; do expect 0 "10 of 10 points" catalogue cases --long --shard $shard/2 --out long; done
  expect 0 "2 scenarios: 2 passed, 0 failed, 0 left out" merge long/*.jsonl --out l.jsonl
  echo '# another' >>cases/a.toml
  expect 1 "0 passed, 1 failed" merge parts/*.jsonl --out d.jsonl   # a comment changes nothing
  sed -i 's/^values .*/values = [2.5]/' cases/a.toml
  expect 3 "there are no results" merge parts/*.jsonl --out d.jsonl
  grep -q "is of another catalogue" err || fail "why is not said"
  rm -r cases
  expect 3 "there are no results" merge parts/*.jsonl --out d.jsonl
  [ -s d.jsonl ] || fail "the merged lines are gone"
}
case_size_of_many_seeds_in_shards() {
  swept ''
  in_shards "At most 5 % of the segments" size s.toml --rate "5 %" --seeds 0..6
  "$evenstep" size s.toml --rate "5 %" --seeds 0..6 --resume --out one --json >out 2>err || fail "exit"
  python3 -c 'import json; assert json.load(open("out"))["segments"] > 50' || fail "JSON"
  for option in "--split 2" "--adaptive" "--damping 2" "--timing t.csv" "--segment a"; do
    # shellcheck disable=SC2086   # its words are options
    expect 2 "--seeds finds rates of the scenario as it is" size s.toml --rate "5 %" --seeds 0..6 $option --out x
  done
  expect 2 "--seeds makes the sample for --rate larger" size s.toml --seeds 0..6
  expect 2 "is no span" size s.toml --rate "5 %" --seeds 6..0
  for option in "--shard 1/2" "--of 2" "--threads 1" "--resume"; do
    # shellcheck disable=SC2086   # its words are options
    expect 2 "divide the seeds of --seeds" size s.toml --rate "5 %" $option
  done
  expect 2 "the same timing with every seed" size "$spring" --rate "5 %" --seeds 0..6
  [ ! -e x ] || fail "a refused sizing was written"
}
case_study_in_shards() {
  in_shards "cpu-double  velocity-verlet" study "$source_dir/scenarios/stiff/study-block.toml" "${small_study[@]}" \
    --set 'study.solvers=["cpu-double"]' --set 'study.methods=["velocity-verlet"]'
  [ -s whole/position-error.svg ] && [ -s whole/study.json ] || fail "no figure, or no study.json"
  [ -s whole/study/position-error.svg ] && [ -s whole/study/study.json ] || fail "no figure, or no study.json, of the merge"
  for option in "--of 2" "--threads 1"; do
    # shellcheck disable=SC2086   # its words are options
    expect 2 "divide the points of --shard or --resume" study "$source_dir/scenarios/stiff/study-block.toml" $option
  done
}
case_study_of_the_felt_force_keeps_its_reference() {
  local block=$source_dir/scenarios/stiff/study-block.toml
  local felt=("${small_study[@]}" --set study.error=felt-force --set 'run.warmup="96 ms"' --set 'run.duration="0.12 s"'
    --set 'device.left.motion.delay="64 ms"'
    --set 'study.solvers=["cpu"]' --set 'study.step_sizes=["0.5 ms"]' --set 'study.iterations=[5]')
  XDG_CACHE_HOME=$work/cache expect 0 "felt error" study "$block" "${felt[@]}" --out f --advise "5 % force"
  grep -q "^cheapest for 5 % force: phase_locked" out || fail "no advice"
  grep -q "^  reference   .*CPU s" out && grep -q "^  all  .*CPU s" out || fail "the cost was not announced"
  compgen -G "$work/cache/evenstep/reference-*.txt" >/dev/null || fail "no reference below XDG_CACHE_HOME"
  XDG_CACHE_HOME=$work/cache expect 0 "reference   stored: " study "$block" "${felt[@]}" --out f
  expect 0 "now stored" study "$block" "${felt[@]}" --out f --cache here
  compgen -G "here/reference-*.txt" >/dev/null || fail "no reference below --cache"
  for file in report.html study.json study.csv resolved.toml error-against-cost.svg; do
    [ -s "f/$file" ] || fail "no $file"
  done
  command -v python3 >/dev/null || { echo "skipped: no python3 to check the JSON"; exit 77; }
  "$evenstep" study "$block" "${felt[@]}" --cache here --json --out u >out 2>err || fail "exit"
  python3 -c 'import json, csv; d = json.load(open("out")); r = list(csv.DictReader(open("u/study.csv")))
assert len(d["points"]) == len(r) == 3
assert all(float(x["felt_rms_N"]) == p["total"]["rms_N"] for p, x in zip(d["points"], r))
assert d["error"] == "felt-force" and d["reference"]["stored"]' || fail "JSON or CSV"
}
case_study_says_that_a_solver_is_unavailable() {
  local block=$source_dir/scenarios/stiff/study-block.toml
  OCL_ICD_VENDORS=$work/none expect 0 "unavailable: no OpenCL platform is installed" study "$block" "${small_study[@]}" \
    --set 'study.solvers=["opencl", "cpu"]' --set 'study.methods=["symplectic-euler"]' --advise "5 % force"
}
case_study_refuses_bad_input() {
  local block=$source_dir/scenarios/stiff/study-block.toml
  expect 1 "cannot tell what meets 1e-20 % force" study "$block" "${small_study[@]}" \
    --set 'study.methods=["symplectic-euler"]' --advise "1e-20 % force"
  expect 2 "--advise: error: \"1 kg\"" study "$block" --advise "1 kg"
  expect 2 "error: error = \"state\" compares the steps of a tissue" study "$spring" --set study.error=state
  expect 2 "a study of the felt force knows no other error" study "$spring" --advise "1 % energy"
  expect 2 "no such file" study nowhere.toml
  expect 2 "'repeats': 0 is out of range" study "$block" --set study.repeats=0
}
case_list_names_scenarios_and_metrics() {
  (cd "$source_dir" && "$evenstep" list) >out 2>err || fail "list"
  grep -q "figure-1.toml" out || fail "scenario"
  grep -q "velocity_jump" out || fail "metrics"
}
case_schema_is_json() {
  "$evenstep" schema >out 2>err || fail "schema"
  command -v python3 >/dev/null || { echo "skipped: no python3 to check the JSON"; exit 77; }
  python3 -m json.tool out >/dev/null || fail "not JSON"
}
case_schema_accepts_every_shipped_scenario() {
  "$evenstep" schema >schema.json || fail "schema"
  command -v python3 >/dev/null || { echo "skipped: no python3 to validate with"; exit 77; }
  python3 "$source_dir/tests/format/validate.py" schema.json "$source_dir/scenarios" "$source_dir/tests/vm" >out 2>err ||
    fail "not valid"
  ! grep "^skipped:" out || exit 77
}
case_a_mistyped_command_or_option_gets_a_suggestion() {
  expect 2 "unknown command 'rnu'; did you mean 'run'?" rnu x.toml
  expect 2 "run has no option '--sed'; did you mean '--seed'?" run x.toml --sed 3
  expect 2 "run has no option '--sed'; did you mean '--seed'?" run x.toml --sed=3
  expect 0 "version information" help
  grep -qi "^many runs:" out || fail "no groups of commands: evenstep help"   # CLI11 2.6 writes it in capitals
  expect 0 "--permute-ties" help run
  expect 2 "--seed: '-1' is no seed; write a whole number from 0 to 9223372036854775807" run x.toml --seed -1
  expect 2 "--seed: '9223372036854775808' is no seed" run x.toml --seed 9223372036854775808
  expect 0 "seed 9223372036854775807" run "$source_dir/scenarios/paper/figure-1-spring.toml" --seed 9223372036854775807
  expect 2 "--seed: '1.5' is no seed" run x.toml --seed 1.5
}
case_a_value_that_is_written_wrongly_gets_its_remedy() {
  scenario '[timing]' 'visualization = "6,5 ms"'
  expect 2 "x.toml:5:17: error: 'visualization': '6,5 ms' has a comma, and the decimal mark is a point" check x.toml
  scenario '[scene]' 'kind = spring'
  expect 2 'in quotes: "spring"' check x.toml
  for bare in '11.1 ms' 11.1ms 11ms 30Hz; do
    scenario '[timing]' "visualization = $bare"
    expect 2 'numbers with a unit, are written in quotes: "spring", "11.1 ms"' check x.toml
  done
  scenario '[timing]' 'steps = "1 ms"'
  expect 2 "x.toml:5:9: error: 'steps': \"1 ms\" must be a whole number, or a list of them, without quotes or unit: 1" \
    check x.toml
  scenario '[[expect]]' 'signal = "left.force.direct"' 'metric = "late"' 'max = "1 ms"'
  expect 2 "'late' is a count; write the number alone, 1, without 'ms'" check x.toml
  scenario '[[expect]]' 'signal = "left.force.direct"' 'metric = "velocity_jmp"' 'max = "1 step"'
  expect 2 "x.toml:6:10: error: unknown metric 'velocity_jmp' for signal 'left.force.direct'; did you mean 'velocity_jump'" \
    check x.toml
  scenario '[[expect]]' 'signal = "left.force.direct"' 'metric = "late"' 'min = 0' '  max = "1 ms"'
  expect 2 "x.toml:8:9: error: 'late' is a count" check x.toml
  scenario 'expect = [{ signal = "left.force.direct", metric = "ltae", max = 1 }]'
  expect 2 "x.toml:4:52: error: unknown metric 'ltae' for signal 'left.force.direct'; did you mean 'late'?" check x.toml
}
need_python() { command -v python3 >/dev/null || { echo "skipped: no python3 to check the JSON"; exit 77; }; }
case_list_says_the_same_as_json() {
  need_python
  (cd "$source_dir" && "$evenstep" list scenarios/paper scenarios/timing >"$work/text" && "$evenstep" list --json \
    scenarios/paper scenarios/timing) >out 2>err || fail "exit"
  python3 - <<'CHECK' || fail "not the same"
import json
listed, text = json.load(open("out")), open("text").read()
rows = [line.split() for line in text.splitlines() if line]
for scenario in listed["scenarios"]:
    assert f'{scenario["file"]:<48} {scenario["name"]}\n' in text, scenario
for table in ("strategies", "solvers", "methods", "motions"):
    assert [table] + listed[table] in rows, table
for signal, metrics in listed["metrics"].items():
    assert [signal] + list(metrics) in rows, signal
assert len(rows) == len(listed["scenarios"]) + 4 + len(listed["metrics"])
assert "back-and-forth" in listed["motions"] and listed["metrics"]["DEVICE.force.STRATEGY"]["jump_max"] == "N"
CHECK
}
case_check_says_the_same_as_json_and_exits_alike() {
  need_python
  mkdir folder
  scenario '[remap]' 'latency = "12 ms"' '[[device]]' 'name = "left"' 'force_limit = "1 N"' \
    'motion = { kind = "constant-velocity", velocity = ["0.1 m/s", "0 m/s", "0 m/s"] }'
  cp x.toml folder/fails.toml
  printf 'format = 1\nnmae = "x"\n' >folder/refused.toml
  cp x.toml folder/open.toml
  sed -i 's/12 ms/40 ms/; s/1 N/1 kN/' folder/open.toml
  "$evenstep" check folder >text 2>err; local code=$?
  expect $code '"verdict": "refused"' check folder --json
  python3 - <<'CHECK' || fail "not the same"
import json
text = open("text").read()
fails, opened, refused = json.load(open("out"))
assert fails["verdict"] == "must fail" and opened["verdict"] == "open" and refused["verdict"] == "refused"
assert [one["line"] for one in refused["errors"] if one["message"].startswith("unknown key 'nmae'")] == [2]
assert fails["must_fail"] and all(one["why"] in text for one in fails["must_fail"])
assert fails["saturation"][0]["cause"] == "clamp" and fails["errors"][0]["line"] > 0
assert not opened["must_fail"] and not opened["saturation"] and not opened["errors"]
for one in (fails, opened):
    assert "not used     " + ", ".join(one["left_out"]) + "\n" in text
    assert f'  expectations {one["expectations"]}\n' in text and one["name"] in text and one["scene"] in text
    for strategy in one["strategies"]:
        assert f'{strategy["name"]:<12} lead {strategy["lead_ns"] / 1e6:.6f} ms, latency ' in text
CHECK
  expect 0 '"verdict": "open"' check folder/open.toml --json
  python3 -c 'import json; assert json.load(open("out"))["file"] == "folder/open.toml"' || fail "not one object"
}
case_check_says_what_governor_faults_and_source_will_do() {
  expect 0 "least: any device phase" check "$spring"
  ! grep -Eq "^  (governor|fault|faults end|source) " out || fail "of a scenario that sets none of them"
  # With 15 steps of 1.482222 ms, 31 segments with V of 11.1 ms begin before 1 s, then three with 12 ms before 1.11 s, and
  # the next one begins at 31 * 33.33333 + 3 * 34.23333 ms. The other fault is 20 ticks of 1 kHz from 1.5 s on.
  scenario '[run]' 'duration = "4 s"' '[timing]' \
    'changes = [{ at = "1 s", visualization = "12 ms" }, { at = "1.11 s", visualization = "11.1 ms" }]'
  local faults=(--set 'device.left.faults=[{ kind = "lost", at = "1.5 s", ticks = 20 }]' --set 'expect=[]')
  expect 0 "  fault        timing.changes: 1 s to 1.13603322 s" check x.toml "${faults[@]}"
  grep -qxF "  fault        device.left.faults.0: 1.5 s to 1.52 s" out || fail "the device's fault"
  grep -qxF "  faults end   1.52 s: recovery_time counts from there" out || fail "the last end"
  expect 0 "  fault        timing.spikes: 0 s until the end of the run" check x.toml "${faults[@]}" \
    --set 'timing.spikes={ rate = "10 Hz", cost = "1 ms" }'
  grep -qxF "  faults end   not in this run, so there is no recovery_time" out || fail "a fault that lasts"
  expect 0 "  fault        timing.changes: 1 s and not over when the run ends" check x.toml --set 'expect=[]' \
    --set 'run.duration="1.12 s"'
  # With an uneven schedule, a stall, the check gives the same instant as the run.
  local stall=$source_dir/scenarios/timing/stall.toml
  local wants='expect=[{ signal = "left.force.phase_locked", metric = "recovery_time", max = "1 s" }]'
  local over
  expect 2 "its last fault is over at " run "$stall" --set 'run.duration="3.8 s"' --set "$wants" \
    --set 'run.strategies=["phase_locked"]'
  over=$(cat out err | sed -n 's/.*its last fault is over at \([0-9.]*\) s.*/\1/p' | head -1)
  [ -n "$over" ] || fail "no instant"
  "$evenstep" check "$stall" >out 2>err
  # The run prints six digits.
  [ "$(sed -n 's/^  faults end   \([0-9.]*\) s: .*/\1/p' out | xargs printf '%.6g')" = "$over" ] || fail "not $over"
  need_python
  # A governor: the check counts as many drawings as the run finishes and leaves out.
  local merge=$source_dir/scenarios/pauses/regime-merge.toml
  local short=(--set 'run.duration="6 s"' --set 'expect=[]' --set 'timing.governor.budget="10 ms"')
  "$evenstep" run "$merge" "${short[@]}" --set 'run.strategies=["direct"]' --allow-no-expectations --out governed \
    >out 2>err || fail "the run"
  expect 0 "  governor     split 2, budget 10 ms merge: what a drawing takes longer is drawn in the next pauses" \
    check "$merge" "${short[@]}"
  "$evenstep" check "$merge" "${short[@]}" --json >check.json 2>err || fail "exit"
  "$evenstep" check x.toml "${faults[@]}" --json >faults.json 2>err || fail "exit"
  # A source: the check knows the closed forms of docs/choose/sources.md, and how many entries are needed.
  expect 0 "; at least phase_locked 15.999999 ms, linear 15.999999 ms, polyphase 45.999999 ms, " \
    check "$source_dir/scenarios/sources/slower-clean.toml"
  grep -qF "  source       delay 3 ms, jitter 0 ms, lost 0 %, late 0 % by 0 ms, clock 0 ppm; " out || fail "the source"
  local chunks=$source_dir/scenarios/sources/chunks.toml
  "$evenstep" check "$chunks" --json >chunks.json 2>err || fail "exit"
  expect 0 " entries of 3 set, so ticks will run dry" check "$chunks" --set source.chunk.entries=3 --set 'expect=[]'
  ! "$evenstep" check "$chunks" | grep -q "run dry" || fail "20 entries are enough"
  python3 - <<'CHECK' || fail "not the same"
import csv, glob, json
check = json.load(open("check.json"))
governor, run = check["governor"], check["run"]
metrics = json.load(open(glob.glob("governed/**/summary.json", recursive=True)[0]))["metrics"]["solver.direct"]
value = metrics.get
assert governor["left_out"] == value("drawings_left_out") > 0, governor
judged_s = (run["duration_ns"] - run["judged_from_ns"]) / 1e9
assert abs(value("drawing_rate") * judged_s - governor["drawings"]) < 1e-9 and governor["drawings"] > 10, governor
assert (governor["split"], governor["budget_ns"], governor["over_budget"]) == (2, 10_000_000, "merge")
faults = json.load(open("faults.json"))
assert [one["name"] for one in faults["faults"]] == ["timing.changes", "device.left.faults.0"]
assert faults["faults"][0]["to_ns"] == 1_136_033_220 and faults["faults_end_ns"] == 1_520_000_000
source = json.load(open("chunks.json"))["source"]
assert source["entries"] == 20 and 0 < source["least_entries"]["chunk_replace"] <= 20, source
assert source["least_latency_ns"]["linear"] > 200_000_000 and source["delay_ns"] == 5_000_000
CHECK
}
case_check_cost_measures_each_part_and_says_that_no_bit_changed() {
  scenario '[run]' 'duration = "1 s"'
  expect 0 "  left out     what it would add" check x.toml --cost
  grep -Eq "^    strategy paper +(not measurable,|[0-9.]+) % of the run \[.*; trace hashes of 3 strategies equal; " out ||
    fail "no strategy"
  grep -Eq "^    OpenCL .*not loaded: no solver needs it" out || fail "no library"
  expect 0 "nothing is measured: the run stops: " check "$source_dir/scenarios/extreme/unstable-step.toml" --cost
  expect 3 "nothing is measured: the run stops: " check "$source_dir/scenarios/paper/figure-1.toml" --cost \
    --set scene.substeps=1
  ! grep -q "differ" out || fail "bits"
  need_python
  "$evenstep" check x.toml --cost --json >out 2>err || fail "exit"
  python3 -c 'import json; cost = json.load(open("out"))["cost"]
assert cost["same_bits"] and {"figures", "threads", "hidapi"} <= {part["part"] for part in cost["parts"]}' || fail "JSON"
}
case_a_closed_pipe_is_no_error() {
  set -o pipefail
  (cd "$source_dir" && "$evenstep" list 2>"$work/err" | head -1 >"$work/out") || fail "exit"
  [ ! -s err ] || fail "an error is printed"
  "$evenstep" schema 2>err | head -1 >out || fail "exit of schema"
  [ ! -s err ] || fail "an error is printed by schema"
}
# printed_commands : the commands that out, err and the files of the last run offer for pasting, one per line
printed_commands() {
  {
    sed -nE 's/^(again|next): (.*)/\2/p; s/^ +([^ ].* run .* --seed .*)$/\1/p' out
    cat runs/*/junit.xml 2>/dev/null | python3 -c '
import html, re, sys
print("\n".join(re.findall("^reproduce: (.*)$", html.unescape(sys.stdin.read()), re.M)))'
    grep -ohE '`[^`]+ (devices|list|init|sweep)`' out err | tr -d '`'
  } | sed '/^$/d' | sort -u
}
# each_works CODES : every printed command ends with one of these codes when it is pasted; there is at least one
each_works() {
  local line code count=0
  printed_commands >commands
  while IFS= read -r line; do
    bash -c "$line" >again.out 2>&1 </dev/null
    code=$?
    grep -qw -- "$code" <<<"$1" || { cat again.out; fail "exit $code of the printed command: $line"; }
    count=$((count + 1))
  done <commands
  ((count > 0)) || fail "no command was printed"
  rm -rf runs
}
# The program is in its own folder, is found through PATH, and has a name that needs quotes.
case_printed_commands_work_as_printed() {
  mkdir 'my bin'
  ln -s "$evenstep" 'my bin/even step'
  ln -s "$evenstep" 'my bin/evenstep'
  local started shard
  for started in "$evenstep" 'my bin/even step' evenstep; do
    PATH=$PWD/my\ bin:$PATH
    evenstep=$started
    scenario '[[expect]]' 'signal = "left.force.direct"' 'metric = "underruns"' 'equals = 99'
    mv x.toml "it's mine.toml"
    expect 1 "again: " run "it's mine.toml" --set 'run.duration=0.5 s' --permute-ties 3
    each_works 1
    cp "it's mine.toml" ./-x.toml
    expect 1 "again: " run -- -x.toml
    each_works 1
    # What follows prints other arguments, so the name that is hardest to quote is enough.
    [[ $started == *' '* ]] || continue
    scenario '[timing]' 'vsualization = "1 ms"'
    expect 2 "vsualization" run x.toml --out runs/x
    each_works 2
    swept ''
    expect 1 "6 points" sweep s.toml
    each_works 1
    rm -rf parts
    for shard in 1/2 2/2; do
      "$evenstep" sweep s.toml --shard $shard --set remap.lead='0.9 ms' --set sweep.keep_worst=9 --out parts >out 2>err
    done
    expect 1 "6 points" merge parts/*.jsonl --out merged.jsonl
    each_works 1
    grep -q "remap.lead=0.9 ms'" commands || fail "the merge forgets --set"
    expect 0 "again: " shrink s.toml --seed 0 --set remap.latency="9 ms" --out 'shrunk here'
    each_works 1
    expect 0 "next: " init "mine $RANDOM"
    each_works 0
    expect 3 "remedy: " run --clock wall --device /dev/nowhere "$source_dir/scenarios/live/figure-1-spring.toml"
    grep -q 'devices`' out || fail "no hint"
    each_works '0 3'
  done
}
case_printed_commands_start_as_the_script_was_started() {
  mkdir clone
  cp "$source_dir/run.sh" clone/
  mkdir clone/scripts
  printf 'set_up() { build=%q; }\n' "$work/build" >clone/scripts/setup.sh
  mkdir -p build/apps
  ln -s "$evenstep" build/apps/evenstep
  scenario '[[expect]]' 'signal = "left.force.direct"' 'metric = "underruns"' 'equals = 99'
  local there
  for there in './run.sh' 'bash run.sh' '../clone/run.sh' "'$work/clone/run.sh'" "bash '$work/clone/run.sh'"; do
    (cd clone && bash -c "$there run ../x.toml") >out 2>err && fail "$there: no failure"
    grep -q "^again: .*run\.sh'* run ../x.toml" out || fail "$there: not the script"
    (cd clone && bash -c "$(sed -n 's/^again: //p' ../out)") >again.out 2>&1
    [ $? -eq 1 ] || { cat again.out; fail "$there: its command does not work"; }
  done
}
# on_github ARGUMENTS... : runs the program in the repository $work, as a step of GitHub Actions, whose runner reads pipes.
on_github() (
  export GITHUB_ACTIONS=true GITHUB_WORKSPACE=$work GITHUB_STEP_SUMMARY=$work/summary.md
  {
    "$evenstep" "$@" 2>&3 | cat >"$work/out"
    exit "${PIPESTATUS[0]}"
  } 3>&1 | cat >"$work/err"
  exit "${PIPESTATUS[0]}"
)
case_github_marks_what_fails_at_its_line_and_gets_a_table() {
  mkdir sub
  cp "$spring" sub/spring.toml
  printf '%s\n' 'format = 1' 'extends = ["spring.toml"]' 'name = "x, y: 50 %"' '[[expect_append]]' \
    'signal = "left.force.direct"' 'metric = "underruns"' 'equals = 99' 'because = "a|b"' >'sub/a,b.toml'
  cp sub/spring.toml sub/passes.toml
  printf 'before\n' >summary.md
  (cd sub && on_github run a,b.toml passes.toml)
  [ $? -eq 1 ] || fail "not exit 1"
  [ "$(grep -c '^::' err)" -eq 1 ] || fail "not one annotation"
  local head='::error file=sub/a%2Cb.toml,line=4,col=1,title=evenstep%3A x%2C y%3A 50 %25::'
  grep -qF "${head}left.force.direct underruns: " err || fail "not at its line"
  grep -qF '%0Abecause: a|b%0Aagain: ' err || fail "no reason, or no command"
  grep -qF '| a,b.toml | FAIL | ' summary.md || fail "no row of the failure"
  grep -qF '| passes.toml | PASS | ' summary.md || fail "no row of the pass"
  grep -qx 'before' summary.md || fail "the summary of another step is gone"
  cp out github.out
  (cd sub && "$evenstep" run a,b.toml passes.toml) >out 2>err
  sed -i 's/in .* s of CPU.*//; s/^solver waits.*//' out github.out
  cmp -s out github.out || fail "stdout is another one on GitHub"
  ! grep -q '^::' err || fail "annotations without GitHub"
}
case_github_marks_bad_input_and_warnings() {
  scenario '[timing]' 'vsualization = "1 ms"' 'visualization = "1 msec"'
  on_github check x.toml
  [ $? -eq 2 ] || fail "not exit 2"
  grep -qF "::error file=x.toml,line=5,col=1,title=evenstep::x.toml:5:1: error: unknown key 'vsualization'" err || fail "key"
  grep -qF '::error file=x.toml,line=6,col=17,' err || fail "value"
  on_github run nowhere
  grep -qF '::error file=nowhere,title=evenstep::nowhere: error: ' err || fail "a file that is not there"
  on_github run --sed 3
  grep -qF '::error title=evenstep::evenstep: error: run has no option' err || fail "usage"
  scenario '[remap]' 'latency = "5 ms"'
  on_github check x.toml
  grep -q '^::error file=.*figure-1-spring.toml,line=[0-9]*,col=1,title=evenstep%3A must fail::.*underruns' err ||
    fail "what must fail is not marked"
  scenario 'expect = []'
  on_github run x.toml
  grep -qF '::error file=x.toml,title=evenstep%3A x::NO VERDICT' err || fail "no verdict is no error"
  on_github run x.toml --allow-no-expectations || fail "not allowed"
  grep -qF '::warning file=x.toml,title=evenstep%3A x::NO VERDICT' err || fail "no verdict is no warning"
  on_github run --json x.toml
  python3 -m json.tool <out >/dev/null || fail "stdout is no JSON"
  rm -f summary.md
  mkdir summary.md
  on_github run "$spring" || fail "a summary that cannot be written is no failure of the run"
  grep -q '^::warning title=evenstep::.*summary' err || fail "nothing is said of the summary"
}
# Text that a runner would take for a command, in every place where a scenario, a file name or an option can have text.
case_github_finds_no_command_in_the_text_of_others() {
  local evil='x\n::set-output name=a::b\r::add-mask::c ##[set-output name=d;]e'
  local raw=$'::set-output name=a::b\n::set-output name=c::d ##[set-output name=d;]e'
  mkdir ./::set-output' name=f::'
  {
    printf 'format = 1\nextends = ["%s"]\nname = "%s"\nbecause = "%s"\ntags = ["%s"]\n' "$spring" "$evil" "$evil" "$evil"
    printf '[[expect_append]]\nsignal = "left.force.direct"\nmetric = "underruns"\nequals = 99\nbecause = "%s"\n' "$evil"
  } >x.toml
  { cat x.toml; printf '[timing]\n"%s" = "%s"\nvisualization = "%s"\n' "$evil" "$evil" "$evil"; } >y.toml
  printf 'format = 1 \n::set-output name=a::b ##[set-output name=d;]e\n' >z.toml
  cp x.toml ./::set-output' name=f::/::g.toml'
  local call words ours='^::(error|warning) (file=[^:,]*,)?(line=[0-9]+,)?(col=[0-9]+,)?title=[^:,]*::'
  for call in 'run x.toml' 'run y.toml' 'run z.toml' 'check x.toml' 'check y.toml' 'check z.toml' 'list .' 'run .' \
    'check .' "run|$raw" "check|$raw" "diff|$raw|x" "run|--set|$raw|x.toml" "run|--$raw|x.toml" "$raw" \
    "run|x.toml|--out|$raw"; do
    if [[ $call == *'|'* ]]; then IFS='|' read -r -d '' -a words <<<"$call"; else read -r -a words <<<"$call"; fi
    on_github "${words[@]}"
    # Our own annotations are one line each, "::error" or "::warning".
    if { cat out; grep -avE "$ours" err; } | tr '\r' '\n' | grep -aE '^[[:space:]]*::|##\['; then
      fail "a command in the output of: evenstep ${words[*]}"
    fi
  done
  ! grep -aE '^[[:space:]]*::' summary.md || fail "a line of the summary"
}
case_init_writes_what_check_and_run_accept() {
  expect 0 "next: " init mine
  (cd mine && find . -type f | sort) >files
  local expected='./.github/workflows/evenstep.yml ./.gitlab-ci.yml ./CMakeLists.txt ./scenarios/first.toml'
  [ "$(xargs <files)" = "$expected" ] || fail "other files: $(xargs <files)"
  expect 0 "with these: 0 samples missing, 0 forces late" check mine/scenarios/first.toml
  expect 0 "expectations 3 of 3 hold" run mine/scenarios/first.toml --repeat
  expect 1 "FAIL" run mine/scenarios/first.toml --set 'remap.latency=12 ms'
  mkdir here && cd here || exit 1
  expect 0 "next: " init
  [ -e scenarios/first.toml ] || fail "not in the working directory"
}
case_init_replaces_nothing_and_leaves_nothing_half_written() {
  mkdir mine
  printf 'mine\n' >mine/CMakeLists.txt
  ln -s nowhere mine/.gitlab-ci.yml
  expect 2 "mine/CMakeLists.txt: error: is there already" init mine
  grep -qF "mine/.gitlab-ci.yml: error: is there already" err || fail "does not list all"
  [ "$(ls -A mine | xargs)" = '.gitlab-ci.yml CMakeLists.txt' ] || fail "something was written: $(ls -A mine)"
  [ "$(cat mine/CMakeLists.txt)" = mine ] || fail "replaced"
  mkdir blocked
  printf x >blocked/.github
  expect 3 "blocked/.github/workflows/evenstep.yml: error: cannot be written" init blocked
  [ -z "$(find blocked -type f ! -name .github)" ] || fail "half of it was written"
}
case_init_writes_workflows_that_a_yaml_parser_accepts() {
  python3 -c 'import yaml' 2>/dev/null || { echo "skipped: python3-yaml is not installed"; exit 77; }
  expect 0 "next: " init mine
  python3 - mine <<'END' || fail "not what GitHub or GitLab reads"
import sys, yaml
github = yaml.safe_load(open(sys.argv[1] + "/.github/workflows/evenstep.yml"))
assert set(github) == {"name", True, "permissions", "jobs"}, set(github)  # YAML 1.1 reads the key `on` as true
assert github[True] == ["push", "pull_request"] and github["permissions"] == {"contents": "read"}
(job,) = github["jobs"].values()
assert set(job) == {"runs-on", "container", "env", "steps"}
for step in job["steps"]:
    assert ("run" in step) != ("uses" in step) and set(step) <= {"run", "uses", "if", "with"}, step
assert any("run.sh\" run scenarios" in step.get("run", "") for step in job["steps"])
gitlab = yaml.safe_load(open(sys.argv[1] + "/.gitlab-ci.yml"))
(job,) = gitlab.values()
assert set(job) == {"image", "variables", "script", "artifacts"}
assert all(isinstance(line, str) for line in job["script"]), job["script"]
assert job["artifacts"]["when"] == "always" and job["artifacts"]["reports"]["junit"] == "runs/*/junit.xml"
END
}
case_fit_proposes_a_timing_that_check_accepts() {
  expect 0 "paced = true" fit "$source_dir/scenarios/recorded/small-paced30-basic.csv"
  printf '%s\n' 'format = 1' '[run]' 'duration = "1 s"' '[scene]' 'kind = "spring"' '[[device]]' 'name = "left"' >fitted.toml
  cat out >>fitted.toml
  expect 0 "segment 33.333333 ms" check fitted.toml
}
case_a_recording_of_a_live_run_is_replayed_as_far_as_it_is_whole() {
  local live=$source_dir/scenarios/live/figure-1-spring.toml size third
  expect 0 "NO VERDICT" run --clock wall --record first.rec "$live" --set 'run.duration="0.5 s"' --set 'expect=[]' \
    --allow-no-expectations
  expect 0 "the recorded inputs replay to the same trace" replay first.rec --strategy paper --timing whole.csv
  grep -q '^recording    0.5 s of 0.5 s: ' out && ! grep -q '^EQUAL' out || fail "a whole recording is judged"
  [ "$(grep -cE '^(phase_locked|paper|direct|ideal) ' out)" -eq 2 ] || fail "not the live strategy and the one asked for"
  expect 2 "--strategy: error: 'papr' is no strategy; did you mean 'paper'?" replay first.rec --strategy papr
  expect 3 "no/t.csv: error: cannot be written: there is no folder 'no'" replay first.rec --timing no/t.csv
  size=$(stat -c %s first.rec)
  third=$((size * 2 / 3))
  head -c $third first.rec >cut.rec
  expect 0 "it has no last block: its writer was killed, its disk was full, or the run failed" replay cut.rec
  grep -qE '^EQUAL until 0\.[0-9]+ s; what follows until 0.5 s is not in the recording, and no expectation is judged$' out ||
    fail "not said until when"
  { head -c $third first.rec; printf 'XXXX'; tail -c +$((third + 5)) first.rec; } >bad.rec
  expect 2 "has a wrong checksum: the file was changed, or its disk lost something; --before-damage replays" replay bad.rec
  expect 0 " is damaged: what stands before it is replayed, and " replay bad.rec --before-damage --timing part.csv
  head -n "$(($(wc -l <part.csv) - 5))" part.csv | cmp -s - <(head -n "$(($(wc -l <part.csv) - 5))" whole.csv) ||
    fail "other times before the damage"
  "$evenstep" replay first.rec --json >out 2>err || [ $? -eq 1 ] || fail "exit of --json"
  grep -q '"file":"first.rec:scenario"' out && ! grep -q '^recording ' out || fail "not JSON alone"
  # The same times by import, which needs no scenario.
  expect 0 "first.rec: recording of a live run, " import first.rec
  expect 0 "wrote timing.csv" import first.rec --out timing.csv
  cmp -s timing.csv whole.csv || fail "import and replay give other times"
  expect 3 "no/timing.csv: error: cannot be written" import first.rec --out no/timing.csv
}
case_errors_that_no_other_case_has_name_their_remedy() {
  local live=$source_dir/scenarios/live/figure-1-spring.toml
  expect 2 "there is no such schema; there are: scenario, summary" schema frob
  expect 2 "is no folder; name one with run folders in it" index nowhere
  expect 2 "is the recording of one run, and these are 2 scenarios" run --clock wall "$spring" "$live" --record r.rec
  SOURCE_DATE_EPOCH=x expect 2 "'x' is no number of seconds since 1970" run "$spring"
  expect 2 "which it does not on the virtual clock; add --clock wall" run "$spring" --scope
  expect 2 "takes a scenario file, or --status and the folder of a sweep's parts" sweep
  expect 2 "--of belongs to --shard auto" sweep "$spring" --of 3
  expect 2 "the address of a service begins with ws://" devices --service nonsense
  expect 2 "needs all cells; leave it out" study "$source_dir/scenarios/stiff/study-block.toml" --advise "5 % force" \
    --shard 1/2
  expect 0 "nothing is measured: a [case] runs its solvers without a loop" \
    check "$source_dir/scenarios/stiff/s1-oscillator.toml" --cost
  no_run_folder
}
case_check_says_what_sweep_rings_and_an_adaptive_latency_will_be() {
  swept ''
  expect 0 "  sweep        6 points: 3 seeds x 2 of remap.latency" check s.toml
  expect 0 "               these are enough: this timing needs 14 and 8" check "$spring" --set 'remap.rings=[64, 32]'
  expect 0 "               too small: this timing needs 14 and 8" check "$spring" --set 'remap.rings=[64, 3]' \
    --set 'expect=[]'
  expect 0 "               adaptive: from 0.000000 ms, 0.000000 to 100.000000 ms, 1 ms above all needs of 10 s" \
    check "$spring" --set 'remap.latency="adaptive"' --set 'expect=[]'
  # The sweep's status says the same of its points as its end does.
  "$evenstep" sweep s.toml --out swept >out 2>err
  grep '^  fail ' out >failed
  [ "$(wc -l <failed)" -eq 3 ] || fail "not three failures"
  expect 0 "6 of 6 points, 1 of 1 shards have begun" sweep --status swept
  grep '^  fail ' out | cmp -s - failed || fail "the status tells other failures"
}
case_import_says_what_it_made_of_a_profile_and_what_it_left_out() {
  need_python
  python3 - <<'TRACE'
import json
spans = []
for picture in range(60):
    at = picture * 33333
    spans.append(("render", at, 11000))
    for step in range(5):
        spans += [("step", at + 11000 + step * 4000, 3000), ("solve", at + 14100 + step * 4000, 800)]
events = [{"ph": "X", "pid": 1, "tid": 1, "name": name, "ts": at, "dur": length} for name, at, length in spans]
json.dump({"traceEvents": events}, open("trace.json", "w"))
TRACE
  expect 0 "guessed: --visualization '^render\$' --step '^solve\$|^step\$'" import trace.json
  grep -qx 'trace.json: trace events (JSON), 660 intervals in 1.998 s' out || fail "no head"
  grep -q 'where several make up one, say which it begins with: --step-begin$' out || fail "no word of --step-begin"
  expect 0 "     300      800 us        4 ms  solve" import trace.json --list
  expect 0 "left out: 600 intervals of other names, the first: step" import trace.json --visualization render
  grep -qxF 'without steps there is nothing to run: say how many follow each visualization, --steps 8 --step-time "1.2 ms"' \
    out || fail "nothing of the steps that are missing"
  expect 0 "59 segments with 59 visualizations and 295 steps" import trace.json --visualization render --steps 5 \
    --step-time "3 ms" -o timing.csv
  expect 0 "295 steps" import timing.csv
  expect 0 "merged: 300 intervals into the step or visualization that they are a part of" import trace.json \
    --visualization render --step 'step|solve' --step-begin step
  expect 2 "--steps: error: and --step-time go together" import trace.json --visualization render --steps 5
  expect 2 "--step-time: error: must be above 0 s" import trace.json --visualization render --steps 5 --step-time "0 s"
  expect 2 "'apples' is not a unit of time" import trace.json --visualization render --steps 5 --step-time "3 apples"
  expect 2 "no name matches the visualization 'rendr'; there are 'solve' (300)" import trace.json --visualization rendr
  expect 3 "no/t.csv: error: cannot be written: there is no folder 'no'" import trace.json -o no/t.csv
}
case_every_verdict_about_a_damaged_recording_says_so() {
  local trace=long.json said="1 of 75 intervals (1.3 %) were merged, clipped or left out"
  python3 - <<'end'
import json
def interval(name, begin_us, length_us):
    return dict(ph="X", pid=1, tid=7, cat="kernel", name=name, ts=begin_us, dur=length_us)
events = [interval(*row) for segment in range(0, 400000, 16000)
          for row in (("draw", segment, 3000), ("step", segment + 3000, 900), ("step", segment + 4000, 900))]
events[1]["dur"] = 1600000  # the end of a later step: it runs over the next begin of its queue
json.dump({"traceEvents": events}, open("long.json", "w"))
end
  printf '%s\n' 'format = 1' '[run]' 'duration = "20 ms"' 'strategies = ["direct"]' '[timing]' "trace = \"$trace\"" \
    '[scene]' 'kind = "spring"' 'stiffness = "100 N/m"' '[[device]]' 'name = "d"' 'motion = { kind = "still" }' >damaged.toml
  for words in "size $trace" "advise $trace" "fit $trace" "size damaged.toml" "check damaged.toml" \
    "run damaged.toml --allow-no-expectations"; do
    "$evenstep" $words >out 2>err
    grep -qF "$said" err || fail "not said by $words: $(cat out err)"
  done
  "$evenstep" size "$source_dir/scenarios/recorded/h100-pause.csv" >out 2>err || fail "size"
  [ ! -s err ] || fail "a whole recording is warned of"
}
# The database of AMD's profiler, from its public schema: in one generation a dispatch has its times and agent, in the next
# one they are in tables of their own. Both give the same views.
case_import_reads_both_generations_of_rocpd() {
  python3 - <<'end'
import sqlite3

views = {  # of each generation: kernels, regions
    2: ("""SELECT K.id, K.pid, K.tid, A.absolute_index AS agent_abs_index, S.display_name AS name, K.queue_id,
             Q.name AS queue, K.start, K.end, E.extdata FROM rocpd_kernel_dispatch K
             JOIN rocpd_info_agent A ON A.id = K.agent_id
             JOIN rocpd_info_kernel_symbol S ON S.id = K.kernel_id JOIN rocpd_info_queue Q ON Q.id = K.queue_id
             JOIN rocpd_event E ON E.id = K.event_id""",
        """SELECT R.id, R.pid, R.tid, N.string AS name, R.start, R.end, E.extdata FROM rocpd_region R
             JOIN rocpd_string N ON N.id = R.name_id JOIN rocpd_event E ON E.id = R.event_id"""),
    3: ("""SELECT K.id, T.pid, T.tid, A.absolute_index AS agent_absolute_index, S.display_name AS name, T.queue_id,
             B.value AS start, D.value AS end, E.extdata FROM rocpd_kernel_dispatch K
             JOIN rocpd_track T ON T.id = K.track_id
             JOIN rocpd_info_agent A ON A.id = T.agent_id JOIN rocpd_info_kernel_symbol S ON S.id = K.kernel_id
             JOIN rocpd_timestamp B ON B.id = K.start_id JOIN rocpd_timestamp D ON D.id = K.end_id
             JOIN rocpd_event E ON E.id = K.event_id""",
        """SELECT R.id, T.pid, T.tid, N.string AS name, B.value AS start, D.value AS end, E.extdata FROM rocpd_region R
             JOIN rocpd_track T ON T.id = R.track_id JOIN rocpd_string N ON N.id = R.name_id
             JOIN rocpd_timestamp B ON B.id = R.start_id JOIN rocpd_timestamp D ON D.id = R.end_id
             JOIN rocpd_event E ON E.id = R.event_id"""),
}
rows = [("draw", 0, 11_100_000)] + [("step", 11_100_000 + i * 1_400_000, 1_390_000) for i in range(15)]
for generation, (kernels, regions) in views.items():
    database = sqlite3.connect(f"rocpd-{generation}.db")
    def table(name, columns):
        database.execute(f"CREATE TABLE {name}_00ab ({columns})")
        database.execute(f"CREATE VIEW {name} AS SELECT * FROM {name}_00ab")
    def put(name, *values):
        return database.execute(f"INSERT INTO {name}_00ab VALUES (NULL{', ?' * len(values)})", values).lastrowid
    table("rocpd_metadata", "id INTEGER PRIMARY KEY, tag, value")
    table("rocpd_string", "id INTEGER PRIMARY KEY, string")
    table("rocpd_event", "id INTEGER PRIMARY KEY, extdata")
    table("rocpd_timestamp", "id INTEGER PRIMARY KEY, value")
    table("rocpd_track", "id INTEGER PRIMARY KEY, pid, tid, agent_id, queue_id")
    table("rocpd_info_agent", "id INTEGER PRIMARY KEY, absolute_index")
    table("rocpd_info_queue", "id INTEGER PRIMARY KEY, name")
    table("rocpd_info_kernel_symbol", "id INTEGER PRIMARY KEY, display_name")
    own = "pid, tid, agent_id, queue_id, start, end" if generation == 2 else "track_id, start_id, end_id"
    table("rocpd_kernel_dispatch", f"id INTEGER PRIMARY KEY, kernel_id, event_id, {own}")
    table("rocpd_region", f"id INTEGER PRIMARY KEY, name_id, event_id, {own}")
    put("rocpd_metadata", "schema_version", str(generation))
    agent, queue = put("rocpd_info_agent", 4), put("rocpd_info_queue", "Queue 1")
    tracks = [put("rocpd_track", 70, 71, agent, queue), put("rocpd_track", 70, 71, None, None)]
    symbols = {name: put("rocpd_info_kernel_symbol", name) for name in ("draw", "step")}
    def interval(into, first, extra, track, begin, end):
        event = put("rocpd_event", extra)
        if generation == 2:
            put(into, first, event, 70, 71, agent if track == 0 else None, queue if track == 0 else None, begin, end)
        else:
            put(into, first, event, tracks[track], put("rocpd_timestamp", begin), put("rocpd_timestamp", end))
    for segment in range(0, 1_000_000_000, 33_000_000):
        for name, begin, length in rows:
            interval("rocpd_kernel_dispatch", symbols[name], "{}", 0, segment + begin, segment + begin + length)
    push = put("rocpd_string", "roctxRangePushA")
    interval("rocpd_region", push, '{"message": "warm-up"}', 1, 5, 500_000_000)
    database.execute(f"CREATE VIEW kernels AS {kernels}")
    database.execute(f"CREATE VIEW regions AS {regions}")
    database.commit()
end
  for generation in 2 3; do
    expect 0 "30 segments with 30 visualizations and 450 steps" import "rocpd-$generation.db" -o "$generation.csv" \
      --visualization draw --step step
    expect 0 "from process 70, agent 4: 496 intervals" import "rocpd-$generation.db" --list
    grep -q '^rocpd-.\.db: rocpd SQLite, 497 intervals in ' out || fail "head: $(head -2 out)"
    grep -q 'warm-up$' out || fail "the marker has no text: $(cat out)"
  done
  cmp 2.csv 3.csv || fail "the generations differ"
  python3 - <<'end'
import sqlite3
database = sqlite3.connect("empty.db")
database.execute("CREATE TABLE t(id, tag, value)")
database.execute("CREATE VIEW rocpd_metadata AS SELECT * FROM t")
database.commit()
end
  expect 2 "empty.db: error: is a rocpd database without kernels and regions" import empty.db
}
case_import_says_what_is_damaged_and_exits_with_1_under_strict() {
  local made=$source_dir/tests/recordings/made
  expect 0 "clipped: 1 intervals run over the next begin of their thread or queue, and end there now; the first: step" \
    import "$made/overflow.json"
  grep -q '^warning: 1 steps and visualizations had no end of their own' out || fail "no warning"
  tail -n 1 out | grep -q '^warning: 1 of 12 intervals (8.3 %) were merged, clipped or left out' || fail "the last line"
  expect 1 "wrote o.csv" import "$made/overflow.json" --strict -o o.csv
  expect 0 "2 segments" import o.csv
  expect 0 "clipped: 1" import "$made/overflow.json" --list
  expect 0 "5 segments with 5 visualizations and 25 steps" import "$made/mujoco.json" --preset mujoco --strict
  expect 0 "mj_step  <- step" import "$made/mujoco.json" --preset mujoco --list
  expect 0 "preset = \"mujoco\"" size "$made/mujoco.json" --preset mujoco
  expect 0 "from Agent 2" import "$made/rocprofv3.csv" --list
  expect 2 "line 2 was taken for the header" import "$made/excel-de.csv" --header 2
}
case_fit_says_when_to_replay() {
  local trace=$source_dir/scenarios/recorded/contended-free-basic.csv
  expect 0 "trace = \"$trace\"" fit "$trace"
}
case_fit_json() {
  "$evenstep" fit "$source_dir/scenarios/recorded/regime-free-basic.csv" --json >out 2>err || fail "exit"
  command -v python3 >/dev/null || { echo "skipped: no python3 to check the JSON"; exit 77; }
  python3 -c 'import json; d = json.load(open("out"))
assert d["replay_instead"] and 1.5 < d["regimes"]["factor"] < 1.9' || fail "JSON"
}
case_fit_refuses_bad_input() {
  expect 2 "nowhere.csv" fit nowhere.csv
  printf 'segment,kind,index,begin_ns,end_ns\n0,step,0,5,4\n' >bad.csv
  expect 2 "bad.csv:2" fit bad.csv
  head -20 "$source_dir/scenarios/recorded/small-paced30-basic.csv" >short.csv
  expect 2 "a fit needs at least 32" fit short.csv
  expect 2 "timing.csv is missing" fit
}
case_size_of_a_recording_and_of_a_scenario() {
  local trace=$source_dir/scenarios/recorded/small-paced30-basic.csv
  expect 0 "15 steps every 33.33" size "$trace"
  expect 0 "taut string" size "$source_dir/scenarios/paper/figure-1-spring-hold.toml"
  grep -q " 12.842223 " out || fail "not the latency of the reference case"
  expect 0 "device period 0.125 ms" size "$trace" --sampling "8 kHz"
  expect 0 "90 % sure" size "$trace" --rate "5 %" --confidence "90 %"
  expect 0 "times the pause bound" size "$trace" --figure curve.svg
  grep -q "any path" curve.svg || fail "no figure"
  command -v python3 >/dev/null || { echo "skipped: no python3 to check the JSON"; exit 77; }
  "$evenstep" size "$trace" --json --sampling "1 ms" >out 2>err || fail "exit"
  python3 -c 'import csv, json; d = json.load(open("out"))
r = [x for x in csv.DictReader(open("'"$trace"'")) if x["kind"] == "step"]
longest = max(int(x["end_ns"]) - int(x["begin_ns"]) for x in r)
assert d["taut_string_latency_ns"] == longest + 999999 <= d["best_line_latency_ns"]
assert d["window_latency_ns"]["p50"] <= d["window_latency_ns"]["p99"] <= d["window_latency_ns"]["max"]
for s in ("paper", "phase_locked"):
    s = d["strategies"][s]
    assert s["latency_this_phase_ns"] <= s["latency_any_phase_ns"] and 0 <= s["culprit_step"] < len(r)
    assert min(s["lead_ns"], s["interaction_capacity"], s["force_capacity"]) > 0' || fail "JSON"
}
case_a_file_in_the_wrong_place_is_named_and_what_takes_it() {
  scenario
  printf 'begin_ns,end_ns\n0,5\n' >steps.csv
  expect 2 "'x.toml' is no command; did you mean run x.toml" x.toml
  expect 2 "'steps.csv' is no command; did you mean size steps.csv" steps.csv
  expect 2 "steps.csv:1:9: error:" run steps.csv
  expect 2 "this is a recording, no scenario: \`size\`" check steps.csv
  expect 2 "a scenario's name is empty" run ""
  printf '[remap]\nlead = "1 ms"\n[remap]\n' >twice.toml
  expect 2 "put these keys where it is first" check twice.toml
  expect 2 "[remap] lead is \"minimal\"" run --clock wall "$spring" --set 'remap.latency="20 ms"'
  expect 3 "/dev/hidraw77: no such file" run --clock wall --device /dev/hidraw77 \
    "$source_dir/scenarios/live/figure-1-spring.toml"
}
case_size_judges_what_a_program_has() {
  local trace=$source_dir/scenarios/recorded/small-paced30-basic.csv
  expect 0 "FITS" size "$trace" --fits "latency 45 ms, rings 64 32, map phase_locked" --junit fits.xml
  grep -qF 'tests="1" failures="0" errors="0"' fits.xml || fail "not passed in JUnit"
  expect 1 "latency 20.000000 ms is 22.423522 ms too little: phase_locked needs 42.423522 ms" \
    size "$trace" --fits "latency 20 ms" --junit fits.xml
  expect 1 "DOES NOT FIT" size "$trace" --fits "latency 20 ms"
  expect 1 "All of that is the 36 visualizations of 13.18 to 18.66 ms" size "$trace" --fits "latency 20 ms"
  grep -qF 'tests="1" failures="1" errors="0"' fits.xml || fail "not failed in JUnit"
  grep -qF 'too little: phase_locked needs' fits.xml || fail "no reason in JUnit"
  GITHUB_ACTIONS=true GITHUB_STEP_SUMMARY=$PWD/summary.md expect 1 "::error file=" size "$trace" --fits "latency 20 ms"
  grep -qF "DOES NOT FIT" summary.md || fail "no row in the summary of the job"
  expect 2 "is the verdict of --fits" size "$trace" --junit fits.xml
  expect 2 "is none of" size "$trace" --fits "latenz 20 ms"
  expect 2 "was not sized" size "$trace" --fits "latency 20 ms, map clocked"
  expect 1 "needs for so long cannot be known" size "$trace" --fits "latency 20 ms, per 1 h"
  expect 2 "--per: error: is said by --fits, too" size "$trace" --fits "latency 20 ms, per 1 h" --per "2 h"
  expect 2 "--fits: error: " size "$trace" --fits "latency 20 ms, per 1 V"
  expect 2 "--fits: error: a confidence goes with" size "$trace" --fits "latency 20 ms, confidence 90 %"
  expect 3 "" size "$trace" --fits "latency 20 ms" --junit no-folder/fits.xml
}
case_a_sizing_is_compared_and_listed_like_a_run() {
  local trace=$source_dir/scenarios/recorded/small-paced30-basic.csv
  expect 0 "FITS" size "$trace" --fits "latency 45 ms, rings 64 32, map phase_locked" --out sizings/before
  expect 1 "DOES NOT FIT" size "$trace" --fits "latency 45 ms, rings 64 8, map phase_locked" --sampling "2 ms" \
    --out sizings/after
  expect 1 "needs for so long cannot be known" size "$trace" --fits "latency 45 ms, per 1 h" --out sizings/unknown
  grep -qF '"signal":"sizing.buffers.phase_locked"' <(tr -d ' \n' <sizings/before/summary.json) || fail "no expectation"
  expect 1 "sizing.buffers.phase_locked" compare sizings/before sizings/after
  expect 0 "3 runs: sizings/index.html" index sizings
  grep -q '5.73 %' sizings/index.html || fail "no margin in the index"
  grep -qF 'before/report.html' sizings/index.html || fail "no page of the sizing"
  mkdir mine && echo mine >mine/summary
  expect 3 "mine" size "$trace" --fits "latency 45 ms" --out mine
  expect 2 "--out is also the run folder of --fits" size "$trace" --out sizings/no
}
case_size_finds_a_worst_order_that_a_run_can_play() {
  local trace=$source_dir/scenarios/recorded/paced30-pthread.csv
  expect 0 "a worse one may exist" size "$trace" --worst-order "1 s, map phase_locked" --worst-timing worst.csv
  local recorded worst
  read -r recorded worst < <(awk '/worst order found/ { row = 1 } row && $1 == "phase_locked" { print $2, $4; exit }' out)
  [ "$recorded" = 42.985883 ] || fail "not the latency of the recording, but $recorded"
  # What was found is a timing like any other: its own size is what was said, and that of the recording does not fit it.
  expect 0 "FITS" size worst.csv --fits "latency $worst ms, map phase_locked"
  expect 1 "DOES NOT FIT" size worst.csv --fits "latency $recorded ms, map phase_locked"
  scenario '[run]' 'strategies = ["phase_locked"]' '[timing]' 'trace = "worst.csv"' \
    '[remap]' "latency = \"$recorded ms\""
  sed -i '/extends/d' x.toml
  printf '%s\n' '[scene]' 'kind = "spring"' 'stiffness = "200 N/m"' '[[device]]' 'name = "left"' \
    'render = { kind = "force", emission = "hold" }' \
    'motion = { kind = "constant-velocity", velocity = ["0.1 m/s", "0 m/s", "0 m/s"] }' '[[expect]]' \
    'signal = "left.force.phase_locked"' 'metric = "underruns"' 'equals = 0' >>x.toml
  expect 1 "FAIL" run x.toml
  expect 0 "PASS" run x.toml --set "remap.latency=$worst ms"
  expect 0 '"worst_order":' size "$trace" --worst-order "1 s" --json
  expect 2 "a span must stand there" size "$trace" --worst-order soon
  expect 2 "--worst-order: error: \"map clock\" is none of paper, phase_locked" size "$trace" --worst-order "1 s, map clock"
  expect 2 "a lane of their own" size "$source_dir/scenarios/recorded/concurrent-paced30-basic-sub9.csv" --worst-order "1 s"
  expect 2 "is the timing that --worst-order finds" size "$trace" --worst-timing worst.csv
  expect 3 "cannot be written" size "$trace" --worst-order "1 s, map paper" --worst-timing nowhere/worst.csv
}
case_size_of_every_schedule_within_bounds() {
  local bounds="visualization 9 ms .. 14 ms, step 1.2 ms .. 1.9 ms"
  # paper: 14 slots of 14/15 + 1.9 ms against 14 steps of 1.2 ms after 9 ms, and 14 + 1.9 ms + 14 times 1.9 - 1.8 ms.
  expect 0 "paper             32.166665     14.866665            33, 20   exact" size --within "$bounds, steps 15"
  grep -q "linear             2.899999      0.999999              3, 3   exact" out ||
    fail "not the longest step and the device's period"
  grep -q "phase_locked .* found, not proved" out || fail "no search"
  expect 0 "a bound: enough for all of them" size --within "$bounds" --step-size "11.1 ms"
  expect 0 '"how":"exact"' size --within "$bounds, steps 10 .. 20" --json --emission linear --sampling "2 kHz"
  expect 2 "the first must not be above the second" size --within "step 2 ms .. 1 ms, steps 3"
  expect 2 "it takes either" size --within "$bounds"
  expect 2 "does not keep real time" size --within "$bounds" --step-size "1.9 ms"
  expect 2 "so there is no file" size x.csv --within "$bounds, steps 15"
  expect 2 "so there is no file" size --within "$bounds, steps 15" --rate "1 %"
}
case_a_list_of_steps_is_taken_wherever_a_recording_is() {
  awk -F, 'NR == 1 { print "begin_ns,end_ns" } $2 == "step" { print $4 "," $5 }' \
    "$source_dir/scenarios/recorded/small-paced30-basic.csv" >steps.csv
  expect 0 "670 segments with 10050 steps" import steps.csv -o timing.csv
  "$evenstep" size steps.csv --json >of-steps 2>err || fail "size"
  "$evenstep" size timing.csv --json >of-timing 2>err || fail "size of what import wrote"
  local needed='"latency_any_phase_ns":'
  [ "$(grep -o "$needed[0-9]*" of-steps)" = "$(grep -o "$needed[0-9]*" of-timing)" ] || fail "import found other segments"
  scenario '[run]' 'duration = "2 s"' 'strategies = ["phase_locked"]' '[timing]' 'trace = "steps.csv"'
  sed -i '/extends/d' x.toml
  printf '%s\n' '[scene]' 'kind = "spring"' 'stiffness = "200 N/m"' '[[device]]' 'name = "left"' \
    'motion = { kind = "constant-velocity", velocity = ["0.1 m/s", "0 m/s", "0 m/s"] }' '[[expect]]' \
    'signal = "left.force.phase_locked"' 'metric = "underruns"' 'equals = 0' >>x.toml
  expect 0 "means of 670 recorded segments" check x.toml
  expect 0 "PASS" run x.toml
  expect 0 "[timing]" fit steps.csv
  expect 0 "phase_locked" advise steps.csv
  expect 2 "remove what says" import steps.csv --step x -o timing.csv
  printf 'begin_ns,end_ns\n0,5\n5,4\n' >steps.csv
  expect 2 "steps.csv:3:" import steps.csv
}
case_size_prints_tables_that_run_without_an_underrun() {
  # The input is a bare list of steps, in which `size` and the run find the same segments; or those that `size` wrote.
  awk -F, 'NR == 1 { print "begin_ns,end_ns" } $2 == "step" { print $4 "," $5 }' \
    "$source_dir/scenarios/recorded/small-paced30-basic.csv" >steps.csv
  expect 3 "cannot be written" size steps.csv --timing nowhere/timing.csv
  local timing
  for timing in steps timing; do
    expect 0 "trace = \"$timing.csv\"" size steps.csv $([ $timing = steps ] || echo --timing timing.csv)
    {
      printf '%s\n' 'format = 1' '[run]' 'strategies = ["phase_locked"]' '[scene]' 'kind = "spring"' '[[device]]' \
        'name = "left"' 'render = { kind = "force", emission = "hold" }' '[[expect]]' \
        'signal = "left.force.phase_locked"' 'metric = "underruns"' 'equals = 0'
      sed -n '/^\[remap\]/,$p' out
    } >pasted.toml
    expect 0 "0 samples missing, 0 forces late" check pasted.toml
    expect 0 "PASS" run pasted.toml
  done
  # A timing.csv of one segment is one to a scenario.
  awk -F, 'NR == 1 { print "segment,kind,index,begin_ns,end_ns" } NR > 1 { print "0,step," NR - 2 "," $0 }' \
    steps.csv >one.csv
  expect 0 "takes the one segment of this file" size one.csv
}
case_size_refuses_bad_input() {
  expect 2 "nowhere.csv" size nowhere.csv
  printf 'begin_ns,end_ns\n0,5\n4,9\n' >bad.csv
  expect 2 "bad.csv:3:1: error: begins at 4 ns, before the step before it ended at 5 ns" size bad.csv
  printf 'segment,kind,index,begin_ns,end_ns\n0,visualization,0,0,5\n' >drawn.csv
  expect 2 "there is no step in it" size drawn.csv
  expect 2 '"5" is no period' size drawn.csv --sampling 5
  expect 2 "must be above 0 % and below 100 %" size drawn.csv --rate "100 %"
  expect 3 "cannot be written" size "$source_dir/scenarios/recorded/small-paced30-basic.csv" --figure nowhere/curve.svg
  expect 2 "goes with a rate or a span" size drawn.csv --confidence "95 %"
  expect 2 '"drop" is none' size drawn.csv --what-if drop
  expect 2 'error: "budget 20": ' size drawn.csv --budget 20
  expect 2 "own-lane goes with none of the others but spread" size drawn.csv --what-if "own-lane 1.3, split 2"
  local trace=$source_dir/scenarios/recorded/small-paced30-basic.csv
  expect 0 "looking back" size "$trace" --budget "11 ms hold" --split 2 --split 5 --pace "90 %" \
    --own-lane 1.3 --adaptive --rate "1 %"
  expect 0 '"what_if":"spread, own-lane 1"' size "$trace" --spread --what-if "own-lane, spread" --json
  expect 0 '"what_if":"split 2"' size "$trace" --split 2 --json
  expect 2 "must be above 0 N s/m" size drawn.csv --damping "0 N s/m"
  expect 2 "belong to a recording" size "$spring" --sampling "1 ms"
  expect 2 "belongs to a scenario" size drawn.csv --set run.seed=2
  expect 2 "drives the solver without a loop" size "$source_dir/scenarios/stiff/s1-oscillator.toml"
}
case_advise_gives_scenarios_that_give_its_numbers() {
  command -v python3 >/dev/null || { echo "skipped: no python3 to compare the numbers"; exit 77; }
  head -3300 "$source_dir/scenarios/recorded/paced30-pthread.csv" >timing.csv
  expect 0 "Pareto-optimal" advise timing.csv --rate "5 %" --out choices
  grep -q "If the solver says how stiff the contact is" out || fail "no conclusion"
  grep -q "<svg" choices/advice.svg || fail "no figure"
  grep -q "What each choice costs" choices/report.html || fail "no page"
  for file in choices/choice-*.toml; do expect 0 "PASS" run "$file"; done
  "$evenstep" advise timing.csv --rate "5 %" --out again --json >out 2>err || fail "exit"
  cmp -s choices/advice.json out && cmp -s out again/advice.json || fail "not the same JSON"
  python3 -c 'import json
choices = json.load(open("out"))["choices"]
assert len(choices) >= 20 and any(c["pareto"] for c in choices) and not all(c["pareto"] for c in choices)
for c in choices:
    run = json.load(open("runs/choice-%d/summary.json" % c["number"]))["metrics"]
    of = lambda device, kind, metric: run["%s.%s.%s" % (device, kind, c["map"])][metric]
    # The row of an adaptive latency has its mean. What the loop must carry follows from the largest latency.
    delay_s, ns = of("closed_loop", "hand", "loop_delay"), lambda of_s: round(of_s * 1e9)
    assert delay_s > c["delay_s"] if c["adaptive"] else delay_s == c["delay_s"], c
    law = of("closed_loop", "hand", "predicted_stiffness_limit")
    assert c["stiffness_N_per_m"] <= law if c["stiffness_from"] == "search" else c["stiffness_N_per_m"] == law, c
    assert (c["stiffness_from"] == "search") is (c["map"] == "predict"), c
    assert (of("closed_loop", "hand", "stable") == 1) is c["comes_to_rest"], c
    assert of("line", "buffers", "underrun_rate") == c["underrun_rate"], c
    latency = "latency_most_ns" if c["adaptive"] else "latency_ns"
    assert ns(of("line", "buffers", "latency")) == (c[latency] or 0), c
    if c["adaptive"]: assert ns(of("line", "force", "schedule_latency_mean")) == c["latency_ns"], c
    assert c["bound_ns"] is None or c["bound_ns"] <= c["latency_ns"], c' 2>err || fail "the runs give other numbers"
}
case_advise_of_a_scenario_and_of_steps_alone() {
  expect 0 "449 steps in 30 segments" advise "$source_dir/scenarios/paper/figure-1-spring-hold.toml" \
    --set 'run.duration=1 s' --out paper
  grep -q "12.842    12.842" out || fail "not the latency of the reference case, which is its bound"
  grep -q "nobody can tell whether the hand comes to rest" out || fail "no word that a second is too short"
  awk -F, 'NR == 1 { print "begin_ns,end_ns" } $2 == "step" && NR < 1500 { print $4 "," $5 }' \
    "$source_dir/scenarios/recorded/small-paced30-basic.csv" >steps.csv
  expect 0 "nobody knows which pauses are drawings" advise steps.csv --renderer hold
  [ -f runs/steps-advise/choice-1.toml ] || fail "no folder in runs"
  grep -q "local" runs/steps-advise/advice.json && fail "a renderer that was not asked for"
  expect 0 "phase_locked 4 Hz" advise steps.csv --renderer hold --bandwidth "4 Hz" --what-if none --threads 1
}
case_advise_refuses_bad_input() {
  local trace=$source_dir/scenarios/recorded/small-paced30-basic.csv
  expect 2 "nowhere.csv" advise nowhere.csv
  printf 'begin_ns,end_ns\n0,5\n4,9\n' >bad.csv
  expect 2 "bad.csv:3:1: error: begins at 4 ns, before the step before it ended at 5 ns" advise bad.csv
  head -20 "$trace" >short.csv
  expect 2 "too short to advise" advise short.csv
  expect 2 '"soft" is none of hold, linear, local, device_spring' advise "$trace" --renderer soft
  expect 2 "'0 Hz' is not above 0 Hz" advise "$trace" --bandwidth "0 Hz"
  expect 2 "must be above 0 kg" advise "$trace" --mass "0 kg"
  expect 2 "must be above 0 N s/m" advise "$trace" --damping "0 N s/m"
  expect 2 "must be above 0 % and below 100 %" advise "$trace" --rate "0 %"
  expect 2 '"10 Hz" is not between 100 and 100000 Hz' advise "$trace" --firmware-rate "10 Hz"
  expect 2 '"1 V" is no period of at most 1 s, such as "1 ms", and no rate' advise "$trace" --step-size "1 V"
  expect 2 "--step-size belongs to a recording" advise "$spring" --step-size "1 ms"
  expect 2 "compares no change of the simulator" advise "$trace" --what-if "split"
  expect 2 "belongs to a scenario" advise "$trace" --set run.seed=2
  expect 2 "belongs to a recording" advise "$spring" --sampling "1 ms"
  expect 2 "drives the solver without a loop" advise "$source_dir/scenarios/stiff/s1-oscillator.toml"
  mkdir full && touch full/mine
  expect 3 "full" advise "$trace" --out full
  no_run_folder
}
case_a_rate_with_confidence() {
  expect 0 "49 clean seeds" check "$source_dir/scenarios/sizing/underrun-rate.toml"
  expect 0 "fails as expected" run --verbose "$source_dir/scenarios/sizing/underrun-rate.toml"
  local rate='signal = "left.buffers.phase_locked"'
  scenario '[[expect]]' "$rate" 'metric = "underruns"' 'max = 0' 'confidence = "95 %"'
  expect 2 "x.toml:8:14: error: 'confidence' is that of an underrun_rate" check x.toml
  scenario '[[expect]]' "$rate" 'metric = "underrun_rate"' 'equals = 0' 'confidence = "95 %"'
  expect 2 "needs a max, and no min or equals" check x.toml
  scenario '[[expect]]' "$rate" 'metric = "underrun_rate"' 'max = 0' 'confidence = "95 %"'
  expect 2 "no number of seeds shows a rate of 0" check x.toml
  scenario '[[expect]]' "$rate" 'metric = "underrun_rate"' 'max = 0.1' 'seeds = 5'
  expect 2 "'seeds' goes with 'confidence'" check x.toml
  scenario '[[expect]]' "$rate" 'metric = "underrun_rate"' 'max = "1 %"' 'confidence = "95 %"'
  expect 0 "every seed of this timing is the same" check x.toml
  local changing=(--set "timing={ trace = \"$source_dir/scenarios/recorded/h100-render.csv\" }" --set 'run.duration="9.9 s"'
    --set 'scene.step_size="450 Hz"')
  for command in check run; do
    expect 2 "x.toml:6:10: error: nobody can be sure of a rate: from " "$command" x.toml "${changing[@]}"
  done
}
case_concurrent_timing_runs_and_is_refused_on_a_wall_clock() {
  local lane=(--set timing.order=concurrent --set timing.paced=true --set timing.slowdown=1.5
    --set 'timing.jitter={ step = "lognormal 5 %" }')
  local short=(--set 'run.duration="1 s"' --set 'expect=[]')
  expect 0 "NO VERDICT" run "$spring" "${lane[@]}" "${short[@]}" --repeat --allow-no-expectations
  expect 2 "virtual clock only" run --clock wall "$spring" "${lane[@]}" "${short[@]}" \
    --set 'remap.latency="30 ms"' --set 'remap.lead="5 ms"'
}
case_interrupt_keeps_what_is_finished() {
  scenario 'expect = []' '[run]' 'duration = "600 s"'
  "$evenstep" run "$spring" x.toml --out kept >out 2>err &
  local pid=$!
  for _ in $(seq 300); do [ -s kept/figure-1-spring/summary.json ] && break; sleep 0.1; done
  sleep 0.3
  kill -INT $pid
  wait $pid
  local got=$?
  [ "$got" -eq 130 ] || fail "exit $got instead of 130"
  grep -q '"verdict":"pass"' kept/figure-1-spring/summary.json || fail "the finished run is not kept"
  [ -z "$(find kept -name '.*.writing-*')" ] || fail "a half-written folder is left"
}
small_block() {  # a tissue of 490 particles on this machine's OpenCL, 50 segments of 3 steps a second, in block.toml
  { printf 'format = 1\nextends = ["%s"]\nname = "block"\nexpect = []\n' "$source_dir/scenarios/paper/figure-1.toml"
    printf '%s\n' '[timing]' 'segment = "50 Hz"' 'visualization = "2 ms"' 'steps = 3' \
      '[scene]' 'lattice = [8, 7, 9]' 'particles = 490' \
      '[[device]]' 'name = "left"' 'grab = { center = ["10 mm", "15 mm", "40 mm"], radius = "6 mm" }' \
      '[[device]]' 'name = "right"' 'grab = { center = ["25 mm", "15 mm", "40 mm"], radius = "6 mm" }'
  } >block.toml
}
case_record_gives_a_recording_that_other_commands_take() {
  small_block
  expect 0 "next: $evenstep size timing.csv" record block.toml -o timing.csv --seconds 1
  grep -q 'host - device' out || fail "no device times"
  grep -q '^advance ' out || fail "no kernel by name"
  grep -q '^OpenCL: ' out || fail "not which device"
  for word in '^# evenstep record block.toml --seconds 1 (evenstep' '^# device: ' '^# driver: ' '^# host: ' '^# load: ' \
    '^# clock: CLOCK_MONOTONIC' '^# rights: ' '^# before it, not in it: '; do
    grep -q "$word" timing.csv || fail "no '$word' in the head"
    grep -q "$word" timing.profile.csv || fail "no '$word' in the head of the profile"
  done
  python3 - <<'CHECK' || fail "the files do not fit each other"
import csv
rows = {name: list(csv.DictReader(l for l in open(name) if l[0] != "#")) for name in ("timing.csv", "timing.profile.csv")}
steps = [(r["segment"], r["index"]) for r in rows["timing.csv"] if r["kind"] == "step"]
times = [[int(r[k]) for k in ("queued_ns", "submitted_ns", "started_ns", "ended_ns")] for r in rows["timing.profile.csv"]]
assert steps and len(steps) % 3 == 0
assert list(dict.fromkeys((r["segment"], r["index"]) for r in rows["timing.profile.csv"])) == steps
assert all(t == sorted(t) for t in times) and times[0][0] == 0
CHECK
  expect 0 "phase_locked" size timing.csv
  expect 0 "advance" import timing.profile.csv --list --begin started_ns --end ended_ns --name name --unit ns
  traced timing.csv
  expect 0 "NO VERDICT" run t.toml --allow-no-expectations
  [ -z "$(find . -name '*.writing-*')" ] || fail "a half-written file is left"
}
case_record_and_live_runs_say_in_the_same_words_how_far_they_were_from_real_time() {
  small_block
  expect 0 "went wrong   simulated time passes 5" \
    record block.toml -o timing.csv --seconds 1 --host-only --set 'scene.step_size="33.3 ms"' --set scene.allow_unstable=true
  "$evenstep" run --clock wall block.toml --allow-no-expectations --set 'scene.step_size="33.3 ms"' \
    --set scene.allow_unstable=true --set 'run.duration="1 s"' --set 'run.warmup="0.2 s"' --set 'timing.step="real"' \
    --set 'remap.latency="50 ms"' --set 'remap.lead="20 ms"' --out live >out 2>err
  grep -q '^went wrong   .*simulated time passes 5' out || fail "a live run does not say so: $(cat out)"
  scenario
  expect 0 "next: " record x.toml -o spring.csv --seconds 1 --set 'scene.step_size="33.3 ms"'
  ! grep -q 'simulated time' out || fail "a spring knows no time"
}
case_it_is_said_which_opencl_device_computes_and_which_key_chooses() {
  small_block
  expect 0 "runs use it" devices --opencl
  grep -q '`record` uses it' out || fail "not what record uses"
  expect 0 "OpenCL: " devices
  "$evenstep" devices --opencl --json >out 2>err || fail "devices --opencl --json"
  python3 - <<'CHECK' || fail "the list: $(cat out)"
import json
devices = json.load(open("out"))
assert sum(one["used_by_run"] for one in devices) == 1 and sum(one["used_by_record"] for one in devices) == 1
gpus = [one["gpu"] for one in devices]
assert not any(gpus) or next(one for one in devices if one["gpu"])["used_by_record"]
open("name", "w").write(next(one for one in devices if one["used_by_run"])["device"])
CHECK
  expect 0 "  OpenCL       $(cat name)" check block.toml
  "$evenstep" check block.toml --json >out 2>err || fail "check --json"
  python3 -c 'import json; assert json.load(open("out"))["opencl_device"].startswith(open("name").read())' ||
    fail "no device"
  expect 0 "  OpenCL       $(cat name)" run block.toml --set "scene.opencl_device=\"$(cat name)\"" --allow-no-expectations
  expect 3 "no OpenCL device or platform is called 'Nonesuch'" run block.toml --set 'scene.opencl_device="Nonesuch"'
  grep -q "a part of one of the names '" err || grep -q "a part of one of the names '" out || fail "not which there are"
  ! "$evenstep" check "$spring" | grep -q OpenCL || fail "a spring needs no device"
  expect 2 "--check is for --opencl" devices --check
  OCL_ICD_VENDORS=$work/none expect 3 "pocl-opencl-icd" devices --opencl
  OCL_ICD_VENDORS=$work/none expect 0 "  OpenCL       none: no OpenCL platform is installed" check block.toml
}
case_record_of_a_solver_without_a_device_has_host_times_only() {
  scenario
  expect 0 "gives no commands to an OpenCL device" record x.toml --out timing.csv --seconds 1
  [ ! -e timing.profile.csv ] || fail "a profile of no device"
  small_block
  expect 0 "host times only: --host-only" record "$PWD/block.toml" --out timing.csv --seconds 1 --host-only \
    --ordinary
  grep -q '^# rights: those of an ordinary program$' timing.csv || fail "its rights"
  head -n 1 timing.csv | grep -q '^# evenstep record block.toml --seconds 1 --ordinary --host-only' ||
    fail "$(head -n 1 timing.csv)"
  [ ! -e timing.profile.csv ] || fail "a profile that was not asked for"
}
case_record_draws_or_burns_where_it_is_told_to() {
  small_block
  expect 0 "per visualization, ms" record block.toml -o burnt.csv --seconds 1 --visualization "burn 2 ms"
  grep -q '^# in a visualization a kernel kept the compute device busy' burnt.csv || fail "not what was done"
  __EGL_VENDOR_LIBRARY_DIRS=$work expect 3 "remedy: install a driver of OpenGL" \
    record block.toml -o none.csv --seconds 1 --visualization render
  [ ! -e none.csv ] || fail "a file of a recording that failed"
  expect 2 "'visualization': \"rendr\" must be" record block.toml -o none.csv --visualization rendr
  if ! "$evenstep" record block.toml -o drawn.csv --seconds 1 --visualization render >out 2>err; then
    grep -q "nothing to draw on\|OpenGL cannot be loaded\|built without OpenGL" err || fail "another error"
    echo "skipped: this machine cannot draw: $(cat err)"
    return
  fi
  grep -q '^# evenstep record block.toml --seconds 1 --visualization render (evenstep' drawn.csv || fail "no command"
  grep -q '^# in a visualization the tissue is drawn, 800 x 600 pixels, by ' drawn.csv || fail "not by what"
  [ "$(head -c 4 drawn.drawing.png | tail -c 3)" = PNG ] || fail "no drawing"
  grep -q '^visualization: read ' out || fail "what a drawing reads is not said"
  grep -q '^0,visualization,0,read,' drawn.profile.csv || fail "what a drawing reads belongs to nobody"
  ! grep -q 'not to be trusted' out || fail "commands were counted into the wrong step"
  traced drawn.csv
  expect 0 "NO VERDICT" run t.toml --allow-no-expectations
}
case_record_refuses_what_it_cannot_do_before_it_starts() {
  scenario
  expect 2 "--out is missing" record x.toml
  expect 3 "there is no folder 'none'; make it, or name another one" record x.toml -o none/timing.csv
  expect 3 ".: error: is a directory, not a file; name a file in it" record x.toml -o .
  expect 2 "--seconds" record x.toml -o t.csv --seconds 0
  expect 2 "nowhere.toml" record nowhere.toml -o t.csv
  expect 2 "[case]" record "$source_dir/scenarios/stiff/s1-oscillator.toml" -o t.csv
  scenario '[timing]' 'order = "concurrent"' 'paced = true'
  expect 2 "run beside the steps" record x.toml -o t.csv
  [ ! -e t.csv ] || fail "a file was written"
}
case_record_onto_a_full_disk_leaves_what_was_there() {
  scenario
  echo before >timing.csv
  trap '' XFSZ
  ulimit -S -f 4
  expect 3 "File too large" record x.toml -o timing.csv --seconds 1
  ulimit -S -f unlimited
  [ "$(cat timing.csv)" = before ] || fail "the file that was there is gone"
  [ -z "$(find . -name '*.writing-*')" ] || fail "a half-written file is left"
}
case_record_ends_with_a_signal_and_keeps_what_it_has() {
  small_block
  local signal got
  for signal in INT TERM; do
    "$evenstep" record block.toml -o $signal.csv --seconds 600 >out 2>err &
    local pid=$!
    for _ in $(seq 300); do grep -q recording out && break; sleep 0.1; done
    sleep 1.5
    kill -$signal $pid
    wait $pid
    got=$?
    [ "$got" -eq 130 ] || fail "SIG$signal: exit $got instead of 130"
    grep -q '^# interrupted' $signal.csv || fail "the file does not say that it was interrupted"
    expect 0 "phase_locked" size $signal.csv
  done
}
case_every_signal_ends_a_run_without_a_force() {
  local signal got
  for signal in INT TERM HUP; do
    "$evenstep" run "$source_dir/scenarios/safety/exit-pid.toml" --set 'run.duration="600 s"' --out "$signal" >out 2>err &
    local pid=$!
    for _ in $(seq 300); do [ -s out ] && break; sleep 0.1; done
    sleep 0.5
    kill -$signal $pid
    wait $pid
    got=$?
    [ "$got" -eq 130 ] || fail "SIG$signal: exit $got instead of 130"
    [ "$(grep -o '"motors_left":0[,}]' "$signal/summary.json" | wc -l)" -eq 2 ] ||
      fail "SIG$signal: a motor is left on, or nobody says"
  done
}
case_closed_stdout_is_not_a_crash() {
  "$evenstep" run "$spring" 2>err | head -c 10 >/dev/null
  [ "${PIPESTATUS[0]}" -lt 128 ] || fail "died of a signal"
}
case_pocl_drivers_agree() {
  # The hash is the same with PoCL's basic and pthread drivers, with one and two threads, and on the CPU solver.
  local small=(--set 'scene.lattice=[8, 7, 9]' --set scene.particles=490 --set 'run.duration="0.5 s"' --set 'expect=[]'
    --set 'device.left.grab={ center = ["10 mm", "15 mm", "40 mm"], radius = "6 mm" }'
    --set 'device.right.grab={ center = ["25 mm", "15 mm", "40 mm"], radius = "6 mm" }')
  local hashes tissue=$source_dir/scenarios/paper/figure-1.toml
  hashes=$(
    for environment in POCL_DEVICES=basic "POCL_DEVICES=pthread POCL_MAX_PTHREAD_COUNT=1" \
      "POCL_DEVICES=pthread POCL_MAX_PTHREAD_COUNT=2"; do
      env $environment "$evenstep" run "$tissue" "${small[@]}" --json 2>>err | grep -o '"trace_hash":"[0-9a-f]*"' | head -1
    done
    "$evenstep" run "$tissue" "${small[@]}" --set 'scene.solver="cpu"' --json 2>>err |
      grep -o '"trace_hash":"[0-9a-f]*"' | head -1
  )
  printf '%s\n' "$hashes" >out
  [ "$(wc -l <out)" -eq 4 ] || fail "a run gave no hash"
  [ "$(sort -u out | wc -l)" -eq 1 ] || fail "the hashes differ"
}

: >out; : >err
"case_$3"
