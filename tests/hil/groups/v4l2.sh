#!/usr/bin/env bash
# V4L2 cameras on the kernel's virtual camera, vivid, and the faults it can be told to have.
set -euo pipefail
source tests/hil/guest.sh

# A fault that vivid was told stays armed: each test gets a camera of its own. It stamps frames at the end of their
# exposure, as a camera does; of its own accord it takes another moment that may lie in the future.
fresh_camera() {
  ! lsmod | grep -q '^vivid ' || rmmod vivid
  modprobe vivid n_devs=1 node_types=0x1 num_inputs=1 input_types=0x0
  udevadm settle
  [[ -c /dev/video0 ]]
  v4l2-ctl -d /dev/video0 -c timestamp_source=1
}

say "v4l2-ctl reads frames of the size it asked for"
fresh_camera
v4l2-ctl -d /dev/video0 --set-fmt-video width=640,height=480,pixelformat=YUYV --stream-mmap --stream-count=3 \
  --stream-to=/tmp/frames 2>/dev/null
expect_equal "$(stat -c %s /tmp/frames)" $((3 * 640 * 480 * 2))

say "a stream ends when its camera is pulled out"
v4l2-ctl -d /dev/video0 --stream-mmap --stream-to=/tmp/endless 2>/dev/null &
stream=$!
wait_for "a frame" test -s /tmp/endless
v4l2-ctl -d /dev/video0 -c disconnect=1
expect_end_of "$stream"

export HEADWAY_VIDEO=/dev/video0
run_each_test hil_v4l2_tests fresh_camera
