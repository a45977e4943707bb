#!/usr/bin/env bash
# snippets.sh ROOT : if the first line of a code block in README.md or docs/ names a file of examples/ in a comment, the
# block must be a literal piece of that file. Exit 1 if one is not.
set -uo pipefail
root=$1
failures=0 blocks=0
fail() { printf '%s\n' "$1"; failures=$((failures + 1)); }

# check PAGE TEXT : TEXT is a whole block
check() {
  local first=${2%%$'\n'*} rest=${2#*$'\n'}
  [[ $first =~ ^(//|\#|/\*)\ (examples/[^ ]+)( \*/)?$ ]] || return 0
  local file=${BASH_REMATCH[2]}
  blocks=$((blocks + 1))
  [[ -e $root/$file ]] || { fail "$1: there is no $file"; return; }
  [[ $'\n'$(cat -- "$root/$file")$'\n' == *$'\n'"$rest"* ]] || fail "$1: this is not in $file:"$'\n'"$rest"
}

# check_page PAGE
check_page() {
  local line text='' inside=0
  while IFS= read -r line; do
    if [[ $line != '```'* ]]; then
      ((inside == 0)) || text+=$line$'\n'
    elif ((inside == 0)); then
      inside=1 text=
    else
      check "$1" "$text"
      inside=0
    fi
  done <"$root/$1"
}

# A text that is not in its file must be noticed, and so must a file that does not exist.
check planted $'// examples/embed/embed.cpp\nint planted;\n' >/dev/null
check planted $'/* examples/planted.c */\n' >/dev/null
((failures == 2)) || { echo 'a planted piece of code is not seen'; exit 1; }
failures=0 blocks=0
for page in README.md $(cd -- "$root" && ls docs/*.md docs/*/*.md); do check_page "$page"; done
((blocks >= 5)) || fail "only $blocks blocks were found"
((failures == 0)) && echo "$blocks blocks are as the examples have them"
((failures == 0))
