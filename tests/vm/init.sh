#!/bin/sh
# The guest's first and only process. It loads the kernel's HID modules, runs what is to be tested, and powers off. The test
# reads what is between two marks on the serial line. A live run comes first, because a second boot repeats only that.
export PATH=/bin HOME=/tmp NO_COLOR=1
mount -t proc none /proc
mount -t sysfs none /sys
mount -t devtmpfs none /dev
mount -t tmpfs none /tmp
mount -t debugfs none /sys/kernel/debug
for module in hid hid-generic uhid; do insmod /modules/$module.ko || echo "no module $module"; done
cd /tmp

# live SCENARIO PLAYER ARGUMENT... : the scenario drives the device that the player simulates
live() {
  echo "== $1"
  scenario=$1
  shift
  "$@" >player.log &
  player=$!
  while ! node=$(sed -n 1p player.log 2>/dev/null) || [ -z "$node" ]; do sleep 0.01; done
  evenstep devices
  evenstep run --clock wall --device "$node" --forces "/scenarios/$scenario.toml" --out "$scenario" >run.log 2>&1
  echo "== $scenario: $?"
  cat run.log
  wait $player
  sed -n 2p player.log
  rm player.log
}

echo
live live uhid_player 1000 7 10000
live live-pid uhid_pid_player 5 10000 200 40
echo "== kernel"
test_uhid --use-colour no 2>&1
echo "== kernel: $?"
for module in evdev uinput usb-common usbcore usbhid usbip-core vhci-hcd; do
  insmod /modules/$module.ko || echo "no module $module"
done
live live-evdev uinput_player 8000 10000
live live-evdev-arrival uinput_player 6000 10000
echo "== evdev"
test_evdev --use-colour no 2>&1
echo "== evdev: $?"
echo "== end"
poweroff -f
