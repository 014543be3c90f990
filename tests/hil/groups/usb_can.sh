#!/usr/bin/env bash
# A USB-CAN adapter. The kernel's own gs_usb drives the emulated one first, which proves the emulation; then Headway's
# transport takes it through libusb.
set -euo pipefail
source tests/hil/guest.sh
modprobe -a can-raw vhci-hcd gs_usb

export HEADWAY_USB_CAN=HEADWAY7 HEADWAY_USB_CAN_COMMANDS=/tmp/adapter

start_adapter() {
  "$build/hil_usb_adapter" --serial "$HEADWAY_USB_CAN" --commands "$HEADWAY_USB_CAN_COMMANDS" >/tmp/adapter_log 2>&1 &
  adapter=$!
}

# Pulls it out for good, and looks whether it was ever told what it cannot use.
end_adapter() {
  kill "$adapter"
  wait "$adapter"
  rm "$HEADWAY_USB_CAN_COMMANDS"
  grep -q 'misused 0$' /tmp/adapter_log || fail "the adapter was used wrongly: $(tail -n 1 /tmp/adapter_log)"
  if grep 'unknown command' /tmp/adapter_log; then fail "the adapter was told what it does not know"; fi
}

tell() {
  echo "$*" >"$HEADWAY_USB_CAN_COMMANDS"
}

there() { [[ -e /sys/class/net/can0 ]]; }
gone() { [[ ! -e /sys/class/net/can0 ]]; }
state_is() { ip -details link show can0 | grep -q "can state $1"; }

# hear COUNT COMMAND...: the next frames on can0, which the command brings about.
hear() {
  local count=$1 listener
  shift
  candump -L -n "$count" -T 5000 can0 >/tmp/heard &
  listener=$!
  wait_for "the listener's socket" grep -q '^ *can0' /proc/net/can/rcvlist_all
  "$@"
  wait "$listener"
  awk '{ print $3 }' /tmp/heard
}

up() {
  wait_for "the kernel to find the adapter" there
  ip link set can0 up type can bitrate 500000
}

say "the kernel's gs_usb drives the adapter"
start_adapter
up
expect_equal "$(lsusb -v -d 1d50:606f 2>/dev/null | awk '/iSerial/ { print $3 }')" "$HEADWAY_USB_CAN"
expect_equal "$(hear 2 cansend can0 123#1122334455667788)" $'123#1122334455667788\n124#1122334455667788'
expect_equal "$(hear 1 tell frame 7FF 0102)" '7FF#0102'

say "headway doctor lists the interface and the adapter behind it"
"$build/headway" doctor config/hrp2/robot.yaml --bus socketcan:can0 >/tmp/doctor || true
grep -q '^warn  can      can0: up, error active, 500000 bit/s, sample point 87.5 %, stays off' /tmp/doctor ||
  fail "$(cat /tmp/doctor)"
grep -q '^ok    can      adapter: emulated candleLight, release 0.00' /tmp/doctor || fail "$(cat /tmp/doctor)"
tell state bus-off
wait_for "bus-off" state_is BUS-OFF
"$build/headway" doctor config/hrp2/robot.yaml --bus socketcan:can0 >/tmp/doctor || true
grep -q '^fail  can      can0: up, off the bus, ' /tmp/doctor || fail "$(cat /tmp/doctor)"
ip link set can0 down
up

say "a thousand frames come back in order"
answers() {
  candump -L -n 1000 -T 20000 can0,201:7FF >/tmp/answers &
  local listener=$!
  wait_for "the listener's socket" grep -q '^ *can0' /proc/net/can/rcvlist_fil /proc/net/can/rcvlist_sff
  cangen can0 -n 1000 -g 1 -I 200 -L 8 -D i -p 10
  wait "$listener"
  awk '{ split($3, part, "#"); print part[2] }' /tmp/answers
}
answers >/tmp/got
expect_equal "$(wc -l </tmp/got)" 1000
# cangen counts up in the data's eight bytes, little endian.
python3 -c 'for i in range(1000): print(i.to_bytes(8, "little").hex().upper())' >/tmp/expected
cmp /tmp/got /tmp/expected

say "answers that come late are heard, and wrong ones noticed"
tell hold
cansend can0 123#01
expect_equal "$(hear 2 tell release)" $'123#01\n124#01'
tell next overflow
tell frame 123 01
wait_for "the kernel to count an overflow" grep -qx 1 /sys/class/net/can0/statistics/rx_over_errors
tell next echo
cansend can0 123#01
wait_for "the kernel to notice an echo of nothing" eval 'dmesg | grep -q "echo id"'

say "the kernel hears of the bus's state"
for state in WARNING PASSIVE; do
  tell "state ${state,,}"
  wait_for "error state $state" state_is "ERROR-$state"
done
tell state bus-off
wait_for "bus-off" state_is BUS-OFF

say "Headway's SocketCAN transport hears the kernel's controller go off the bus"
ip link set can0 down
up
"$build/headway" can dump --bus socketcan:can0 >/tmp/dumped 2>/tmp/states &
dumping=$!
wait_for "the dump's socket" grep -q '^ *can0' /proc/net/can/rcvlist_all
tell state bus-off
wait_for "the transport to hear of it" grep -qx 'socketcan:can0: off the bus' /tmp/states
kill "$dumping"
wait "$dumping" || true

say "pulled out, it is gone; plugged in again, it is back"
tell unplug
wait_for "the kernel to miss the adapter" gone
tell plug
up
expect_equal "$(hear 2 cansend can0 123#01)" $'123#01\n124#01'
end_adapter
wait_for "the kernel to miss the adapter" gone

start_adapter
wait_for "the kernel to find the adapter" there
run_tests hil_usb_can_tests
end_adapter
