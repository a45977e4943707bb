#!/usr/bin/env bash
# Installs what is missing, builds, and runs all tests:
#   ./test.sh                    all but the long ones
#   EVENSTEP_LONG=1 ./test.sh    the long ones too
#   ./test.sh -R remap           further arguments go to ctest
set -euo pipefail
repo=$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")
source "$repo/scripts/setup.sh"

with_tests
set_up release all
without_long=(-LE '^(long|million|mutation|newcomer|extending|package|distro)$')   # docs/internals/testing.md
if [[ ${EVENSTEP_LONG:-0} != 0 ]]; then without_long=(); fi
# One more at a time than there are processors: some tests only wait for daemons, or for a live run.
exec ctest --test-dir "$build" -j"$(($(nproc) + 1))" --output-on-failure --no-tests=error "${without_long[@]}" "$@"
