#!/usr/bin/env bash
# without_build.sh SOURCE_DIR BUILD_DIR : builds the program with all options off, which takes minutes, and runs
# without_test.sh on it. In the other tests without_test.sh gets a program whose libraries do contain what is refused, so it
# would not notice if a function were missing.
set -euo pipefail
source_dir=$1 build_dir=$2
off=()
for option in OPENCL HIDAPI INVERSE3 DRAW PROFILES SCOPE BUILD_TESTS BUILD_BENCH; do off+=(-D "EVENSTEP_$option=OFF"); done
cmake -S "$source_dir" -B "$build_dir" -G Ninja -D CMAKE_BUILD_TYPE=Release -D CMAKE_UNITY_BUILD=ON "${off[@]}"
cmake --build "$build_dir" --target evenstep
bash "$source_dir/tests/install/without_test.sh" "$build_dir/apps/evenstep" "$source_dir"
