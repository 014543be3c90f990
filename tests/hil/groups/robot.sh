#!/usr/bin/env bash
# The whole robot: `headway run` on V4L2 cameras and SocketCAN, the simulated robot of `headway node` behind them.
set -euo pipefail
source tests/hil/guest.sh
for command in run node; do
  "$build/headway" --help | grep -q "^  $command " || skip "headway has no command $command yet"
done
skip "nothing is written yet that joins headway run and headway node"
