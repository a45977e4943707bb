#!/bin/sh
# The guest's first and only process: loads the kernel's HID modules, runs what is to be tested, powers off. The test reads the
# serial line: everything between two marks.
export PATH=/bin HOME=/tmp NO_COLOR=1
mount -t proc none /proc
mount -t sysfs none /sys
mount -t devtmpfs none /dev
mount -t tmpfs none /tmp
mount -t debugfs none /sys/kernel/debug
for module in hid hid-generic uhid; do insmod /modules/$module.ko || echo "no module $module"; done
cd /tmp
echo; echo "== kernel"
test_uhid --use-colour no 2>&1
echo "== kernel: $?"
echo "== live"
uhid_player 1000 12 10000 > player.log &
player=$!
while ! node=$(sed -n 1p player.log) || [ -z "$node" ]; do sleep 0.01; done
evenstep devices
evenstep run --clock wall --device "$node" --forces /scenarios/live.toml --out run >run.log 2>&1
echo "== live: $?"
cat run.log
wait $player
sed -n 2p player.log
echo "== end"
poweroff -f
