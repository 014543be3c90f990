#!/usr/bin/env bash
# A USB camera end to end: the kernel's own uvcvideo serves what an emulated camera films, byte for byte.
set -euo pipefail
source tests/hil/guest.sh
modprobe -a vhci-hcd uvcvideo

commands=/tmp/camera given=/tmp/given video=/dev/video0

# start_camera FORMAT BYTES_PER_PIXEL: it films 16 frames of random bytes, over and over; or, of JPEG, what is there.
start_camera() {
  size=$((320 * 240 * $2))
  [[ $1 == mjpeg ]] || tests/hil/given_frames make "$given" 16 "$size" 1
  "$build/hil_usb_camera" --frames "$given" --size 320 240 --format "$1" --commands "$commands" >/tmp/camera_log 2>&1 &
  camera=$!
  wait_for "the kernel to find the camera" there
}

end_camera() {
  kill "$camera"
  wait "$camera"
  rm "$commands"
  if grep 'unknown command' /tmp/camera_log; then fail "the camera was told what it does not know"; fi
  wait_for "the kernel to miss the camera" gone
}

tell() {
  echo "$*" >"$commands"
}

there() { [[ -c $video ]]; }
gone() { [[ ! -e /sys/bus/usb/devices/1-1 ]]; }

# film COUNT [V4L2-CTL OPTION...]: reads so many frames and compares them with those given.
film() {
  local count=$1
  shift
  timeout 60 v4l2-ctl -d "$video" "$@" --stream-mmap --stream-count="$count" --stream-to=/tmp/read 2>/tmp/stream ||
    fail "no $count frames: $(tail -n 1 /tmp/stream)"
  tests/hil/given_frames compare "$given" /tmp/read "$size" "$count"
}

# A stream without end, until it fails or is ended.
begin_stream() {
  rm -f /tmp/endless
  v4l2-ctl -d "$video" --stream-mmap --stream-to=/tmp/endless 2>/dev/null &
  stream=$!
  wait_for "a frame" test -s /tmp/endless
}

control() {
  v4l2-ctl -d "$video" -C "$1" | awk '{ print $2 }'
}

say "grey frames are read as they were given"
start_camera grey 1
wait_for "the camera's name by its port" test -e /dev/v4l/by-path/platform-vhci_hcd.0-usb-0:1:1.0-video-index0
expect_equal "$(v4l2-ctl -d "$video" --list-formats-ext | awk '/\[0\]|Size/')" \
  $'\t[0]: \'GREY\' (8-bit Greyscale)\n\t\tSize: Discrete 320x240'
film 24

say "headway doctor says on which bus it is, and that it is asked for no more than that carries"
"$build/headway" doctor config/hrp2/robot.yaml --left "$video" --right "$video" >/tmp/doctor || true
grep -Eq '^ok    usb      left camera: .+, release [0-9]+\.[0-9]+$' /tmp/doctor || fail "$(cat /tmp/doctor)"
grep -Eq '^ok    usb      bus usb1: left [0-9.]+ MB/s \+ right [0-9.]+ MB/s of the 48.0 MB/s' /tmp/doctor ||
  fail "$(cat /tmp/doctor)"

say "at another rate too"
film 8 -p 5
expect_equal "$(v4l2-ctl -d "$video" -P | awk '/Frames per second/ { print $4 }')" 5.000

say "controls are read back as they were set"
v4l2-ctl -d "$video" -c auto_exposure=1 -c white_balance_automatic=0
v4l2-ctl -d "$video" -c exposure_time_absolute=77 -c gain=33 -c white_balance_temperature=5000
expect_equal "$(control exposure_time_absolute) $(control gain) $(control white_balance_temperature)" "77 33 5000"

say "half a frame is none; the gap in the numbers tells of it"
first_number() {
  v4l2-ctl -d "$video" --verbose --stream-mmap --stream-count=1 2>&1 | awk '/cap dqbuf/ { print $5; exit }'
}
expect_equal "$(first_number)" 0
tell next half
expect_equal "$(first_number)" 1
tell next half
film 8

say "an endpoint that stalls silences the stream, and the next one is whole"
begin_stream
tell stall 0x81
wait_for "the kernel to hear of the stall" eval 'dmesg | grep -q "Non-zero status (-32) in video"'
kill "$stream"
expect_end_of "$stream"
film 8

say "a camera that is pulled out is gone; plugged in again, it films"
begin_stream
# Held until the kernel has cleared up: a file closed in that moment can bring it down (uvcvideo of Linux 6.1).
kill -STOP "$stream"
tell unplug
wait_for "the kernel to miss the camera" gone
kill -CONT "$stream"
expect_end_of "$stream"
[[ ! -e $video ]] || fail "$video is still there"
tell plug
wait_for "the kernel to find the camera" there
film 8

export HEADWAY_VIDEO=$video HEADWAY_CAMERA_COMMANDS=$commands HEADWAY_FILMED=$given
run_tests hil_camera_usb_tests --gtest_filter=UsbCamera.*
end_camera

say "colour frames are read as they were given"
start_camera yuyv 2
film 24
end_camera

say "distances are read as they were given"
start_camera z16 2
film 24
run_tests hil_camera_usb_tests --gtest_filter=UsbDepthCamera.*
end_camera

# The image is libjpeg's, by netpbm, which also reads it and what headway writes.
say "headway camera show sees a JPEG image as libjpeg does"
python3 - >/tmp/noise.pgm <<'NOISE'
import random, sys
numbers = random.Random(1)
rows = [[int(60 + 80 * x / 320 + 40 * (y > 120) + numbers.random() * 30) for x in range(320)] for y in range(240)]
sys.stdout.buffer.write(b"P5 320 240 255\n" + bytes(v for row in rows for v in row))
NOISE
pnmtojpeg -quality=90 /tmp/noise.pgm >"$given"
jpegtopnm "$given" 2>/dev/null >/tmp/seen.pgm
start_camera mjpeg 2
"$build/headway" camera show "$video" --format MJPG --size 320x240 --out /tmp/look_jpeg
pngtopnm /tmp/look_jpeg/*.png >/tmp/shown.pnm
python3 - /tmp/seen.pgm /tmp/shown.pnm <<'COMPARE'
import sys
seen = open(sys.argv[1], "rb").read()[-320 * 240:]
shown = open(sys.argv[2], "rb").read()
shown = shown[-3 * 320 * 240:][::3] if shown.startswith(b"P6") else shown[-320 * 240:]
worst = max(abs(a - b) for a, b in zip(seen, shown))
print(f"{len(shown)} pixels, {worst} apart at most")
sys.exit(len(shown) != 320 * 240 or worst > 2)
COMPARE
say "half a JPEG image is counted as damaged, and the next one is whole"
tell next half
"$build/headway" camera show "$video" --format MJPG --size 320x240 --rate 5 --seconds 4 --out /tmp/look_half
grep -Eq '"damaged": [1-9]' /tmp/look_half/report.json || fail "$(cat /tmp/look_half/report.json)"
end_camera

# Netpbm reads the picture: it is not the library that wrote it.
say "headway camera show sees a frame as it was given, and sets what it is told"
start_camera grey 1
"$build/headway" camera show "$video" --format GREY --size 320 240 --rate 5 --exposure 5 --gain 20 --out /tmp/look
pngtopnm /tmp/look/*.png | tail -c $((3 * size)) | python3 -c \
  'import sys; sys.stdout.buffer.write(sys.stdin.buffer.read()[::3])' >/tmp/read
tests/hil/given_frames compare "$given" /tmp/read "$size" 1
expect_equal "$(control exposure_time_absolute) $(control gain)" "50 20"
end_camera
