#!/usr/bin/env bash
# boot.sh FOLDER SCENARIOS PROGRAM... : boots a Debian kernel in qemu twice, with these programs in it and init.sh as its
# only process. It needs no root, and the guest has no network. qemu derives time from the number of instructions (-icount),
# so guest time does not depend on how busy this machine is, and sleeping costs nothing.
#
# The first boot does everything. FOLDER/1.log has all that it printed. The next one ends after the first live run.
# FOLDER/live.log and FOLDER/2.log have what the last two boots printed about that run.
#
# Prints "skipped: REASON" where a program or the kernel cannot be had. The kernel package is downloaded once
# (70 MB) and kept.
set -euo pipefail
here=$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")
folder=$1 scenarios=$2
shift 2
skip() { printf 'skipped: %s\n' "$*"; exit 0; }

for program in qemu-system-x86_64 busybox cpio xz dpkg-deb ldd; do
  command -v "$program" >/dev/null ||
    skip "$program is not installed (.ci/packages.txt lists what the virtual machine needs)"
done
mkdir -p -- "$folder"
cd -- "$folder"

# --- the kernel: an uncompressed image boots in half the time
# A folder from an earlier version has fewer modules.
if [[ ! -s kernel/vmlinux || -z $(find kernel/lib -name vhci-hcd.ko 2>/dev/null) ]]; then
  mkdir -p kernel
  name=$(apt-cache depends linux-image-amd64 2>/dev/null | sed -nE 's/^ *Depends: (linux-image-[^ ]*)$/\1/p' | head -n 1)
  [[ -n $name ]] || skip "apt knows no linux-image-amd64 (run apt-get update)"
  (cd kernel && apt-get download "$name" >/dev/null 2>download.log) ||
    skip "the kernel package $name cannot be downloaded: $(tail -n 1 kernel/download.log)"
  rm -rf kernel/boot kernel/lib
  dpkg-deb --fsys-tarfile kernel/"$name"_*.deb |
    tar -x -C kernel --wildcards './boot/vmlinuz*' '*/hid/hid.ko' '*/hid/uhid.ko' '*/hid/hid-generic.ko' \
      '*/input/evdev.ko' '*/misc/uinput.ko' '*/usb/common/usb-common.ko' '*/usb/core/usbcore.ko' '*/usbhid/usbhid.ko' \
      '*/usbip/usbip-core.ko' '*/usbip/vhci-hcd.ko'
  offset=$(LC_ALL=C grep -abo -m1 $'\xfd7zXZ' kernel/boot/vmlinuz* | head -n 1 | cut -d: -f1)
  # xz complains about the bytes after its stream.
  tail -c +$((offset + 1)) kernel/boot/vmlinuz* | xz -dc >kernel/vmlinux.new 2>/dev/null || [[ -s kernel/vmlinux.new ]]
  rm -f kernel/*.deb
  mv kernel/vmlinux.new kernel/vmlinux
fi

# --- its root: busybox, our programs, and the libraries that they name
rm -rf root
mkdir -p root/{bin,proc,sys,dev,tmp,modules,scenarios}
cp "$(command -v busybox)" root/bin/busybox
for tool in sh cat mount insmod rm sed sleep poweroff; do ln -s busybox "root/bin/$tool"; done
find kernel/lib -name '*.ko' -exec cp -t root/modules {} +
cp -- "$here/init.sh" root/init
chmod +x root/init
cp -- "$here"/live{,-common,-pid,-evdev,-evdev-arrival}.toml root/scenarios/
sed 's#\.\./paper/#paper-#' "$scenarios/live/figure-1-spring.toml" >root/scenarios/figure-1-spring.toml
cp -- "$scenarios/paper/figure-1-spring.toml" root/scenarios/paper-figure-1-spring.toml
# libraries_of FILE : the shared libraries that it is linked with
libraries_of() { ldd "$1" 2>/dev/null | grep -oE '/[^ ]+'; }
# This library is opened at run time, so no program names it.
hidapi=$(PATH=$PATH:/usr/sbin:/sbin ldconfig -p | sed -nE 's,.*libhidapi-hidraw\.so\.0 .*=> (/.*),\1,p' | head -n 1)
[[ $hidapi ]] || { echo "libhidapi-hidraw.so.0 is not installed" >&2; exit 1; }
while read -r library; do
  mkdir -p "root$(dirname "$library")"
  cp -L -n "$library" "root$library"
done < <(echo "$hidapi"; for file in "$hidapi" "$@"; do libraries_of "$file"; done)
cp -- "$@" root/bin/
for program in root/bin/*; do [[ -L $program ]] || strip --strip-debug "$program" 2>/dev/null || true; done
(cd root && find . | LC_ALL=C sort | cpio --quiet -o -H newc --reproducible | gzip -1 -n) >initrd.gz

# --- boots twice, or up to four times until two boots in a row say the same about that run: on a busy machine qemu's
# instruction clock can shift by microseconds. The serial line is a file, because a full pipe would stop the guest.

# boot MARK LOG : boots and waits until the guest has printed the mark
boot() {
  : >serial.log
  timeout 600 qemu-system-x86_64 -M pc -accel tcg -cpu qemu64 -smp 1 -m 512 -display none -monitor none -nodefaults \
    -serial file:serial.log -no-reboot -icount shift=1,sleep=off -rtc base=2024-01-01T00:00:00,clock=vm \
    -kernel kernel/vmlinux -initrd initrd.gz \
    -append "console=ttyS0 loglevel=1 panic=-1 nokaslr random.trust_cpu=off" </dev/null 2>qemu.log &
  local qemu=$!
  while kill -0 "$qemu" 2>/dev/null && ! grep -q "^== $1" serial.log; do sleep 0.2; done
  kill "$qemu" 2>/dev/null || true
  wait "$qemu" || true
  tr -d '\r' <serial.log | awk -v mark="== $1" '/^== live$/ { said = 1 } said { print } $0 == mark { exit }' >"$2"
  grep -q "^== $1\$" "$2" && return
  cat qemu.log serial.log
  echo "the guest did not come to \"== $1\""
  exit 1
}
rm -f 1.log 2.log
boot end 1.log
sed '/^== live-pid$/q' 1.log >live.log
for boots in 2 3 4; do
  boot live-pid 2.log
  if cmp -s live.log 2.log; then break; fi
  ((boots == 4)) || mv 2.log live.log
done
echo "booted $boots times"
