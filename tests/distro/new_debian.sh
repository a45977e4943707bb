# shellcheck shell=bash
# A new Debian below the temporary folder, for a test that needs one of its own. The test sources this file and calls:
#   new_debian RELEASE     makes it in $debian, with $work as the folder of the test; both go at the end of the test. Exit
#                          status 77 where that cannot be made: it needs root, debootstrap, a network, and minutes
#   within COMMAND...      runs a command in it
#   quietly COMMAND...     whose output, $work/log, is shown only if it fails
#   try_packages           installs the packages of evenstep that are in its folder /packages, uses and removes them
#   trace_hashes FOLDER    the trace hash of each run below this folder, which may be outside of it
skip() { printf 'skipped: %s\n' "$*"; exit 77; }
fail() { printf 'FAILED: %s\n' "$*"; exit 1; }
quietly() { "$@" >"$work/log" 2>&1 || { tail -n 60 -- "$work/log"; fail "$*"; }; }

new_debian() {
  local release=$1 mirror cache=/var/cache/apt/archives   # packages that this machine has downloaded already
  (($(id -u) == 0)) || skip "only root can make a Debian of its own"
  command -v debootstrap >/dev/null || skip "debootstrap is not installed"
  # Where this machine gets its own packages from.
  mirror=$(apt-get indextargets --format '$(REPO_URI) $(LABEL) $(COMPONENT)' 'Created-By: Packages' 2>/dev/null |
    sed -n 's/ Debian main$//p' | head -1)
  [[ $mirror ]] || skip "this machine has no package source of Debian"

  work=$(mktemp -d "${TMPDIR:-/tmp}/evenstep-debian-XXXXXX")
  debian=$work/debian
  trap remove_debian EXIT
  debootstrap --variant=minbase --cache-dir="$cache" "$release" "$debian" "$mirror" >"$work/log" 2>&1 ||
    { tail -n 5 -- "$work/log"; skip "debootstrap could not make a Debian ($release): is there a network?"; }
  cp -l -- "$cache"/*.deb "$debian/var/cache/apt/archives/" 2>/dev/null || true
  cp -L /etc/resolv.conf "$debian/etc/" 2>/dev/null || true
  apt-config dump | grep -iE '^Acquire::[a-z]+::Proxy ' >"$debian/etc/apt/apt.conf.d/proxy" || true
  # A mirror of testing may be older than its lists say that they are good for.
  echo 'Acquire::Check-Valid-Until "false";' >>"$debian/etc/apt/apt.conf.d/proxy"
  # PoCL looks for processors and memory there, and some tests need a terminal.
  mount -t proc proc "$debian/proc" && mount -t sysfs -o ro sysfs "$debian/sys" &&
    mount -t devpts -o newinstance,ptmxmode=0666 devpts "$debian/dev/pts" || skip "proc, sys or devpts cannot be mounted"
}

remove_debian() {
  local folder
  for folder in proc sys dev/pts; do
    if mountpoint -q "$debian/$folder"; then umount "$debian/$folder"; fi
  done
  rm -rf -- "$work"
}

within() {
  chroot "$debian" env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"
}

trace_hashes() { (cd -- "$1" && grep -ro '"trace_hash":"[0-9a-f]*"' --include=summary.json . | LC_ALL=C sort); }

try_packages() {
  local package names
  ls -- "$debian"/packages/*.deb
  for package in "$debian"/packages/*.deb; do
    dpkg-deb --field "$package" Package Version Depends Recommends Installed-Size
  done
  # The packages' dependencies are installed first, so that after removal exactly what the packages brought must be gone.
  quietly within sh -c 'apt-get install -y --no-install-recommends g++ cmake ninja-build ocl-icd-libopencl1 pocl-opencl-icd \
    libhidapi-hidraw0 $(dpkg-deb --field /packages/evenstep_*.deb Depends | sed "s/([^)]*)//g; s/,/ /g") \
    $(dpkg-deb --field /packages/libevenstep-dev_*.deb Depends | sed "s/([^)]*)//g; s/,/ /g") \
    $(for package in /packages/python3-evenstep_*.deb; do [ ! -e "$package" ] ||
      dpkg-deb --field "$package" Depends | sed "s/([^)]*)//g; s/,/ /g"; done)'
  files_of_debian >"$work/before"
  quietly within sh -c 'apt-get install -y /packages/*.deb'
  quietly within sh -c 'cd /root && evenstep run scenarios/paper/figure-1.toml'
  grep PASS "$work/log" || fail "Figure 1 has no verdict"
  names=(evenstep libevenstep-dev)
  if compgen -G "$debian/packages/python3-evenstep_*.deb" >/dev/null; then
    names+=(python3-evenstep)
    quietly within python3 -B -c 'import evenstep
assert evenstep.run("/usr/share/evenstep/scenarios/paper/figure-1-spring.toml").ok'
  fi
  tar -C "$source_dir" -c examples/scheduler | within tar -C /root -x
  quietly within sh -c 'cd ~/examples/scheduler && cmake -G Ninja -B build && cmake --build build &&
    ctest --test-dir build'
  quietly within apt-get purge -y "${names[@]}"
  files_of_debian >"$work/after"
  diff -- "$work/before" "$work/after" || fail "the packages leave files behind (> new)"
  echo "installed, ran Figure 1, served a consumer, removed"
}
files_of_debian() {
  local folder elsewhere=()
  for folder in packages proc root srv sys tmp; do elsewhere+=(-path "./$folder" -o); done
  (cd -- "$debian" && find . \( "${elsewhere[@]}" -path ./var \) -prune -o -print | sort)
}
