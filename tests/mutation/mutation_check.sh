#!/usr/bin/env bash
# mutation_check.sh SOURCE_DIR CATCH_LIBRARY COMPILER... : applies each mutation of mutations.txt to a copy of remap/,
# builds the one test file that is expected to notice, runs its named cases, and reports killed or survived. Exit 1 if
# one survived, does not compile, or does not match the source any more, or if the cases fail on the unbroken source.
# MUTATION=NAME: that one only. JOBS=N: so many at a time (default: one per core).
set -uo pipefail
source_dir=$1
catch_library=$2
compiler=("${@:3}")
list=$source_dir/tests/mutation/mutations.txt
work=$(mktemp -d "${TMPDIR:-/tmp}/evenstep-mutation-XXXXXX")
trap 'rm -rf "$work"' EXIT

# compile SOURCE OBJECT : one source of a copy; the copy is the working directory
compile() {
  "${compiler[@]}" -std=c++20 -O2 -ffp-contract=off -Iremap/include -Iclock/time/include -Itests/remap -c "$1" -o "$2"
}
# objects_of FOLDER : all sources of the remap room and of time
objects_of() {
  local source
  for source in remap/src/*.cpp clock/time/src/*.cpp; do
    compile "$source" "$1/$(basename "$source").o" || return 1
  done
}
# link FOLDER TEST_FILE : the objects there and that test's
link() { "${compiler[@]: -1}" "$1"/*.cpp.o "$2" "$catch_library" -pthread -o "$1/test"; }
fresh_copy() { mkdir -p "$1" && cp -r "$work/unbroken/remap" "$work/unbroken/clock" "$work/unbroken/tests" "$1"; }

# replace FILE FROM TO : a literal text that must occur exactly once
replace() {
  local text rest
  text=$(cat "$1" && printf x) || return 1
  text=${text%x}
  rest=${text#*"$2"}
  [[ $rest != "$text" ]] || { echo "no such text in $1: $2"; return 1; }
  [[ ${rest#*"$2"} == "$rest" ]] || { echo "more than one such text in $1: $2"; return 1; }
  printf '%s%s%s' "${text%%"$2"*}" "$3" "$rest" >"$1"
}

# mutate NAME LINES... : one block of the list, in a copy of its own; writes its verdict to NAME.verdict
mutate() {
  local name=$1 key value file from test cases headers=no sources=()
  shift
  local copy=$work/$name verdict=$work/$name.verdict
  fresh_copy "$copy"
  cd "$copy" || return
  for line in "$@"; do
    key=${line%%: *}
    value=${line#*: }
    case $key in
      file) file=$value; if [[ $file == *.h ]]; then headers=yes; else sources+=("$file"); fi ;;
      from) from=$value ;;
      to | to:)
        [[ $key == to: ]] && value=
        replace "$file" "$from" "$value" >why || { echo "ERROR $name: $(cat why)" >"$verdict"; return; } ;;
      test) test=$value ;;
      case) cases=$value ;;
      *) echo "ERROR $name: unknown key '$key'" >"$verdict"; return ;;
    esac
  done
  mkdir objects && cp "$work/unbroken/objects/"*.cpp.o objects
  local test_object=$work/unbroken/$test.o
  if [[ $headers == yes ]]; then
    test_object=$copy/test.o
    { objects_of objects && compile "tests/remap/$test" "$test_object"; } 2>why
  else
    for file in "${sources[@]}"; do compile "$file" "objects/$(basename "$file").o" || break; done 2>why
  fi || { echo "ERROR $name does not compile: $(head -3 why)" >"$verdict"; return; }
  link objects "$test_object" 2>why || { echo "ERROR $name does not link: $(head -3 why)" >"$verdict"; return; }
  timeout 120 objects/test --abort "$cases" >out 2>&1
  local code=$?
  if [[ $code == 0 ]]; then echo "SURVIVED $name: $test: $cases" >"$verdict"
  else echo "killed $name: $test: $(grep -m1 FAILED: out | sed 's/.*remap\///')" >"$verdict"; fi
  rm -rf "$copy"
}

# Blocks are separated by blank lines; the first line of each is its name.
names=() blocks=()
while IFS= read -r line || [[ -n $line ]]; do
  [[ $line == \#* ]] && continue
  if [[ -z $line ]]; then in_block=no
  elif [[ ${in_block:-no} == no ]]; then names+=("$line"); blocks+=(""); in_block=yes
  else blocks[-1]+=$line$'\n'; fi
done <"$list"

mkdir -p "$work/unbroken/objects" "$work/unbroken/clock" "$work/unbroken/tests"
cp -r "$source_dir/remap" "$work/unbroken"
cp -r "$source_dir/clock/time" "$work/unbroken/clock"
cp -r "$source_dir/tests/remap" "$work/unbroken/tests"
cd "$work/unbroken" || exit 1
jobs=${JOBS:-$(nproc)}
mapfile -t tests < <(sed -n 's/^test: //p' "$list" | sort -u)
for test in "${tests[@]}"; do
  while [[ $(jobs -rp | wc -l) -ge $jobs ]]; do wait -n; done
  compile "tests/remap/$test" "$work/unbroken/$test.o" &
done
objects_of objects || exit 1
wait
status=0
# The unbroken source must pass every case, and every case must exist.
while IFS=$'\t' read -r test cases; do
  link objects "$test.o" || exit 1
  objects/test "$cases" >out 2>&1 || { echo "ERROR the unbroken source fails $test: $cases"; tail -20 out; status=1; }
  grep -q "No test cases matched\|No tests ran" out && { echo "ERROR no such case in $test: $cases"; status=1; }
done < <(sed -n 's/^test: //p; s/^case: /\t/p' "$list" | paste -d '' - - | sort -u)

for i in "${!names[@]}"; do
  [[ -n ${MUTATION:-} && ${names[i]} != "$MUTATION" ]] && continue
  while [[ $(jobs -rp | wc -l) -ge $jobs ]]; do wait -n; done
  mapfile -t lines < <(printf '%s' "${blocks[i]}")
  mutate "${names[i]}" "${lines[@]}" &
done
wait
cat "$work"/*.verdict
killed=$(cat "$work"/*.verdict | grep -c '^killed')
total=$(ls "$work"/*.verdict | wc -l)
echo "$killed of $total mutations killed"
[[ $killed == "$total" && $status == 0 ]]
