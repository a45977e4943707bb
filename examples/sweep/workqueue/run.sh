#!/bin/bash
# run.sh SCENARIO [MAKEFLOW OPTIONS] : a task is a shard. It is given to a worker that asks for work (work_queue_worker HOST
# PORT), and to another one if that worker is lost. The folder must be the same on all machines. Makeflow's log says what is
# done: after makeflow itself was killed, run this again.
set -uo pipefail
usage="usage: run.sh SCENARIO [OPTIONS OF makeflow], with evenstep in the PATH"
if (($# == 0)) || ! command -v evenstep >/dev/null; then echo "$usage" >&2; exit 2; fi
work=${WORK:-sweep} kind=${work%% *}   # WORK="size --rate 0.1% --seeds 0..1000": what is divided
here=$(dirname -- "$(readlink -f -- "$0")")
scenario=$(readlink -f -- "$1")
shift
for shard in $(seq "${SHARDS:-4}"); do
  printf '%s:\n\t%s %s %s %s %s %s\n\n' "$PWD/parts/$kind-$shard-of-${SHARDS:-4}.jsonl" \
    "$here/shard.sh" "$PWD" "$shard/${SHARDS:-4}" "$(command -v evenstep)" "$scenario" "$work"
done >"$kind.makeflow"
makeflow -T wq --shared-fs "$PWD" --retry-count=5 "$@" "$kind.makeflow" || exit 3
# Old parts of another scenario must not be merged: reading shard 1 again fails if it is such a part.
evenstep $work "$scenario" --shard 1/"${SHARDS:-4}" --resume --out parts >/dev/null
if (($? > 1)); then exit 3; fi
exec evenstep merge parts/"$kind"-*-of-"${SHARDS:-4}".jsonl --out "$kind.jsonl"
