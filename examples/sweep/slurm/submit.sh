#!/bin/bash
# submit.sh SCENARIO : the shards as an array, and the merge when all its tasks have ended. It may be run again at any time,
# and must be if squeue shows none of its jobs and the merged file is not there: it submits those shards that are neither
# complete nor in the queue, and the merge. Held jobs, and complete ones that Slurm calls running, are cancelled first.
set -euo pipefail
if (($# != 1)) || ! command -v evenstep >/dev/null; then
  echo "usage: submit.sh SCENARIO, with evenstep in the PATH" >&2
  exit 2
fi
here=$(dirname -- "$(readlink -f -- "$0")")
work=${WORK:-sweep} kind=${work%% *} of=${SHARDS:-4}
name=$kind-of-$of-$(pwd | cksum | cut -d ' ' -f 1)   # of the jobs of this folder
declare -A queued=()
jobs=$(squeue --me --noheader --array --name="$name" --states=PENDING,RUNNING,SUSPENDED --format='%i %K %T %r')
while read -r id task state why; do
  if [[ ! $task =~ ^[0-9]+$ ]]; then continue; fi
  if [[ $state == RUNNING && -e parts/$kind-$task-of-$of.jsonl || ${why,,} =~ held|maxrequeue ]]; then scancel "$id"
  else queued[$task]=${id%_*}; fi
done <<<"$jobs"
lacking=()
for ((shard = 1; shard <= of; ++shard)); do
  if [[ ! -e parts/$kind-$shard-of-$of.jsonl && ! ${queued[$shard]-} ]]; then lacking+=("$shard"); fi
done
if ((${#lacking[@]})); then
  array=1-$of
  if ((${#lacking[@]} < of)); then array=$(IFS=,; echo "${lacking[*]}"); fi
  queued[new]=$(sbatch --parsable --job-name="$name" --output="$kind-%a.log" --array="$array" "$here/sweep.sbatch" "$1")
fi
scancel --me --name="$name-merge"
after=$(printf '%s\n' "${queued[@]}" | sort -u | paste -sd :)
merge=$(sbatch --parsable --job-name="$name-merge" --output="$kind-merge.log" ${after:+--dependency=afterany:"$after"} \
  "$here/merge.sbatch" "$1")
echo "jobs: ${queued[new]:-none} of ${#lacking[@]} of $of shards, $merge of the merge into $kind.jsonl"
