#!/usr/bin/env bash
# mutation_check.sh SOURCE_DIR WORK_DIR [CMAKE_ARGUMENT...] : breaks the sources on purpose, by one mutation of mutations.txt
# at a time, builds the test program that is expected to notice, runs its named cases, and reports killed or survived. Exit 1
# if a mutation survived, does not compile, or no longer matches the source, or if the cases fail on the unbroken source.
# mutation_check.sh SOURCE_DIR --texts [BUILD_DIR] : builds nothing; checks in seconds whether each mutation still matches
# the source, and whether the tests that are named with it are among those of the build.
# MUTATION=PATTERN: only mutations whose names match (such as 'judge-*'). JOBS=N: N jobs at a time (default: one per core).
#
# Each job has a copy of the source tree under WORK_DIR with a build folder in it. Both are kept, so that nothing is built
# twice. A later run writes only files that differ from the source.
set -uo pipefail
source_dir=$(readlink -f "$1")
list=$source_dir/tests/mutation/mutations.txt

# copy_tree TREE : makes the tree equal to the source again. Only files that differ are written, and so are built again.
copy_tree() {
  local file
  find "$source_dir" -path "$work" -prune -o -path "$source_dir/build*" -prune -o -name .git -prune -o \
    -type f -printf '%P\n' | sort >"$1/files.new"
  if [[ -e $1/files ]]; then comm -23 "$1/files" "$1/files.new" | (cd "$1" && xargs -r -d '\n' rm -f --); fi
  mv "$1/files.new" "$1/files"
  while IFS= read -r file; do
    cmp -s "$source_dir/$file" "$1/$file" || { mkdir -p "$1/$(dirname "$file")" && cp "$source_dir/$file" "$1/$file"; }
  done <"$1/files"
}

# replace FILE FROM TO : replaces a literal text that must occur exactly once. Perl is a part of every Debian; bash itself
# would search ten times as long.
replace() {
  FROM=$2 TO=$3 perl -0777 -we '
    my ($file, $from) = ($ARGV[0], $ENV{FROM});
    open(my $in, "<", $file) or die "$file: $!\n";
    my $text = <$in>;
    my $at = index($text, $from);
    die "no such text in $file: $from\n" if $at < 0;
    die "more than one such text in $file: $from\n" if index($text, $from, $at + 1) >= 0;
    substr($text, $at, length $from) = $ENV{TO};
    open(my $out, ">", $file) or die "$file: $!\n";
    print $out $text;' "$1" 2>&1
}

# value BLOCK KEY : the last value of the key
value() { sed -n "s/^$2: //p" <<<"$1" | tail -1; }

build_test() { ninja -C build -j "$build_jobs" "test_$1" >build.log 2>&1; }
run_test() {
  local program
  program=build/$(ninja -C build -t query "test_$1" | sed -n '/input:/{n; s/^ *//p; q}')
  POCL_CACHE_DIR=$PWD/build/pocl-cache timeout --signal=KILL 300 "$program" --abort "$2" >test.log 2>&1
}

# apply BLOCK : changes the copy; the files that it names are in `changed`
apply() {
  local line file='' from=''
  while IFS= read -r line; do
    case $line in
      'file: '*) file=${line#*: }; changed+=("$file") ;;
      'from: '*) from=${line#*: } ;;
      'to: '* | to:) line=${line#to:}; replace "$file" "$from" "${line# }" || return 1 ;;
      'test: '* | 'case: '* | '') ;;
      *) echo "unknown line '$line'"; return 1 ;;
    esac
  done <<<"$1"
}

# mutate NAME BLOCK : breaks the copy in the working directory and prints the verdict
mutate() {
  local name=$1 block=$2 test cases code file changed=()
  test=$(value "$block" test) cases=$(value "$block" case)
  if ! apply "$block" >why.log; then echo "ERROR $name: $(cat why.log)"
  elif ! build_test "$test"; then
    if grep -qE 'static(_assert| assertion) failed' build.log; then echo "killed $name: $test: a static assertion"
    else echo "ERROR $name is not built: $(grep -m2 'error' build.log || tail -2 build.log)"; fi
  else
    run_test "$test" "$cases"
    code=$?
    case $code in
      0) echo "SURVIVED $name: $test: $cases" ;;
      137) echo "killed $name: $test: does not end" ;;
      *) echo "killed $name: $test: $(grep -m1 'FAILED:' test.log | sed 's/.*tests\///' || true)" ;;
    esac
  fi
  for file in "${changed[@]}"; do cp "$source_dir/$file" "$file"; done
}

# unbroken BLOCK... : the source itself must pass every case, and every case must exist
unbroken() {
  local block test cases
  for block in "$@"; do printf '%s\t%s\n' "$(value "$block" test)" "$(value "$block" case)"; done | sort -u |
    while IFS=$'\t' read -r test cases; do
      build_test "$test" || { echo "ERROR test_$test is not built: $(tail -2 build.log)"; continue; }
      run_test "$test" "$cases" || echo "ERROR the unbroken source fails $test: $cases: $(grep -m1 'FAILED:' test.log)"
      if grep -q 'No test cases matched\|No tests ran' test.log; then echo "ERROR no such case in $test: $cases"; fi
    done
}

# job NUMBER FIRST END : the mutations from FIRST to before END, one after the other
job() {
  local i tree=$work/job-$1
  mkdir -p "$tree" && cd "$tree" && copy_tree "$tree" || return
  [[ -e build/build.ninja ]] || cmake -S . -B build -G Ninja "${configure[@]}" >configure.log 2>&1 ||
    { echo "ERROR cannot configure: $(tail -3 configure.log)"; return; }
  unbroken "${blocks[@]:$2:$3-$2}"
  for ((i = $2; i < $3; ++i)); do mutate "${names[i]}" "${blocks[i]}"; done
}

# Blocks are separated by blank lines; the first line of each is its name.
names=() blocks=() in_block=no
while IFS= read -r line || [[ -n $line ]]; do
  [[ $line == \#* ]] && continue
  if [[ -z $line ]]; then in_block=no
  elif [[ $in_block == no ]]; then
    in_block=yes
    # shellcheck disable=SC2053  # a pattern
    if [[ $line == ${MUTATION:-*} ]]; then names+=("$line"); blocks+=(""); else in_block=skip; fi
  elif [[ $in_block == yes ]]; then blocks[-1]+=$line$'\n'; fi
done <"$list"
total=${#names[@]}
((total > 0)) || { echo "no mutation is called ${MUTATION:-anything}"; exit 2; }

# has_cases BLOCK : whether each of its cases is a test of its program, as ctest lists them in `listed`
has_cases() {
  local test cases one
  test=$(value "$1" test)
  IFS=, read -ra cases <<<"$(value "$1" case)"
  for one in "${cases[@]}"; do
    # shellcheck disable=SC2053  # a pattern
    while IFS= read -r name; do [[ ${name#"$test:"} == ?(' ')$one ]] && continue 2; done < <(grep "^$test:" <<<"$listed")
    echo "no such case in $test: $one"
    return 1
  done
}

if [[ $2 == --texts ]]; then
  status=0
  if [[ ${3-} ]]; then
    listed=$(ctest --test-dir "$3" -N | sed -n 's/^ *Test *#[0-9]*: //p')
    for i in "${!names[@]}"; do has_cases "${blocks[i]}" || { echo "ERROR ${names[i]}"; status=1; }; done
  fi
  cd "$source_dir" && copy=$(mktemp -d "${TMPDIR:-/tmp}/evenstep-mutation-XXXXXX") || exit 2
  trap 'rm -rf "$copy"' EXIT
  for i in "${!names[@]}"; do
    (
      changed=()
      mapfile -t files < <(sed -n 's/^file: //p' <<<"${blocks[i]}" | sort -u)
      cp --parents -- "${files[@]}" "$copy" && cd "$copy" && apply "${blocks[i]}"
    ) || { echo "ERROR ${names[i]}"; status=1; }
  done
  echo "$total mutations"
  exit $status
fi
mkdir -p "$2" || exit 2
work=$(readlink -f "$2")
configure=("${@:3}")
rm -rf "$work/verdicts" && mkdir "$work/verdicts" || exit 2

# Neighbours in the list share a test program, so each job takes a contiguous part of the list.
jobs=${JOBS:-$(nproc)}
((jobs <= total)) || jobs=$total
build_jobs=$((($(nproc) + jobs - 1) / jobs))
for ((k = 0; k < jobs; ++k)); do
  job "$k" $((total * k / jobs)) $((total * (k + 1) / jobs)) 2>&1 | tee "$work/verdicts/$k" &
done
wait
killed=$(cat "$work"/verdicts/* | grep -c '^killed')
errors=$(cat "$work"/verdicts/* | grep -c '^ERROR')
echo "$killed of $total mutations killed"
((killed == total && errors == 0))
