#!/usr/bin/env bash
# docs_test.sh ROOT PROGRAM... : checks that every ```cpp block of docs/parts/own-loop.md is in the file that its first line
# names, and that every ```console block is what the PROGRAM that it names prints. Exit 1 if not.
set -uo pipefail
root=$1
shift
declare -A programs=()
for program in "$@"; do programs[$(basename "$program" | sed 's/^example_//')]=$program; done
failures=0 blocks=0
fail() { printf 'docs/parts/own-loop.md: %s\n' "$1"; failures=$((failures + 1)); }

# check KIND TEXT
check() {
  local first=${2%%$'\n'*} rest=${2#*$'\n'} name
  blocks=$((blocks + 1))
  if [[ $1 == cpp ]]; then
    name=${first#// }
    [[ $(cat "$root/$name") == *$'\n'"$rest"* ]] || fail "not in $name: $rest"
  else
    name=${first#\$ }
    [[ ${programs[$name]-} ]] || { fail "no program '$name'"; return; }
    [[ $("${programs[$name]}")$'\n' == "$rest" ]] || fail "$name does not print: $rest"
  fi
}

kind='' text=''
while IFS= read -r line; do
  case $kind$line in
    '```cpp' | '```console') kind=${line#'```'} text='' ;;
    cpp'```' | console'```') check "$kind" "$text"; kind='' ;;
    *) text+=$line$'\n' ;;
  esac
done <"$root/docs/parts/own-loop.md"
((blocks >= 8)) || fail "only $blocks blocks were found"
((failures == 0)) && echo "$blocks blocks are as the examples have them"
((failures == 0))
