#!/usr/bin/env bash
# Installs what is missing, builds, and runs evenstep:
#   ./run.sh                  the paper's Figure 1, with its verdict table
#   ./run.sh ARGUMENTS...     evenstep ARGUMENTS... (./run.sh --help)
set -euo pipefail
repo=$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")
source "$repo/scripts/setup.sh"

set_up release evenstep
if (($# == 0)); then set -- run "$repo/scenarios/paper/figure-1.toml"; fi
# Commands that the program prints for pasting start as this was started.
called_as=$0
[[ $called_as == */* ]] || called_as=./$called_as
EVENSTEP_CALLED_AS=$called_as exec "$build/apps/evenstep" "$@"
