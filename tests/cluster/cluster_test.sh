#!/usr/bin/env bash
# Sweeps on other people's engines (examples/sweep), while processes are killed. The merged bytes must be those of one
# process every time, and no finished line may be lost.
#   cluster_test.sh EVENSTEP SOURCE_DIR ENGINE [KILLS [SEED]]
# ENGINE: slurm (kills a worker ten times in twelve, slurmd once and slurmctld once), slurm_both (kills slurmd and slurmctld
# within a second), openmpi, parallel, workqueue, full_disk, builds (no kills: what is refused). KILLS is how many kills must
# hit a process. The last line says what was measured. WORK in the environment says what is divided: "sweep" (default),
# "study", "catalogue", or "size --rate 2% --seeds 0..40".
# Exit status 77: skipped, and why.
# Everything happens in one folder, daemons included, and nothing is left running.
set -uo pipefail
evenstep=$(readlink -f -- "$1") source_dir=$(readlink -f -- "$2") engine=$3 kills=${4:-3}
RANDOM=${5:-1}
readonly SHARDS=4
export SHARDS
examples=$source_dir/examples/sweep
export WORK=${WORK:-sweep}
kind=${WORK%% *}

skip() { echo "skipped: $*"; exit 77; }
fail() {
  echo "FAIL: $*"
  for log in "$work"/*.log "$work"/run/*.log; do [[ -s $log ]] && tail -n 5 "$log"; done
  exit 1
}
need() {
  for tool in "$@"; do
    command -v "$tool" >/dev/null || skip "$tool is not installed (.ci/cluster-packages.txt)"
  done
}

work=$(mktemp -d "${TMPDIR:-/tmp}/evenstep-cluster.XXXXXX")
# ours PATTERN : processes with such a name that run in the folder or run a program in it. This script started all of them.
ours() {
  local process name
  for process in $(find /proc -maxdepth 2 \( -name exe -o -name cwd \) -lname "$work*" -printf '%h\n' 2>/dev/null |
    sort -u); do
    # shellcheck disable=SC2053
    { read -r name <"$process/comm"; } 2>/dev/null && [[ $name == $1 ]] && echo "${process#/proc/}"
  done
}
clean_up() {
  trap - EXIT
  cd /
  for _ in 1 2 3; do
    for process in $(ours '*'); do kill -KILL "$process"; done
    sleep 0.1
  done 2>/dev/null
  rm -rf -- "$work"
}
trap clean_up EXIT
trap 'exit 130' INT TERM

# A copy of the program that belongs to this test alone, so that `ours` finds it. It is the same build.
mkdir "$work/bin" "$work/run"
cp -- "$evenstep" "$work/bin/evenstep"
export PATH="$work/bin:$PATH" POCL_CACHE_DIR=$work/pocl
scenario=$work/s.toml
cat >"$scenario" <<TOML
format = 1
extends = ["$source_dir/scenarios/paper/figure-1-spring.toml"]
name = "cluster"
expect = [{ signal = "left.force.phase_locked", metric = "underruns", equals = 0 }]
[run]
duration = "20 s"
strategies = ["phase_locked"]
[timing]
jitter = { step = "lognormal 10 %" }
[remap]
lead = "1 ms"
[sweep]
seeds = "0..20"
grid = { "remap.latency" = ["9 ms", "40 ms"] }
TOML
case $kind in
study)
  sed -e 's/^name .*/name = "cluster"/' -e 's/^duration   = "64 ms"/duration = "48 ms"\nrepeats = 1/' -e '/^iterations/d' \
    -e 's/^solvers .*/solvers = ["cpu-double"]\nmethods = ["symplectic-euler", "velocity-verlet", "rk4"]/' \
    -e 's/^error .*/error = "state"\nstep_sizes = ["1 ms", "0.5 ms", "0.25 ms", "0.125 ms"]/' \
    "$source_dir/scenarios/stiff/study-block.toml" >"$scenario"
  ;;
catalogue)   # a folder with a case and with a run that fails, which is a result, too
  scenario=$work/cases
  mkdir "$scenario"
  sed 's/^duration = .*/&\nsolvers = ["cpu-double"]/' "$source_dir/scenarios/stiff/s5-stiffness-decades.toml" \
    >"$scenario/s5-stiffness-decades.toml"   # OpenCL programs are built elsewhere
  sed 's/^grid .*//; s/^seeds .*//; s/^\[sweep\]//; s/equals = 0/min = 1/; s/"20 s"/"1 s"/' \
    "$work/s.toml" >"$scenario/run.toml"
  ;;
esac
# The part of a result that does not depend on where it is computed. Costs do: every shard measures its own.
certain() { sed 's/,"measured":{.*/}/' "$1"; }
unset "${!SLURM_@}" "${!OMPI_@}" "${!PMI@}" "${!PARALLEL@}" "${!CI_NODE_@}" "${!GTEST_@}" JOB_COMPLETION_INDEX
begin=$(date +%s%N)
# shellcheck disable=SC2086   # its words are options
evenstep $WORK "$scenario" --threads 2 --shard 1/1 --out "$work/one" >"$work/one.log" 2>&1
reference=$?
((reference <= 1)) || fail "the reference does not end"
[[ $kind != catalogue || $reference == 1 ]] || fail "the run that fails has passed"
span_ms=$((($(date +%s%N) - begin) / 1600000 + 1))   # an engine takes a little longer
cd "$work/run" || exit 1

finished_lines() { cat parts/*.jsonl parts/*.partial 2>/dev/null | wc -l; }

# strike PATTERN : waits for a process with such a name, and after a random time kills one of those that are there then, or
# the next one that comes; false if the run ends before. Without the first wait nearly every try came before a shard had
# begun, because an engine needs longer to begin than a short shard needs altogether.
strike() {
  local pattern=$1 victims before
  find_victims || return 1
  sleep "$((RANDOM * span_ms / 32768))e-3"
  find_victims || return 1
  before=$(finished_lines)
  kill -KILL "${victims[RANDOM % ${#victims[@]}]}" 2>/dev/null || return 1
  ((before >= lines_before)) || fail "$lines_before lines were finished, now $before are"
  lines_before=$before
  hits=$((hits + 1)) by[$pattern]=$((${by[$pattern]:-0} + 1))
}
# find_victims : sets `victims` to the processes named `pattern`; false if the run, its `shell` or ten seconds end before
find_victims() {
  local end=$((SECONDS + 10))
  until mapfile -t victims < <(ours "$pattern"); ((${#victims[@]})); do
    [[ ! -e $kind.jsonl ]] && kill -0 "${shell:-$$}" 2>/dev/null && ((SECONDS < end)) || return 1
    sleep 0.02
  done
}

# judge : the run is complete
judge() {
  cmp -s <(certain "$kind.jsonl") <(certain "$work/one/$kind.jsonl") || fail "run $runs: the merged bytes are others"
  if [[ $engine != full_disk ]]; then   # its parts are gone with the disk
    evenstep merge parts/*.jsonl --out again.jsonl >again.log 2>&1
    (($? == reference)) || fail "run $runs: the merge exits with another status than one process"
    cmp -s "$kind.jsonl" again.jsonl || fail "run $runs: another merge of the same parts has other bytes"
    [[ $kind != catalogue ]] || grep -qF '2 scenarios: 1 passed, 1 failed' again.log || fail "the merge does not judge"
    [[ $kind != study ]] || [[ -s again/study.json && -s $kind/study.json ]] || fail "the merge has no results"
  fi
  runs=$((runs + 1))
  ((runs < 20 * (kills + 1))) || fail "only $hits of $kills kills have hit a process in $runs runs"
}
declare -A by=()
hits=0 runs=0 again=0 lost=0 lines_before=0

fresh() {
  cd "$work" && rm -rf run && mkdir run && cd run || exit 1
  lines_before=0
}

# struck NAME... -- COMMAND... : runs the command, which is run.sh of an example, and meanwhile kills a process of one of
# these names, twice. If the command itself does not survive that, it is run again, as its user would do.
struck() {
  local names=() tries=0 shell
  while [[ $1 != -- ]]; do names+=("$1"); shift; done
  shift
  fresh
  "$@" >run.log 2>&1 &
  shell=$!
  for _ in 1 2; do
    ((hits < kills)) && kill -0 "$shell" 2>/dev/null && strike "${names[hits % ${#names[@]}]}"
  done
  until wait "$shell"; (($? <= 1)); do
    ((++tries < 20)) || fail "run $runs does not end"
    again=$((again + 1))
    sleep 0.2
    "$@" >>run.log 2>&1 &
    shell=$!
  done
  judge
}

engine_parallel() {
  need parallel
  while ((hits < kills)); do
    struck evenstep evenstep evenstep parallel -- "$examples/parallel/run.sh" "$scenario" -j2
  done
  [[ $kind != sweep ]] || refuses_old_parts "$examples/parallel/run.sh" "$scenario" -j2
}

engine_openmpi() {
  need mpirun
  local options=(--oversubscribe)
  (($(id -u) == 0)) && options+=(--allow-run-as-root)
  export TMPDIR=$work
  while ((hits < kills)); do
    struck evenstep evenstep evenstep mpirun -- "$examples/openmpi/run.sh" "$scenario" "${options[@]}"
  done
  [[ $kind != sweep ]] || refuses_old_parts "$examples/openmpi/run.sh" "$scenario" "${options[@]}"
}

# Workers come and go: as soon as one is gone, there is another one.
workers() {
  cd "$work" || exit 1
  while sleep 0.1; do
    [[ -s run/port ]] && work_queue_worker -t 5 --cores 2 -s "$work" 127.0.0.1 "$(cat run/port)" >/dev/null 2>&1
  done
}
engine_workqueue() {
  need makeflow work_queue_worker
  local workers
  while ((hits < kills)); do
    workers & workers=$!
    struck evenstep work_queue_work evenstep makeflow -- "$examples/workqueue/run.sh" "$scenario" -Z port -p 0
    kill "$workers" 2>/dev/null
    wait "$workers" 2>/dev/null
  done
  [[ $kind != sweep ]] || refuses_old_parts "$examples/workqueue/run.sh" "$scenario" -Z port -p 0
}

# A disk of random size that fills up while four shards write, and then has room again.
engine_full_disk() {
  local shard size status bytes
  bytes=$(stat -c %s "$work/one/$kind.jsonl")
  while ((hits < kills)); do
    fresh
    mkdir parts
    size=$((bytes * (RANDOM % 100) / 100 + 4096))
    mount -t tmpfs -o size="$size" none parts 2>/dev/null || skip "tmpfs cannot be mounted here, which a full disk needs"
    for shard in 1 2 3 4; do evenstep $WORK "$scenario" --shard $shard/4 --out parts; done >run.log 2>&1
    grep -q 'No space left on device' run.log && hits=$((hits + 1))
    mount -o remount,size=10m parts
    for shard in 1 2 3 4; do
      evenstep $WORK "$scenario" --shard $shard/4 --resume --out parts >>run.log 2>&1
      status=$?
      ((status <= 1)) || fail "shard $shard exits with $status where there is room again"
    done
    evenstep merge parts/*.jsonl --out "$kind.jsonl" >>run.log 2>&1
    umount parts
    judge
  done
  by[disk]=$hits
}

# refused STATUS TEXT COMMAND... : ends with this status and says this
refused() {
  local wanted=$1 text=$2 status
  shift 2
  "$@" >refused.log 2>&1
  status=$?
  ((status == wanted)) || fail "exit status $status instead of $wanted: $*"
  grep -qF -- "$text" refused.log || fail "\"$text\" is not said by: $*"
}

# What must never become a result: shards of two builds, a missing shard, a shard that is there twice, one that is cut short.
engine_builds() {
  local engine
  for engine in parallel/run.sh openmpi/run.sh workqueue/run.sh slurm/submit.sh; do
    refused 2 'usage: ' "$examples/$engine"
    PATH=/usr/bin:/bin refused 2 'with evenstep in the PATH' "$examples/$engine" "$scenario"
  done
  local shard part=parts/$kind-2-of-4.jsonl
  for shard in 1 2 3 4; do evenstep $WORK "$scenario" --shard $shard/4 --out parts; done >run.log 2>&1
  cp "$work/bin/evenstep" "$work/bin/evenstep-of-another-machine"
  echo >>"$work/bin/evenstep-of-another-machine"
  refused 3 "is of another $kind" evenstep-of-another-machine $WORK "$scenario" --shard 2/4 --resume --out parts
  evenstep-of-another-machine $WORK "$scenario" --shard 2/4 --out other >run.log 2>&1
  refused 2 'is of another build' evenstep merge parts/"$kind"-[134]*.jsonl other/*.jsonl --out "$kind.jsonl"
  refused 2 'is of another build' evenstep merge parts/*.jsonl other/*.jsonl --out "$kind.jsonl"
  refused 2 'shard 2 of 4 is missing' evenstep merge parts/"$kind"-[134]*.jsonl --out "$kind.jsonl"
  refused 2 'merge each part once' evenstep merge parts/*.jsonl $part --out "$kind.jsonl"
  sed -i 4d $part
  refused 2 "point 9 belongs into $part" evenstep merge parts/*.jsonl --out "$kind.jsonl"
  [[ ! -e $kind.jsonl ]] || fail "a refused merge was written"
}

free_port() {
  local port
  while :; do
    port=$((20000 + RANDOM % 20000))
    (: <>"/dev/tcp/127.0.0.1/$port") 2>/dev/null || { echo "$port"; return; }
  done
}

start_slurm() {
  local host
  host=$(hostname -s)
  cd "$work" || exit 1
  mkdir munge state spool
  (umask 077 && head -c 1024 /dev/urandom >munge.key)
  cat >slurm.conf <<CONF
ClusterName=evenstep
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$(free_port)
SlurmdPort=$(free_port)
SlurmUser=root
AuthInfo=socket=$work/munge/socket,cred_expire=5
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=batch_sched_delay=0,sched_min_interval=0
ReturnToService=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES State=UP
CONF
  echo CgroupAutomount=no >cgroup.conf
  export SLURM_CONF=$work/slurm.conf
  chmod 755 . munge   # munged refuses a socket that not everybody can reach
  munged -F --key-file="$work/munge.key" --socket="$work/munge/socket" --pid-file="$work/munge/pid" \
    --log-file="$work/munge/log" --seed-file="$work/munge/seed" >munge.log 2>&1 &
  for _ in {1..100}; do [[ -S munge/socket ]] && break; sleep 0.1; done
  [[ -S munge/socket ]] || fail "munged does not start"
  slurmctld -D >slurmctld.log 2>&1 &
  slurmd -D >slurmd.log 2>&1 &
  for _ in {1..100}; do
    [[ $(sinfo -h -o %t 2>/dev/null) == idle ]] && return
    kill -0 $! 2>/dev/null || skip "slurmd does not start here: $(tail -n 1 slurmd.log)"
    sleep 0.1
  done
  fail "Slurm does not start"
}

# Daemons that were killed start again after ten seconds, as under a supervisor.
readonly RESTART_S=10
down_since=0
revive() {
  ((SECONDS - down_since >= RESTART_S)) || return
  [[ $(ours slurmctld) ]] || (cd "$work" && exec slurmctld -D >>slurmctld.log 2>&1) &
  [[ $(ours slurmd) ]] || (cd "$work" && exec slurmd -D >>slurmd.log 2>&1) &
}

# find_lost : what Slurm's user does about lost jobs. A slurmctld that was killed has forgotten the last seconds, so it may
# believe that jobs still run that have ended. When a node registers, slurmctld asks it for its jobs; a job that the node
# does not have is requeued if it began more than BatchStartTimeout (10 s) ago. A node that registers earlier than that, as
# it does when both daemons start again, does not register again for half an hour.
find_lost() {
  local running
  mapfile -t running < <(squeue -h -r -t R -o %i 2>/dev/null)
  ((${#running[@]})) || return
  [[ $(ours evenstep) ]] && return
  scancel "${running[@]}" && lost=$((lost + 1))
}

# operate : does what Slurm's operator does, who resumes nodes that Slurm has drained, and what its user does, who submits
# again. A slurmctld that was killed has forgotten the jobs of its last five seconds, and gives their numbers to new jobs. If
# an old job still runs, it drains the node and holds the new job.
operate() {
  local jobs
  jobs=$(squeue -h -o '%r' 2>/dev/null) || return
  if [[ ! $(sinfo -h -o %t) =~ ^(idle|mix|alloc|comp)$ ]]; then
    for process in $(ours slurmd); do kill -KILL "$process"; done   # it starts again, and says that it is there
    revive
    scontrol update NodeName="$(hostname -s)" State=RESUME
  fi
  if [[ ! -e $kind.jsonl ]] && [[ -z $jobs || ${jobs,,} =~ held|maxrequeue ]]; then
    again=$((again + 1))
    "$examples/slurm/submit.sh" "$scenario" >>run.log 2>&1
  fi
}

# wait_for FILE : waits for the file as a user would
wait_for() {
  for _ in {1..300}; do [[ -e $1 ]] && return; sleep 0.2; done
  fail "$1 is not there: $(squeue)"
}

# refuses_old_parts COMMAND... : if a scenario has changed, parts of the old one must not become its result
refuses_old_parts() {
  cp "$work/s.toml" "$work/before.toml"
  rm -f "$kind.jsonl"
  sed -i 's/^duration *= .*/duration = "19 s"/' "$work/s.toml"
  "$@" >old.log 2>&1
  (($? == 3)) || fail 'parts of another scenario are taken'
  grep -qF "is of another $kind" old.log || fail 'it does not say that parts are of another scenario'
  [[ ! -e $kind.jsonl ]] || fail 'parts of another scenario were merged'
  mv "$work/before.toml" "$work/s.toml"
}

# submitted_again : submit.sh submits only what is not complete, and cancels jobs that are held
submitted_again() {
  local said
  rm "parts/$kind-3-of-4.jsonl" "$kind.jsonl"
  scontrol update NodeName="$(hostname -s)" State=DRAIN Reason=test
  said=$("$examples/slurm/submit.sh" "$scenario") || fail 'submit.sh fails where a shard is missing'
  [[ $said == *'of 1 of 4 shards'* ]] || fail "one shard is missing, but submit.sh says: $said"
  said=$("$examples/slurm/submit.sh" "$scenario")
  [[ $said == *'of 0 of 4 shards'* ]] || fail "a shard is in the queue, but submit.sh says: $said"
  squeue -h -r -t PD -o %i -n "$(squeue -h -t PD -o '%K %j' | sed -n 's/^[0-9].* //p')" | xargs scontrol hold
  said=$("$examples/slurm/submit.sh" "$scenario")
  [[ $said == *'of 1 of 4 shards'* ]] || fail "a shard is held, but submit.sh says: $said"
  scontrol update NodeName="$(hostname -s)" State=RESUME
  wait_for "$kind.jsonl"
  judge
  [[ $kind != sweep ]] || refuses_old_parts submit_and_wait
}
# submit_and_wait : prints the log of the merge and returns its exit status
submit_and_wait() {
  local id
  id=$("$examples/slurm/submit.sh" "$scenario" | sed -n 's/.*shards, \([0-9]*\) of the merge.*/\1/p')
  for _ in {1..300}; do [[ $(squeue -h -j "$id" -o %t 2>/dev/null) ]] || break; sleep 0.2; done
  cat "$kind-merge.log"
  return "$(scontrol show job "$id" | sed -n 's/.*ExitCode=\([0-9]*\):.*/\1/p')"
}

engine_slurm() {
  need slurmctld slurmd munged sbatch
  (($(id -u) == 0)) || skip "slurmd needs root"
  [[ -d /sys/fs/cgroup ]] || skip "slurmd does not start without /sys/fs/cgroup"
  local names ticks name process
  start_slurm
  while ((hits < kills)); do
    names=(slurmctld)
    [[ $engine == slurm_both ]] ||
      names=(evenstep evenstep evenstep evenstep evenstep slurmd evenstep evenstep evenstep evenstep evenstep slurmctld)
    fresh
    "$examples/slurm/submit.sh" "$scenario" >run.log 2>&1 || fail "sbatch refuses: $(cat run.log)"
    name=${names[hits % ${#names[@]}]}
    [[ $name == evenstep ]] || sleep 0.2   # the daemons are there from the start
    strike "$name" && [[ $name == slurm* ]] && down_since=$SECONDS
    if [[ $engine == slurm_both ]]; then
      sleep "0.$((RANDOM % 10))"
      for process in $(ours slurmd); do kill -KILL "$process"; done
      down_since=$SECONDS
    fi
    ticks=0
    until [[ -e $kind.jsonl ]]; do
      revive
      sleep 0.2
      ((++ticks < 900)) || fail "run $runs does not end: $(sinfo -h -o '%t %E'; squeue)"
      ((ticks % 25)) || operate
      ((ticks % 100)) || find_lost
    done
    judge
    scancel --user="$(id -un)"
    for _ in {1..100}; do [[ -z $(squeue -h 2>/dev/null) ]] && break; sleep 0.1; done
  done
  [[ $engine == slurm_both ]] || submitted_again
}

engine_slurm_both() { engine_slurm; }

"engine_$engine"
printf '%s: %d kills (' "$engine" "$hits"
for name in "${!by[@]}"; do printf ' %s %d' "$name" "${by[$name]}"; done
printf ' ), %d runs, %d submitted again, lost jobs found %d times, merged bytes equal each time; %d s\n' \
  "$runs" "$again" "$lost" "$SECONDS"
