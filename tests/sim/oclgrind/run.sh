#!/usr/bin/env bash
# What Oclgrind, which interprets kernels and watches every access of every work-item, has to say:
#   run.sh race            it reports a kernel with a data race
#   run.sh clean PROGRAM   it runs PROGRAM and has nothing to report
# Exit status 77 where it is not installed.
set -euo pipefail
command -v oclgrind oclgrind-kernel >/dev/null || { echo 'skipped: oclgrind is not installed (Debian: oclgrind)'; exit 77; }
report=$(mktemp)
trap 'rm -f -- "$report"' EXIT

case $1 in
  race)
    cd -- "$(dirname -- "${BASH_SOURCE[0]}")"
    oclgrind-kernel --data-races --log "$report" race.sim
    grep -q 'data race' "$report" || { echo 'a kernel with a data race was not reported'; exit 1; }
    ;;
  clean)
    status=0
    oclgrind --data-races --check-api --max-errors 5 --log "$report" "${@:2}" || status=$?
    cat -- "$report"
    [[ $status == 0 && ! -s $report ]] || { echo "exit status $status, and reports as above"; exit 1; }
    ;;
  *) echo "run.sh race | run.sh clean PROGRAM" >&2; exit 2 ;;
esac
