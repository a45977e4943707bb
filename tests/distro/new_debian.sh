# shellcheck shell=bash
# A new Debian below the temporary folder, for a test that needs one of its own. The test sources this file and calls:
#   new_debian RELEASE     makes it in $debian, with $work as the folder of the test; both go at the end of the test. Exit
#                          status 77 where that cannot be made: it needs root, debootstrap, a network, and minutes
#   within COMMAND...      runs a command in it
#   quietly COMMAND...     whose output, $work/log, is shown only if it fails
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
