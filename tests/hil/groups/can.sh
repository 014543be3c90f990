#!/usr/bin/env bash
# SocketCAN on the kernel's virtual bus, with can-utils as the peer.
set -euo pipefail
source tests/hil/guest.sh
modprobe -a can-raw vcan
ip link add dev vcan0 type vcan
ip link set vcan0 up

say "can-utils hear each other on vcan0"
candump -L -n 2 -T 5000 vcan0 >/tmp/heard &
listener=$!
wait_for "the listener's socket" grep -q '^ *vcan0' /proc/net/can/rcvlist_all
cansend vcan0 123#1122334455667788
cansend vcan0 7FF#
wait "$listener"
expect_equal "$(awk '{ print $3 }' /tmp/heard)" $'123#1122334455667788\n7FF#'

HEADWAY_CAN=vcan0 run_tests hil_can_tests
