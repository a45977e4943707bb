#!/usr/bin/env bash
# Builds and runs the benchmarks and prints their tables, least and median of the repetitions
# (docs/internals/performance.md):
#   scripts/bench.sh                  all
#   scripts/bench.sh scheduler        the tables named: scheduler paths sizing solver features figure-1
#   scripts/bench.sh tick             how late a thread wakes 1000 times a second, by how it waits and what it is granted
#   scripts/bench.sh own-lane         how much slower steps are beside a drawing: the factor of `evenstep size --own-lane`
#   scripts/bench.sh fronts           latency against jump of all maps on the recordings, and its figure in docs/images
# EVENSTEP_BENCH_REPETITIONS (9) says how often each number is taken; the repetitions of one table are interleaved.
set -euo pipefail
repo=$(dirname -- "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")")
source "$repo/scripts/setup.sh"
repetitions=${EVENSTEP_BENCH_REPETITIONS:-9}
tables=("$@")
if (($# == 0)); then tables=(scheduler paths sizing solver features figure-1); fi

build=$(build_folder)
is_configured || configure release --fresh
out=$build/bench/results
mkdir -p -- "$out"
export POCL_CACHE_DIR=${POCL_CACHE_DIR:-$build/pocl-cache}

# measure PROGRAM : the table of a program of Google Benchmark
measure() {
  local program=$1
  grep -q '^benchmark_DIR:PATH=/' "$build/CMakeCache.txt" ||
    fail "Google Benchmark is not there: apt-get install libbenchmark-dev, then remove $build/CMakeCache.txt"
  compile "building bench_$program" "bench_$program"
  "$build/bench/bench_$program" --benchmark_repetitions="$repetitions" --benchmark_enable_random_interleaving=true \
    --benchmark_min_time=0.05 --benchmark_format=json >"$out/$program.json" 2>"$out/$program.log" ||
    { cat -- "$out/$program.log" >&2; fail "bench_$program failed: see above"; }
  python3 "$repo/bench/table.py" "$out/$program.json"
}

machine() {
  printf 'machine: %s, %s cores; load %s\n' "$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)" "$(nproc)" \
    "$(cut -d' ' -f1-3 /proc/loadavg)"
  printf 'compiler: %s; Release (-O2); %s; commit %s\n' "$(c++ --version | head -1)" \
    "$(dpkg-query -W -f '${Package} ${Version}' pocl-opencl-icd 2>/dev/null || echo 'PoCL unknown')" \
    "$(git -C "$repo" describe --always --dirty 2>/dev/null || echo unknown)"
  awk '$1 > 0.5 { print "busy: trust the least more than the median, and two threads not at all" }' /proc/loadavg
}

machine
for table in "${tables[@]}"; do
  printf '\n== %s\n' "$table"
  case $table in
    scheduler) measure scheduler_events ;;
    paths) measure core_paths ;;
    fronts)
      compile 'building bench_map_fronts' bench_map_fronts
      "$build/bench/bench_map_fronts" "$repo/scenarios/recorded" "$repo/docs/images/latency-jump-fronts.svg"
      ;;
    sizing)
      compile 'building bench_sizing' bench_sizing
      "$build/bench/bench_sizing" "$repetitions"
      ;;
    solver)
      compile 'building bench_solver_steps' bench_solver_steps
      POCL_DEVICES='basic pthread' OMP_WAIT_POLICY=passive "$build/bench/bench_solver_steps" \
        $((repetitions * 5))
      ;;
    features)
      compile 'building bench_feature_costs' bench_feature_costs
      POCL_DEVICES=basic "$build/bench/bench_feature_costs" $((repetitions * 5))
      ;;
    figure-1)
      compile 'building bench_figure_1' bench_figure_1
      POCL_DEVICES=${POCL_DEVICES:-basic} "$build/bench/bench_figure_1" "$repo/scenarios/paper/figure-1.toml" \
        "$repetitions"
      ;;
    tick)
      compile 'building bench_device_tick' bench_device_tick
      "$build/bench/bench_device_tick" $((repetitions * 5))
      ;;
    own-lane)
      compile 'building bench_own_lane' bench_own_lane
      POCL_DEVICES=${POCL_DEVICES:-pthread} "$build/bench/bench_own_lane" \
        "${EVENSTEP_BENCH_SCENARIO:-$repo/scenarios/paper/figure-1.toml}" "$repetitions"
      ;;
    *) fail "no table '$table': scheduler paths sizing solver features figure-1 tick own-lane fronts" ;;
  esac
done
