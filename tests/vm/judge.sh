#!/usr/bin/env bash
# judge.sh FOLDER LINE... : every regular expression has its line in the guest's log.   judge.sh FOLDER --same : both logs are equal.
set -euo pipefail
folder=$1
shift
[[ -s $folder/1.log && -s $folder/2.log ]] || { echo "skipped: the guest was not booted (see vm_boots)"; exit 0; }
if [[ $1 == --same ]]; then
  cmp -- "$folder/1.log" "$folder/2.log" || { diff -- "$folder/1.log" "$folder/2.log" | head -n 20; exit 1; }
  exit 0
fi
for line in "$@"; do
  grep -qE -e "$line" -- "$folder/1.log" || { printf 'no line "%s" in:\n' "$line"; cat -- "$folder/1.log"; exit 1; }
done
