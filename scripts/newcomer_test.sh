#!/usr/bin/env bash
# A newcomer's first minutes, with the committed state of this clone: a fresh clone in a path with spaces, used by a user
# without rights and without a home, then again without a network.
#   scripts/newcomer_test.sh        prints the wall time of each step; exit status 1 if one fails, 77 if not started as root
# It runs as root, because it installs missing packages, becomes another user and takes the network away.
set -euo pipefail
repo=$(dirname -- "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")")
source "$repo/scripts/setup.sh"
(($(id -u) == 0)) || { note "skipped: this test needs root"; exit 77; }

folder=$(mktemp -d "${TMPDIR:-/tmp}/evenstep newcomer XXXXXX")
trap 'rm -rf -- "$folder"' EXIT
clone="$folder/a clone of evenstep" build=$folder/none
newcomer=(setpriv --reuid 65534 --regid 65534 --clear-groups env -i HOME=/nonexistent PATH=/usr/local/bin:/usr/bin:/bin)

seconds_between() { awk -v start="$1" -v end="$2" 'BEGIN { print end - start }'; }

# timed STEP TEXT COMMAND... : the command must succeed and have TEXT on stdout
timed() {
  local step=$1 text=$2 start=$EPOCHREALTIME status=0
  shift 2
  "$@" >"$folder/out" || status=$?
  printf '%-50s %8.1f s  exit %d\n' "$step" "$(seconds_between "$start" "$EPOCHREALTIME")" "$status"
  ((status == 0)) && grep -q -- "$text" "$folder/out" && return 0
  cat -- "$folder/out"
  fail "$step: exit status $status, and on stdout '$text' was expected"
}

git clone -q -- "$repo" "$clone"
with_tests
install_packages
chmod 755 "$folder"
chown -R 65534:65534 "$clone"
cd -- "$clone"
table='signal .*metric .*value .*verdict'
timed 'first ./run.sh, with the build' "$table" "${newcomer[@]}" ./run.sh
timed 'second ./run.sh, without a network' "$table" unshare -n "${newcomer[@]}" ./run.sh
timed './run.sh --version' 'evenstep' "${newcomer[@]}" ./run.sh --version
timed './test.sh -R remap, with the build of all tests' '100% tests passed' unshare -n "${newcomer[@]}" ./test.sh -R remap
[[ -z $(git -c safe.directory='*' status --porcelain) ]] || fail "files were left in the clone that git does not ignore"
