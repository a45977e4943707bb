#!/usr/bin/env bash
# reported.sh STATUS TEXT PROGRAM ARGUMENTS... : PROGRAM must end with STATUS and TEXT in its report.
set -uo pipefail
report=$("${@:3}" 2>&1)
status=$?
printf '%s\nexit status %d\n' "$report" "$status"
[[ $status == "$1" && $report == *"$2"* ]]
