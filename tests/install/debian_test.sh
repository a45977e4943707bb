#!/usr/bin/env bash
# debian_test.sh SOURCE_DIR BUILD_DIR : makes the Debian packages of the build, and installs, uses and removes them in a new
# Debian 12 below the temporary folder. Exit status 77 where that cannot be made: it needs root, debootstrap and a network,
# and minutes for the download. debian_test.sh commands : prints how the packages are made, as in docs/install.md
set -euo pipefail
commands=$'cmake --preset release\ncmake --build build\ncpack --config build/CPackConfig.cmake -B packages'
if [[ $1 == commands ]]; then
  printf '%s\n' "$commands"
  exit
fi
source_dir=$1 build_dir=$2
skip() { printf 'skipped: %s\n' "$*"; exit 77; }
fail() { printf 'FAILED: %s\n' "$*"; exit 1; }
quietly() { "$@" >"$work/log" 2>&1 || { tail -n 60 -- "$work/log"; fail "$*"; }; }

(($(id -u) == 0)) || skip "only root can make a Debian of its own"
command -v debootstrap >/dev/null || skip "debootstrap is not installed"
# Where this machine gets its own packages from.
mirror=$(apt-get indextargets --format '$(REPO_URI) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' 2>/dev/null |
  sed -n 's/ bookworm main$//p' | head -1)
[[ $mirror ]] || skip "this machine has no package source of Debian 12 (bookworm)"

work=$(mktemp -d "${TMPDIR:-/tmp}/evenstep-debian-XXXXXX")
debian=$work/debian
clean_up() {
  local folder
  for folder in proc sys; do
    if mountpoint -q "$debian/$folder"; then umount "$debian/$folder"; fi
  done
  rm -rf -- "$work"
}
trap clean_up EXIT
cache=/var/cache/apt/archives   # packages that this machine has downloaded already
debootstrap --variant=minbase --cache-dir="$cache" bookworm "$debian" "$mirror" >"$work/log" 2>&1 ||
  { tail -n 5 -- "$work/log"; skip "debootstrap could not make a Debian 12: is there a network?"; }
cp -l -- "$cache"/*.deb "$debian/var/cache/apt/archives/" 2>/dev/null || true
cp -L /etc/resolv.conf "$debian/etc/" 2>/dev/null || true
apt-config dump | grep -iE '^Acquire::[a-z]+::Proxy ' >"$debian/etc/apt/apt.conf.d/proxy" || true
# PoCL looks for processors and memory there.
mount -t proc proc "$debian/proc" && mount -t sysfs -o ro sysfs "$debian/sys" || skip "proc and sys cannot be mounted"
environment=(env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive)
within() { chroot "$debian" "${environment[@]}" "$@"; }

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
