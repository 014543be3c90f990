#!/usr/bin/python3
"""The program with streams that are closed or full, or without a terminal: nothing that is meant for people goes
elsewhere, its exit codes hold, and it ends when it is told to.

usage: tests/app/standard_streams_test.py --headway PATH
"""

import argparse
import itertools
import os
import pathlib
import signal
import subprocess
import sys
import threading
import tty
import unittest

HEADWAY = None
LONGEST = 20  # [s]; nothing here takes so long unless it hangs


class Adapter:
    """The far end of a serial line: sends a frame whenever it is put on the bus, keeps what it was told."""

    def __init__(self):
        self.far, self.near = os.openpty()
        tty.setraw(self.near)
        self.path = os.ttyname(self.near)
        self.heard = b""
        self.thread = threading.Thread(target=self.serve)
        self.thread.start()

    def serve(self):
        while True:
            some = os.read(self.far, 4096)
            self.heard += some
            if b"end" in self.heard:
                return
            for _ in range(some.count(b"O\r")):
                os.write(self.far, b"t711105\r" * 8)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        os.write(self.near, b"end")
        self.thread.join()
        os.close(self.far)
        os.close(self.near)


def headway(*arguments, closed=(), **streams):
    def close():
        for number in closed:
            os.close(number)

    with subprocess.Popen([HEADWAY, *arguments], preexec_fn=close, **streams) as program:
        try:
            program.wait(LONGEST)
        finally:
            program.send_signal(signal.SIGKILL)
        return program.returncode


class StandardStreams(unittest.TestCase):
    def test_nothing_but_its_own_commands_reaches_an_adapter_whatever_is_closed(self):
        for count in range(1, 4):
            for closed in itertools.combinations(range(3), count):
                with self.subTest(closed=closed), Adapter() as adapter, open(os.devnull, "wb") as nothing:
                    code = headway("can", "dump", "--bus", "slcan:" + adapter.path, "--count", "2", "--seconds", "20",
                                   closed=closed, stdout=nothing, stderr=nothing)
                    self.assertEqual(code, 0)
                    self.assertNotIn(b"frames", adapter.heard)
                    self.assertNotIn(b"(", adapter.heard)

    def test_errors_that_nobody_can_hear_end_with_their_code(self):
        robot = str(pathlib.Path(__file__).resolve().parents[2] / "config/hrp2/robot.yaml")
        for arguments in ["bogus"], ["status", "--socket", "/nowhere"], ["run", robot, "--bus", "slcan:/nowhere"]:
            heard = headway(*arguments, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
            self.assertIn(heard, (1, 2, 3))
            self.assertEqual(headway(*arguments, closed=[2]), heard)
            with open("/dev/full", "wb") as full:
                self.assertEqual(headway(*arguments, stderr=full), heard)

    def test_a_dump_that_cannot_be_written_ends_with_the_reason(self):
        with Adapter() as adapter, open("/dev/full", "wb") as full:
            program = subprocess.run([HEADWAY, "can", "dump", "--bus", "slcan:" + adapter.path], check=False,
                                     stdout=full, stderr=subprocess.PIPE, timeout=LONGEST)
        self.assertEqual(program.returncode, 3)
        self.assertIn(b"No space left on device", program.stderr)

    def test_a_hang_up_ends_a_dump_that_has_no_terminal(self):
        with Adapter() as adapter, subprocess.Popen([HEADWAY, "can", "dump", "--bus", "slcan:" + adapter.path],
                                                    start_new_session=True, stdout=subprocess.PIPE,
                                                    stderr=subprocess.DEVNULL) as program:
            program.stdout.readline()
            program.send_signal(signal.SIGHUP)
            try:
                self.assertEqual(program.wait(LONGEST), 0)
            finally:
                program.kill()


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--headway", required=True)
    known, rest = parser.parse_known_args()
    HEADWAY = known.headway
    unittest.main(argv=[sys.argv[0], *rest])
