#!/bin/bash
# Tests what each room may contain: greps the tree for what the compiler cannot refuse.
#
#   room_rules.sh ROOT     lists every violation as file:line: [rule] text; exit 1 if there is any
#
# First every rule is tried on a planted violation and on the same text in a place where it is allowed. If a rule does not
# notice the first or complains about the second, the test fails, too.
set -u -o pipefail
export LC_ALL=C

readonly rooms='clock remap scheduler sim device reports pages text recordings plugins catalogue loop draw harness campaigns
  apps tests bench examples cmake docs scenarios scripts'
readonly posix_clock='clock_gettime|clock_nanosleep|nanosleep|usleep'
readonly std_clock='steady_clock|system_clock|high_resolution_clock'
# A clock of evenstep has a sleep_until(), too (scheduler/blocking_clock.h), so those of std are recognized by their
# namespace.
readonly std_sleep='\bthis_thread::sleep_(for|until)\b|\bnamespace\b.*\bthis_thread\b'
readonly os_clock="\b($posix_clock|$std_clock)\b|$std_sleep"
readonly threads='\b(std::(jthread|thread|async)|pthread_create)\b'
readonly foreign_random='\bstd::([a-z_]+_distribution|random_device)\b|\brand *\('
readonly processes='\b(v?fork|posix_spawnp?|exec[vl][pe]*|popen|std::system) *\('
readonly fast_math='-ffast-math|-Ofast|-funsafe-math|-fassociative-math|-cl-fast-relaxed-math|-cl-unsafe-math'
readonly source='\.(h|hpp|cpp|cl|cl\.h)$'
readonly with_threads='scheduler/src/(live_lanes|parallel_for)|reports/src/row_files|bench/(device_tick|own_lane)'\
'|device/src/live_sender|device/src/inverse3/inverse3_socket|tests/|examples/'
readonly sockets='# *include *[<"](boost/(asio|beast)|sys/socket)'
readonly with_sockets='device/src/inverse3/inverse3_socket|apps/src/scope_server|tests/'
readonly hashed='scheduler|remap|sim|device|reports|pages|text|recordings|plugins|scenarios/format|catalogue|loop|draw'\
'|harness|campaigns'

# name @ which files (regular expression on the path) @ where it is allowed @ what must not be there
# Paths are relative to the root. Line comments are removed first, except for rules that start with "raw ".
readonly rules=(
  "OpenCL only in sim/opencl@$source@^sim/opencl/@# *include *[<\"]CL/"
  "hidapi only in its transport@$source@^(device/src/hid/hidapi_library|tests/fake_hidapi/)@# *include *[<\"]hidapi/"
  "OS clock only in clock@$source@^(clock/|tests/|examples/|bench/device_tick)@$os_clock"
  "threads only in live lanes, parallel loops, row files, senders and two benchmarks@$source@^($with_threads)@$threads"
  "own random numbers@$source@^\$@$foreign_random"
  "no unordered containers where things are hashed@^($hashed)/.*$source@^\$@\bstd::unordered_"
  "public headers keep foreign libraries out@^[a-z/]*include/evenstep/@^\$@# *include *[<\"](CL/|hidapi/|toml|spdlog|boost/)"
  "no fast math@(CMakeLists\.txt|\.cmake|CMakePresets\.json|\.sh|^sim/.*$source)\$@^\$@$fast_math"
  "own loaders only@$source@^(clock/time/src/library_on_demand|plugins/src/library|tests/)@\bdlopen *\("
  "processes only in plugins and of pairs@$source@^(plugins/src/child|campaigns/src/cost_pairs|tests/)@$processes"
  "sockets only in the link to a service and the scope@$source@^($with_sockets)@$sockets"
  "raw no unfinished work@.@^\$@\b(TODO|FIXME|XXX)\b"
  "OpenGL only in draw@$source@^draw/src/@# *include *[<\"](EGL|GLES[0-9]|GL)/"
)

scratch=$(mktemp -d) || exit 2
trap 'rm -rf "$scratch"' EXIT

# tree ROOT: the files that the rules look at. This folder is left out, as it names what it forbids.
tree() {
  (cd "$1" && for top in $rooms CMakeLists.txt CMakePresets.json README.md; do [ -e "$top" ] && find "$top" -type f; done) |
    grep -v '^tests/room_rules/' | sort
}

# strip ROOT: makes a copy of the tree in $scratch/bare without line comments (// in sources, # elsewhere, except for
# #include and the like).
strip() {
  rm -rf "$scratch/bare" && mkdir "$scratch/bare" && (cd "$1" && tree . | xargs -d '\n' -r cp --parents -t "$scratch/bare")
  find "$scratch/bare" -type f -regextype posix-extended -regex '.*\.(h|hpp|cpp|cl)' -exec sed -i 's@//.*@@' {} +
  find "$scratch/bare" -type f \( -name CMakeLists.txt -o -name '*.cmake' -o -name '*.sh' \) -exec sed -i 's@#.*@@' {} +
}

# violations RULE ROOT, after `strip ROOT`
violations() {
  local name files allowed pattern where=$scratch/bare
  IFS='@' read -r name files allowed pattern <<<"$1"
  case $name in raw\ *) where=$2 name=${name#raw } ;; esac
  local found
  found=$(tree "$where" | grep -E "$files" | grep -vE "$allowed" |
    (cd "$where" && xargs -d '\n' -r grep -InHE -- "$pattern"))
  [ -n "$found" ] && sed -E "s@^([^:]*:[0-9]+:)@\1 [$name] @" <<<"$found"
}

# A public header says what it is before anything else.
headers_without_opening() {
  (cd "$1" && tree . | grep -E '^[a-z/]*include/evenstep/.*\.h$' | xargs -d '\n' -r awk '
    FNR == 1 && $0 != "#pragma once" { print FILENAME ":1: [header opening] must be #pragma once" }
    FNR == 2 && !/^\/\/\/ / { print FILENAME ":2: [header opening] must be a /// comment that says what this is" }')
}

# rooms_too_large ROOT: lists rooms with more than a fifth of the product's code, because such a room is several rooms in
# one. Counts lines of $source.
readonly product='clock remap scheduler sim device reports pages text recordings plugins scenarios/format catalogue loop
  draw harness campaigns apps'
rooms_too_large() {
  local room lines total=0
  local -A held=()
  for room in $product; do
    lines=$(cd "$1" && find "$room" -type f 2>/dev/null | grep -E "$source" | xargs -d '\n' -r cat | wc -l)
    held[$room]=$lines total=$((total + lines))
  done
  for room in $product; do
    ((5 * held[$room] <= total)) || echo "$room:1: [size of a room] ${held[$room]} of $total lines: more than a fifth"
  done
}

# names_in_two_rooms ROOT: lists headers that have the name of a header in another room. A reader of `#include "name.h"`
# should not have to ask which header that is.
names_in_two_rooms() {
  local room
  for room in $product; do
    (cd "$1" && find "$room" -name '*.h' -printf "%f $room\n" 2>/dev/null)
  done | sort -u | awk '
    $1 == name { print $2 ":1: [one name, one header] " name " is also in " room }
    { name = $1; room = $2 }'
}

# planted PATH TEXT: a tree with this file only
planted() {
  rm -rf "$scratch/planted" && mkdir -p "$scratch/planted/$(dirname "$1")" && printf '%s\n' "$2" >"$scratch/planted/$1"
  strip "$scratch/planted"
}

failures=0
fail() { echo "room_rules: $1"; failures=$((failures + 1)); }

# expect seen|unseen NUMBER_OF_RULE PATH TEXT
tried=()
expect() {
  local verdict=unseen
  planted "$3" "$4"
  [ -n "$(violations "${rules[$2]}" "$scratch/planted")" ] && verdict=seen
  [ "$verdict" = "$1" ] || fail "rule '${rules[$2]%%@*}' should be $1: $3: $4"
  [ "$1" = seen ] && tried[$2]=1
}

prove_rules() {
  expect seen 0 sim/src/solver.cpp '#include <CL/cl.h>'
  expect seen 0 harness/src/run.cpp '#  include "CL/opencl.hpp"'
  expect unseen 0 sim/opencl/tissue_solver.cpp '#include <CL/cl.h>'
  expect unseen 0 sim/src/solver.cpp '// as #include <CL/cl.h> would'
  expect seen 1 device/src/hid/reference_driver.cpp '#include <hidapi/hidapi.h>'
  expect unseen 1 device/src/hid/hidapi_library.h '#include <hidapi/hidapi.h>'
  local call
  for call in 'clock_gettime(CLOCK_MONOTONIC, &t);' 'clock_nanosleep(0, 0, &t, 0);' 'nanosleep(&t, 0);' \
    'std::chrono::steady_clock::now();' 'std::chrono::system_clock::now();' 'std::chrono::high_resolution_clock::now();' \
    'std::this_thread::sleep_for(t);' 'std::this_thread::sleep_until(t);' 'using std::this_thread::sleep_for;' \
    'using namespace std::this_thread;' 'namespace here = std::this_thread;' 'usleep(1);'; do
    expect seen 2 scheduler/src/scheduler.cpp "$call"
    expect unseen 2 clock/src/wall_clock.cpp "$call"
    expect unseen 2 tests/clock/wall_test.cpp "$call"
    expect unseen 2 examples/embed/embed.cpp "$call"
  done
  expect unseen 2 scheduler/src/stepped_thread.cpp 'clock.sleep_until(at);'
  for call in 'std::thread t(f);' 'std::jthread t(f);' 'std::async(f);' 'pthread_create(&t, 0, f, 0);'; do
    expect seen 3 harness/src/run.cpp "$call"
    expect unseen 3 scheduler/src/parallel_for.cpp "$call"
    expect unseen 3 scheduler/src/live_lanes.cpp "$call"
    expect unseen 3 device/src/live_sender.h "$call"
    expect unseen 3 tests/scheduler/lanes_test.cpp "$call"
    expect unseen 3 examples/embed/embed.cpp "$call"
  done
  expect unseen 3 scheduler/src/scheduler.cpp 'std::this_thread::get_id();'
  for call in 'std::normal_distribution<double> d;' 'std::uniform_int_distribution<int> d;' \
    'std::random_device d;' 'int i = rand();'; do
    expect seen 4 scheduler/src/random.cpp "$call"
    expect seen 4 tests/sim/solver_test.cpp "$call"
  done
  expect unseen 4 scheduler/src/random.cpp 'int i = my_rand();'
  for call in scheduler/src/a.cpp remap/include/evenstep/remap/a.h sim/cpu/a.cpp device/src/hid/a.cpp reports/src/a.cpp \
    text/src/a.cpp recordings/src/a.cpp scenarios/format/src/a.cpp catalogue/src/a.cpp loop/src/a.cpp harness/src/a.cpp \
    campaigns/src/a.cpp; do
    expect seen 5 "$call" 'std::unordered_map<int, int> m;'
  done
  expect unseen 5 apps/main.cpp 'std::unordered_set<int> s;'
  for call in 'CL/cl.h' 'hidapi/hidapi.h' 'toml++/toml.h' 'spdlog/spdlog.h' 'boost/asio.hpp'; do
    expect seen 6 harness/include/evenstep/harness/a.h "#include <$call>"
    expect seen 6 clock/time/include/evenstep/time/a.h "#include <$call>"
    expect unseen 6 harness/src/a.cpp "#include <$call>"
  done
  expect seen 7 CMakeLists.txt 'add_compile_options(-O2 -ffast-math)'
  expect seen 7 cmake/Options.cmake 'set(CMAKE_CXX_FLAGS "-Ofast")'
  expect seen 7 sim/opencl/tissue_solver.cpp 'program.build("-cl-fast-relaxed-math");'
  expect unseen 7 CMakeLists.txt '# without -ffast-math'
  expect seen 8 harness/src/run.cpp 'void* library = dlopen("x.so", RTLD_NOW);'
  expect unseen 8 plugins/src/library.cpp 'dlopen(path, RTLD_NOW);'
  for call in 'pid_t child = fork();' 'execve(program, words, environ);' 'posix_spawn(&child, path, 0, 0, 0, 0);' \
    'popen("ls", "r");' 'std::system("ls");'; do
    expect seen 9 harness/src/run.cpp "$call"
    expect unseen 9 plugins/src/child_start.cpp "$call"
  done
  for call in 'boost/asio/ip/tcp.hpp' 'boost/beast/websocket.hpp' 'sys/socket.h'; do
    expect seen 10 device/src/hid/hidapi_transport.cpp "#include <$call>"
    expect unseen 10 device/src/inverse3/inverse3_socket.cpp "#include <$call>"
  done
  expect unseen 10 reports/src/a.cpp '#include <boost/math/distributions/beta.hpp>'
  local word
  for word in TODO FIXME XXX; do
    expect seen 11 sim/src/solver.cpp "// $word: later"
    expect seen 11 docs/metrics.md "$word"
  done
  expect unseen 11 sim/src/solver.cpp '// MAXXXX'
  expect seen 12 harness/src/visualization.cpp '#include <GLES3/gl3.h>'
  expect unseen 12 draw/src/gl_library.h '#include <EGL/egl.h>'
  local rule
  for rule in "${!rules[@]}"; do
    [ "${tried[$rule]:-0}" = 1 ] || fail "rule '${rules[$rule]%%@*}' has no planted violation"
  done

  planted sim/include/evenstep/sim/a.h $'#pragma once\n/// A thing.'
  [ -z "$(headers_without_opening "$scratch/planted")" ] || fail 'the header rule refuses a good header'
  for word in $'/// A thing.\n#pragma once' $'#pragma once\n#include <a>' $'#ifndef A_H\n/// A thing.'; do
    planted sim/include/evenstep/sim/a.h "$word"
    [ -n "$(headers_without_opening "$scratch/planted")" ] || fail "the header rule does not see: ${word//$'\n'/ | }"
  done
}

prove_sizes() {
  local room
  rm -rf "$scratch/planted"
  for room in $product; do mkdir -p "$scratch/planted/$room" && printf 'a\nb\n' >"$scratch/planted/$room/a.cpp"; done
  [ -z "$(rooms_too_large "$scratch/planted")" ] || fail 'the rule on sizes refuses rooms of equal size'
  printf '%s\n' a b c d e f g h i >"$scratch/planted/sim/a.cpp"
  case $(rooms_too_large "$scratch/planted") in
    sim:*) ;;
    *) fail 'the rule on sizes does not see a room of more than a fifth' ;;
  esac
}

prove_names() {
  planted sim/src/a.h x
  mkdir -p "$scratch/planted/harness/src" && cp "$scratch/planted/sim/src/a.h" "$scratch/planted/sim/b.h"
  [ -z "$(names_in_two_rooms "$scratch/planted")" ] || fail 'the rule on names refuses headers of one room'
  cp "$scratch/planted/sim/src/a.h" "$scratch/planted/harness/src/a.h"
  case $(names_in_two_rooms "$scratch/planted") in
    *a.h*) ;;
    *) fail 'the rule on names does not see two headers of one name' ;;
  esac
}

check_tree() {
  local rule found
  [ "$(tree "$1" | wc -l)" -ge 50 ] || fail "no source tree at $1"
  strip "$1"
  for rule in "${rules[@]}"; do
    found=$(violations "$rule" "$1") && fail $'\n'"$found"
  done
  found=$(headers_without_opening "$1")
  [ -z "$found" ] || fail $'\n'"$found"
  found=$(rooms_too_large "$1")
  [ -z "$found" ] || fail $'\n'"$found"
  found=$(names_in_two_rooms "$1")
  [ -z "$found" ] || fail $'\n'"$found"
}

[ $# -eq 1 ] || { echo 'usage: room_rules.sh ROOT' >&2; exit 2; }
prove_rules
prove_sizes
prove_names
check_tree "$(realpath "$1")"
[ "$failures" -eq 0 ] &&
  echo "room_rules: ${#rules[@]} rules, the header opening, the sizes of the rooms and the names of headers hold"
[ "$failures" -eq 0 ]
