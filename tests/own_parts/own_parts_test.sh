#!/usr/bin/env bash
# A program of ten lines that adds parts works as evenstep does, and knows these parts in every command.
#   own_parts_test.sh PROGRAM SOURCE_DIR
set -euo pipefail
program=$1
here=$2/tests/own_parts
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

fail() { echo "own parts: $*" >&2; exit 1; }
# holds TEXT COMMAND... : the command succeeds and prints TEXT
holds() {
  local text=$1 out
  shift
  out=$("$program" "$@" 2>&1) || fail "$* exits with $?: $out"
  grep -qF -- "$text" <<<"$out" || fail "$* does not say '$text': $out"
}
# refused CODE TEXT COMMAND... : the command exits with CODE and says TEXT
refused() {
  local code=$1 text=$2 out got=0
  shift 2
  out=$("$program" "$@" 2>&1) || got=$?
  ((got == code)) || fail "$* exits with $got, not $code: $out"
  grep -qF -- "$text" <<<"$out" || fail "$* does not say '$text': $out"
}

cp "$here"/own_parts.toml "$here"/too_late.toml .
holds 'PASS' run own_parts.toml --out run
holds "the solver 'my-spring' lacks contacts, state_digest, energy, particles, reset" run own_parts.toml --out run
grep -q '"solver_lacks"' run/summary.json || fail 'summary.json does not say what the solver lacks'
[[ -e run/figure-1a-left.svg ]] || fail "no figure: $(ls run)"
holds 'PASS' run own_parts.toml --repeat --threads 2 --out run
holds 'PASS' run own_parts.toml --permute-ties 3 --out run
holds "'my-spring', a solver that the program registered" check own_parts.toml
holds 'lacks        contacts, state_digest, energy, particles, reset' check own_parts.toml
holds "driver 'my-arm'" check own_parts.toml
holds 'foreign' size own_parts.toml
holds 'foreign solvers: my-spring' list
holds 'foreign devices: my-arm' list
holds 'foreign maps: my-pacer' list
holds 'foreign timings: my-gpu' list
holds '"my-pacer"' schema
refused 2 "has no energy" run own_parts.toml --out run --set \
  'expect=[{ signal = "solver.direct", metric = "energy_growth", max = 1 }]'
refused 2 "did you mean 'my-spring'" check own_parts.toml --set scene.name=my-sprig
holds '4 points' sweep own_parts.toml --out sweep --threads 2
refused 1 'FAIL' run too_late.toml --out run
holds 'lengths are not nominal' shrink too_late.toml --out shrunk
refused 1 'FAIL' run shrunk/too_late-shrunk.toml --out run
holds "'my-spring', a solver that the program registered" study own_parts.toml --out study
grep -q . study/*.svg || fail "no figure of the study: $(ls study)"
echo 'own parts: every command works with them'
