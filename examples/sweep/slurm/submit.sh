#!/bin/bash
# submit.sh SCENARIO : the shards as an array, and the merge when all of them are complete.
set -euo pipefail
here=$(dirname -- "$(readlink -f -- "$0")")
array=$(sbatch --parsable --array=1-"${SHARDS:-4}" "$here/sweep.sbatch" "$1")
sbatch --parsable --dependency=afterok:"$array" --kill-on-invalid-dep=yes "$here/merge.sbatch"
