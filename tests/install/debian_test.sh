#!/usr/bin/env bash
# debian_test.sh SOURCE_DIR BUILD_DIR : makes the Debian packages of the build, and installs, uses and removes them in a new
# Debian of this machine's release (tests/distro/new_debian.sh). debian_test.sh commands : prints how the packages are made,
# as in docs/install.md
set -euo pipefail
commands=$'cmake --preset release\ncmake --build build\ncpack --config build/CPackConfig.cmake -B packages'
if [[ $1 == commands ]]; then
  printf '%s\n' "$commands"
  exit
fi
source_dir=$1 build_dir=$2
source "$source_dir/tests/distro/new_debian.sh"
new_debian "$(. /etc/os-release && echo "$VERSION_CODENAME")"

cpack_command=$(tail -1 <<<"$commands")
cpack_command=${cpack_command/build\//$build_dir/}
quietly ${cpack_command/packages/$debian/packages}
ls -- "$debian"/packages/*.deb
for package in "$debian"/packages/*.deb; do
  dpkg-deb --field "$package" Package Version Depends Recommends Installed-Size
done
listing() {
  local elsewhere='-path ./proc -o -path ./sys -o -path ./packages -o -path ./var -o -path ./root -o -path ./tmp'
  (cd -- "$debian" && find . \( $elsewhere \) -prune -o -print | sort)
}

quietly within apt-get update
# The packages' dependencies are installed first, so that after removal exactly what the packages brought must be gone.
quietly within sh -c 'apt-get install -y --no-install-recommends g++ cmake ninja-build ocl-icd-libopencl1 pocl-opencl-icd \
  libhidapi-hidraw0 $(dpkg-deb --field /packages/evenstep_*.deb Depends | sed "s/([^)]*)//g; s/,/ /g") \
  $(dpkg-deb --field /packages/libevenstep-dev_*.deb Depends | sed "s/([^)]*)//g; s/,/ /g")'
listing >"$work/before"
quietly within sh -c 'apt-get install -y /packages/*.deb'
quietly within sh -c 'cd /root && evenstep run scenarios/paper/figure-1.toml'
grep PASS "$work/log" || fail "Figure 1 has no verdict"
tar -C "$source_dir" -c examples/scheduler | within tar -C /root -x
quietly within sh -c 'cd ~/examples/scheduler && cmake -G Ninja -B build && cmake --build build &&
  ctest --test-dir build'
quietly within apt-get purge -y evenstep libevenstep-dev
listing >"$work/after"
diff -- "$work/before" "$work/after" || fail "the packages leave files behind (> new)"
echo "installed, ran Figure 1, served a consumer, removed"
