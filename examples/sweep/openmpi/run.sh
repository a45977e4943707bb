#!/bin/bash
# run.sh SCENARIO [MPIRUN OPTIONS] : a rank is a shard. mpirun ends all ranks when one is killed or exits with a status
# other than 0; --resume goes on with what each has written. Exit status 1 (some points fail) is a result.
set -uo pipefail
usage="usage: run.sh SCENARIO [OPTIONS OF mpirun], with evenstep in the PATH"
if (($# == 0)) || ! command -v evenstep >/dev/null; then echo "$usage" >&2; exit 2; fi
work=${WORK:-sweep} kind=${work%% *}   # WORK="size --rate 0.1% --seeds 0..1000": what is divided
scenario=$1
shift
rank="evenstep $work"' "$0" --shard auto --resume --threads 1 --out parts || [ $? -eq 1 ]'
for attempt in 1 2 3 4 5; do
  if mpirun -n "${SHARDS:-4}" "$@" sh -c "$rank" "$scenario"; then
    # Old parts of another scenario must not be merged: reading shard 1 again fails if it is such a part.
    evenstep $work "$scenario" --shard 1/"${SHARDS:-4}" --resume --out parts >/dev/null
    if (($? > 1)); then exit 3; fi
    exec evenstep merge parts/"$kind"-*-of-"${SHARDS:-4}".jsonl --out "$kind.jsonl"
  fi
done
exit 3
