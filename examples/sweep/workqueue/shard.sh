#!/bin/bash
# shard.sh FOLDER SHARD EVENSTEP SCENARIO WORK... : exit status 1 (some points fail) is a result.
"$3" "${@:5}" "$4" --shard "$2" --resume --threads 1 --out "$1/parts"
status=$?
if ((status == 1)); then exit 0; fi
exit "$status"
