#!/usr/bin/env bash
# csharp_test.sh ROOT LIBRARY REMAP_CALLS CASE : examples/csharp with this libevenstep_remap_c.so, under mono. Exits with 1
# on failure, and with 77 where mono is not installed.
set -euo pipefail
root=$1 library=$2 remap_calls=$3 name=$4
for tool in mcs mono; do
  command -v "$tool" >/dev/null || { echo "skipped: there is no $tool (Debian: mono-mcs)"; exit 77; }
done
work=$(mktemp -d "${TMPDIR:-/tmp}/evenstep-csharp-XXXXXX")
trap 'rm -rf -- "$work"' EXIT
readonly here=$root/tests/embedding/csharp example=$root/examples/csharp
export LD_LIBRARY_PATH
LD_LIBRARY_PATH=$(dirname -- "$library")

fail() { printf 'FAILED: %s\n' "$*"; exit 1; }
# compile PROGRAM SOURCE... : without a warning, and all that is public has its comment
compile() { mcs -langversion:6 -warn:4 -warnaserror -doc:"$work/doc.xml" -out:"$1" "${@:2}"; }
# fails TEXT COMMAND... : the command fails and says TEXT
fails() {
  if "${@:2}" >"$work/log" 2>&1; then fail "this should fail: ${*:2}"; fi
  grep -qF -- "$1" "$work/log" || { cat -- "$work/log"; fail "it does not say '$1'"; }
}
wrapper_test() { compile "$work/wrapper_test.exe" "$example/Evenstep.cs" "$here/wrapper_test.cs"; }

case_the_loop_of_unity_reads_a_straight_line() {
  compile "$work/fixed_update.exe" "$example"/*.cs
  mono "$work/fixed_update.exe" | tee "$work/printed"
  diff "$work/printed" <(sed -n '/^```text/,/^```/ { /^```/! p }' "$example/README.md") ||
    fail "its README shows something else"
  fails 'LatencyNs is too small' mono "$work/fixed_update.exe" 30000000
}
case_the_numbers_are_those_of_the_c_library_on_200_random_schedules() {
  wrapper_test
  "$remap_calls" 200 | mono "$work/wrapper_test.exe" numbers
  "$remap_calls" 2 plant >"$work/planted"
  fails 'run 1: the counts' mono "$work/wrapper_test.exe" numbers <"$work/planted"
}
case_what_is_wrong_is_an_exception_with_the_words_of_the_library() {
  wrapper_test
  mono "$work/wrapper_test.exe" refusals
  LD_LIBRARY_PATH=/nowhere fails 'name its folder in LD_LIBRARY_PATH' mono "$work/wrapper_test.exe" opens
}
case_ticks_and_steps_allocate_nothing() {
  wrapper_test
  mono "$work/wrapper_test.exe" allocations
}
case_two_threads_use_one_remap() {
  wrapper_test
  mono "$work/wrapper_test.exe" threads
}
# A struct of another size is noticed before anything is done with it, whichever it is; and so is another interface.
case_structs_that_differ_from_those_of_the_library_are_refused_at_once() {
  local struct
  echo 'class Opens { static void Main() { Evenstep.RemapOptions.Defaults(); } }' >"$work/opens.cs"
  for struct in RemapOptions StepClock StepRead RemapCounts; do
    sed "/public struct $struct\$/,/StructSize;/ s/internal uint StructSize;/& internal long Planted;/" \
      "$example/Evenstep.cs" >"$work/Evenstep.cs"
    mcs -out:"$work/opens.exe" "$work/Evenstep.cs" "$work/opens.cs"
    fails 'set it to sizeof the struct' mono "$work/opens.exe"
  done
  sed 's/const uint Abi = 1;/const uint Abi = 2;/' "$example/Evenstep.cs" >"$work/Evenstep.cs"
  mcs -out:"$work/opens.exe" "$work/Evenstep.cs" "$work/opens.cs"
  fails 'has interface 1, Evenstep.cs has 2' mono "$work/opens.exe"
}

"case_$name"
