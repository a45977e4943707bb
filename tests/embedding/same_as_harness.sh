#!/usr/bin/env bash
# same_as_harness.sh ROOT EMBED EVENSTEP OUT : the jump that examples/embed prints, to its two digits, is that of `evenstep
# run` for the same timing, motion and spring. Of the forces both only have the rounding of doubles.
set -euo pipefail
"$3" run "$1/scenarios/paper/figure-1-spring.toml" --out "$4" >/dev/null
signal='"signal":"left.interaction.phase_locked","metric":"velocity_jump"'
measured=$(sed -nE "s/.*$signal,\"value\":([0-9.e+-]+).*/\1/p" "$4/summary.json")
embed=$("$2")
echo "evenstep: velocity jump $measured step; the example: $embed"
[[ $measured && $embed == "velocity jump: $(printf '%.2g' "$measured") step in, "* ]]
