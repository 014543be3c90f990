#!/usr/bin/env bash
# The whole robot: `headway run` on two V4L2 cameras and SocketCAN; behind them, in another process, the simulated robot
# of `headway node`. Both go by a clock that is so many times slower, for the guest is.
set -euo pipefail
source tests/hil/guest.sh
# Pictures are stamped when the camera hands them over: long after the exposure, for here drawing takes long.
slower=${HEADWAY_HIL_SLOWER:-20} delay=90
wires=/tmp/wires
robot=$wires/robot.yaml

say "scripts/wires: a bus, and two cameras that film what the simulated robot sees"
scripts/wires --delay "$delay" "$wires" >/tmp/wires.log 2>&1 &
made=$!
wait_for "the left camera" test -e /dev/v4l/by-path/platform-vhci_hcd.0-usb-0:1:1.0-video-index0
wait_for "the wires" test -e "$robot"
# It looks around only as far as a short walk in a small room needs.
sed -i 's/least_gain: 0.1/least_gain: 1.0/' "$robot"
grep -q 'least_gain: 1.0' "$robot" || fail "the robot file has changed"

say "the simulated robot stands in its room"
"$build/headway" node "$robot" --world tests/hil/robot_world.yaml --bus socketcan:vcan0 --left "$wires/left" --right "$wires/right" \
  --camera-delay "$delay" --slower "$slower" >/tmp/node.log 2>&1 &
node=$!
candump -n 1 -T 60000 vcan0,130:7FF >/tmp/heard
grep -q . /tmp/heard || fail "no status of the control computer: $(cat /tmp/node.log)"

say "headway run looks around and walks it to the goal"
status=0
timeout "$((${HEADWAY_HIL_SECONDS:-1200} - 100))" "$build/headway" run "$robot" --floor 5,5 --goal 0.8,0 --slower "$slower" --out /tmp/run || status=$?
kill "$node" || true
ended=0
wait "$node" || ended=$?
cat /tmp/node.log
((ended == 0)) || fail "headway node ended with $ended"
((status == 0)) || fail "headway run ended with $status: $(cat /tmp/run/report.json)"

say "and there it stands, by the simulator's truth"
python3 - "$(grep -o 'stands at (.*)' /tmp/node.log)" <<'TRUTH'
import re
import sys

x, y = (float(number) for number in re.findall(r"-?\d+\.\d+", sys.argv[1])[:2])
distance = ((x - 0.3) ** 2 + y**2) ** 0.5
print(f"{distance:.3f} m from the goal")
sys.exit(distance > 0.10)
TRUTH

say "the wires go as they came"
kill "$made"
wait "$made"
[[ ! -e /sys/class/net/vcan0 ]] || fail "vcan0 is still there"
