#!/usr/bin/env bash
# arm64_test.sh SOURCE_DIR BUILD_DIR : cross-compiles the committed state for arm64 in a new Debian 12, and runs it there in
# an emulator. The tests of what computes must pass, and the scenarios of the paper and of timing, on the cpu solver, must
# have the trace hashes that the program of BUILD_DIR gives them on this machine. Exit status 77 where such a Debian cannot
# be made.
# EVENSTEP_SCENARIOS=paper/ties.toml : these scenarios, in place of all
set -euo pipefail
source_dir=$1 build_dir=$2
source "$source_dir/tests/distro/new_debian.sh"
scenarios=(${EVENSTEP_SCENARIOS-paper timing})
on_cpu=(run --set scene.solver=cpu)
rooms=(clock remap scheduler text format sim)

new_debian bookworm
within dpkg --add-architecture arm64
quietly within apt-get update
# Who builds needs programs of this machine; what is built needs libraries of the other one. PoCL brings a linker of the
# other one, which takes the place of the cross compiler's, and which the emulator cannot start.
mapfile -t libraries < <(sed -E 's/[[:space:]]*([#|].*)?$//; /^(g\+\+|cmake|ninja-build|pocl-opencl-icd)?$/d; s/$/:arm64/' \
  "$source_dir/scripts/packages.txt")
quietly within apt-get install -y --no-install-recommends g++ cmake ninja-build git python3 pkg-config \
  g++-aarch64-linux-gnu qemu-user "${libraries[@]}" catch2:arm64 libumockdev-dev:arm64
git clone -q -- "$source_dir" "$debian/srv/evenstep"

start=$SECONDS
quietly within sh -c "cd /srv/evenstep && cmake --preset release -D CMAKE_TOOLCHAIN_FILE=cmake/aarch64-linux-gnu.cmake \
  -D EVENSTEP_BUILD_TESTS=ON -D EVENSTEP_BUILD_BENCH=OFF && cmake --build build --target evenstep test_sim_environment \
  ${rooms[*]/#/test_}"
! grep 'warning: ' "$work/log" || fail "the build warns"
echo "build: $((SECONDS - start)) s"

# What asks for OpenCL has none.
start=$SECONDS
joined=${rooms[*]}
within ctest --test-dir /srv/evenstep/build -R "^(${joined// /|}):" --no-tests=error -LE '^(long|million|real|sweep)$' \
  -j "$(nproc)" >"$work/log" 2>&1 ||
  grep -q 'The following tests FAILED' "$work/log" || { tail -n 60 -- "$work/log"; fail "ctest"; }
awk '/^[0-9]+\/[0-9]+ Testing: / { name = $0; is_opencl = 0 }
  /no OpenCL platform is installed/ { is_opencl = 1 }
  /^Test Passed\./ { ++passed }
  /^(Test Failed|Test timed out|Test not run)/ { if (is_opencl) ++without; else { print "FAILED " name; bad = 1 } }
  END { print passed + 0 " tests pass, " without + 0 " ask for OpenCL"; exit bad || passed < 400 }' \
  "$debian/srv/evenstep/build/Testing/Temporary/LastTest.log" || fail "tests fail on arm64"
echo "tests: $((SECONDS - start)) s"

start=$SECONDS
quietly within sh -c "cd /srv/evenstep/scenarios &&
  qemu-aarch64 ../build/apps/evenstep ${on_cpu[*]} ${scenarios[*]} --out /srv/runs"
(cd -- "$source_dir/scenarios" && quietly "$build_dir/apps/evenstep" "${on_cpu[@]}" "${scenarios[@]}" --out "$work/runs")
trace_hashes "$work/runs" >"$work/hashes"
diff -- "$work/hashes" <(trace_hashes "$debian/srv/runs") || fail "other trace hashes (> arm64)"
echo "$(wc -l <"$work/hashes") trace hashes are the same: $((SECONDS - start)) s"
