#!/usr/bin/env bash
# same_as_harness.sh ROOT EMBED EVENSTEP OUT : checks that the jump that examples/embed prints is, in its two digits, the one
# that `evenstep run` measures for the same timing, motion and spring. The jumps of the forces are only rounding in both.
set -euo pipefail
"$3" run "$1/scenarios/paper/figure-1-spring.toml" --out "$4" >/dev/null
signal='"signal":"left.interaction.phase_locked","metric":"velocity_jump"'
measured=$(sed -nE "s/.*$signal,\"value\":([0-9.e+-]+).*/\1/p" "$4/summary.json")
embed=$("$2")
echo "evenstep: velocity jump $measured step; the example: $embed"
[[ $measured && $embed == "velocity jump: $(printf '%.2g' "$measured") step in, "* ]]
