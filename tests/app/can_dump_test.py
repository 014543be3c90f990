#!/usr/bin/python3
"""`headway can dump` against readers and writers that are not ours.

usage: tests/app/can_dump_test.py --headway PATH

python3-canmatrix makes frames of every message from the database, python3-can writes them as a log of candump, the
program reads that log, and what it says is compared with what canmatrix decodes.
"""

import argparse
import json
import pathlib
import random
import subprocess
import sys
import tempfile
import unittest

import can
import canmatrix.formats

ROOT = pathlib.Path(__file__).resolve().parents[2]
FRAMES = 60  # of each message
HEADWAY = None


def crc8(data):
    """Bit by bit, from the definition: polynomial 0x1D, initial value 0, no final xor."""
    crc = 0
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = ((crc << 1) ^ 0x1D) & 0xFF if crc & 0x80 else (crc << 1) & 0xFF
    return crc


class CanDump(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.messages = canmatrix.formats.loadp_flat(str(ROOT / "config/can/headway.dbc")).frames
        cls.rng = random.Random(2008)

    def values(self, message, counter):
        """Raw ones that the database declares."""
        raw = {}
        for s in message.signals:
            low, high = (round((x - s.offset) / s.factor) for x in (s.min, s.max))
            raw[s.name] = self.rng.choice([int(v) for v in s.values]) if len(s.values) >= 2 else \
                self.rng.choice([low, high, self.rng.randint(low, high)])
        if "Counter" in raw:
            raw["Counter"] = counter
        return raw

    def frame(self, message, counter):
        """Bytes of one frame; protected ones with their CRC, one in ten of those with another."""
        data = bytearray(message.encode(self.values(message, counter)))
        broken = False
        if any(s.name == "Crc" for s in message.signals):
            number = message.arbitration_id.id  # the data id of a message is its CAN id
            broken = self.rng.random() < 0.1
            data[0] = crc8(bytes([number & 0xFF, number >> 8]) + data[1:]) ^ (0x55 if broken else 0)
        return bytes(data), broken

    def dump(self, sent):
        with tempfile.TemporaryDirectory() as folder:
            log = pathlib.Path(folder) / "candump.log"
            writer = can.CanutilsLogWriter(str(log), channel="can0")
            for i, (message, data, _) in enumerate(sent):
                writer.on_message_received(can.Message(timestamp=1.7e9 + i / 1000, data=data, is_extended_id=False,
                                                       arbitration_id=message.arbitration_id.id, is_rx=i % 2 == 0))
            writer.stop()
            done = subprocess.run([HEADWAY, "can", "dump", "--json", "--log", log], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            return [json.loads(line) for line in done.stdout.splitlines()]

    def test_says_what_canmatrix_decodes(self):
        sent = [(message, *self.frame(message, i % 15)) for i in range(FRAMES) for message in self.messages]
        told = self.dump(sent)
        self.assertEqual(len(told), len(sent))
        checked = 0
        for (message, data, broken), line in zip(sent, told):
            self.assertEqual(line["id"], message.arbitration_id.id)
            self.assertEqual(line["data"], data.hex().upper())
            self.assertEqual(line["name"], message.name)
            self.assertTrue(line["declared"], line)
            if any(s.name == "Crc" for s in message.signals):
                self.assertEqual(line["check"] == "wrong CRC", broken, line)
                self.assertIn(line["check"], ("ok", "ok, some lost", "wrong CRC"))
            decoded = message.decode(data)
            self.assertEqual(set(line.get("signals", {})), set(decoded))
            for name, signal in line.get("signals", {}).items():
                self.assertAlmostEqual(signal["value"], float(decoded[name].phys_value), places=9, msg=f"{name}: {line}")
                self.assertEqual(signal.get("unit", ""), message.signal_by_name(name).unit)
                names = {int(raw): text for raw, text in message.signal_by_name(name).values.items()}
                if line.get("function") != "EMCY":  # whose codes CiA 301 names, and not the database
                    self.assertEqual(signal.get("meaning"), names.get(decoded[name].raw_value), line)
                checked += 1
        self.assertGreater(checked, 1000)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--headway", required=True)
    arguments, rest = parser.parse_known_args()
    HEADWAY = arguments.headway
    unittest.main(argv=sys.argv[:1] + rest)
