#!/usr/bin/env bash
# judge.sh FOLDER LINE... : passes if every regular expression matches a line of the guest's log.
# judge.sh FOLDER --of SCENARIO LINE... : the same for what the guest printed about that live run.
# judge.sh FOLDER --same : passes if two boots printed the same about the first live run.
set -euo pipefail
folder=$1
shift
[[ -s $folder/1.log && -s $folder/2.log ]] || { echo "skipped: the guest was not booted (see vm_boots)"; exit 0; }
if [[ $1 == --same ]]; then
  cmp -- "$folder/live.log" "$folder/2.log" || { diff -- "$folder/live.log" "$folder/2.log" | head -n 20; exit 1; }
  exit 0
fi
log=$(<"$folder/1.log")
if [[ $1 == --of ]]; then
  # From its mark to the next mark that is not its exit status.
  log=$(awk -v mark="== $2" '/^== / { mine = index($0 ":", mark ":") == 1 } mine' "$folder/1.log")
  shift 2
fi
for line in "$@"; do
  grep -qE -e "$line" <<<"$log" || { printf 'no line "%s" in:\n' "$line"; printf '%s\n' "$log"; exit 1; }
done
