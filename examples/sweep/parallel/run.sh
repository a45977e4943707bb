#!/bin/bash
# run.sh SCENARIO [PARALLEL OPTIONS] : a job is a shard. The log says which ones are complete; those that are not run again,
# also after parallel itself was killed. Exit status 1, points that fail, is a result.
set -uo pipefail
scenario=$1
shift
job="evenstep sweep $(printf %q "$scenario") --shard auto --of ${SHARDS:-4} --resume --threads 1 --out parts"
job+=' || [ $? -eq 1 ]'
for attempt in 1 2 3 4 5; do
  if parallel --joblog sweep.joblog --resume-failed -N0 "$@" "$job" ::: $(seq "${SHARDS:-4}"); then
    exec evenstep merge parts/sweep-*-of-"${SHARDS:-4}".jsonl --out sweep.jsonl
  fi
done
exit 3
