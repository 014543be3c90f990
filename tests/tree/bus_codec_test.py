#!/usr/bin/python3
"""The committed bus codec is what the database says.

usage: tests/tree/bus_codec_test.py [--tool PATH]

Alone: regenerating hal/bus_codec.* changes no byte, and the generator complains about unsound databases. With the
built codec_tool: thousands of random frames of every message, packed and unpacked by the codec and by
python3-canmatrix, which reads the same database on its own.
"""

import argparse
import pathlib
import random
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
DBC = ROOT / "config/can/headway.dbc"
GENERATOR = ROOT / "scripts/generate_bus_codec"
FRAMES = 2000  # of each message, each way
TOOL = None


def generate(dbc, out):
    command = [sys.executable, str(GENERATOR), "--dbc", str(dbc), "--out", str(out)]
    return subprocess.run(command, capture_output=True, text=True)


class Generation(unittest.TestCase):
    def test_regenerating_changes_no_byte(self):
        with tempfile.TemporaryDirectory() as out:
            result = generate(DBC, out)
            self.assertEqual(result.returncode, 0, result.stderr)
            for name in ("bus_codec.h", "bus_codec.cpp"):
                fresh = (pathlib.Path(out) / name).read_bytes()
                self.assertEqual(fresh, (ROOT / "hal" / name).read_bytes(),
                                 f"hal/{name} is not what {DBC.name} says; run scripts/generate_bus_codec")

    def test_unsound_databases_are_refused_with_their_line(self):
        good = DBC.read_text()
        damages = {
            "overlap": (" SG_ Foot : 12|1@1+", " SG_ Foot : 11|1@1+"),
            "does not lie within": (" SG_ Dz : 59|5@1-", " SG_ Dz : 60|5@1-"),
            "does not fit its bits": ("[-0.128|0.12]", "[-0.128|0.128]"),
            "only little endian": (" SG_ Ms : 16|32@1+", " SG_ Ms : 23|32@0+"),
            "used twice": ("BO_ 289 VIS_WalkControl", "BO_ 288 VIS_WalkControl"),
            "is not in BU_": ("BO_ 288 VIS_StepCommand: 8 VIS", "BO_ 288 VIS_StepCommand: 8 EYE"),
            "differs from": (" SG_ Velocity : 32|32@1- (0.001,0) [-2147483.648|2147483.647]",
                             " SG_ Velocity : 32|32@1- (0.01,0) [-21474836.48|21474836.47]"),
            "is missing": ('BA_ "Layout" BO_ 288 "StepCommand";\n', ""),
            "cannot read": ("VAL_ 288 Foot 0 \"Left\"", "VAL_ 288 Foot zero \"Left\""),
            "has no signal": ("VAL_ 288 Foot", "VAL_ 288 Hand"),
        }
        for words, (before, after) in damages.items():
            self.assertIn(before, good)
            with tempfile.TemporaryDirectory() as out, self.subTest(words):
                dbc = pathlib.Path(out) / "bad.dbc"
                dbc.write_text(good.replace(before, after, 1))
                result = generate(dbc, out)
                self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
                self.assertRegex(result.stderr, rf"^\S*bad\.dbc:\d+: .*{words}")
                self.assertEqual(len(result.stderr.splitlines()), 1)
                self.assertFalse((pathlib.Path(out) / "bus_codec.h").exists())


def crc8(data):
    """Bit by bit, from the definition: polynomial 0x1D, initial value 0, no final xor."""
    crc = 0
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = ((crc << 1) ^ 0x1D) & 0xFF if crc & 0x80 else (crc << 1) & 0xFF
    return crc


class CrossTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if TOOL is None:
            raise unittest.SkipTest("give --tool PATH to compare the built codec with canmatrix")
        import canmatrix.formats
        cls.frames = sorted(canmatrix.formats.loadp_flat(str(DBC)).frames, key=lambda f: f.arbitration_id.id)
        cls.listed = {int(line.split()[0]): line.split()[1:] for line in cls.ask(["list"]) if line != "end"}

    @staticmethod
    def ask(lines):
        done = subprocess.run([TOOL], input="\n".join(lines) + "\n", capture_output=True, text=True, check=True)
        return done.stdout.splitlines()

    def signals(self, frame):
        """canmatrix' signals in the codec's order."""
        by_name = {s.name: s for s in frame.signals}
        return [by_name[name] for name in self.listed[frame.arbitration_id.id][2:]]

    @staticmethod
    def bounds(signal):
        """The declared raw range, from canmatrix' physical one."""
        return [round((x - signal.offset) / signal.factor) for x in (signal.min, signal.max)]

    def declared(self, signal, raw):
        low, high = self.bounds(signal)
        return low <= raw <= high and (len(signal.values) < 2 or raw in {int(v) for v in signal.values})

    def choose(self, signal, rng):
        if len(signal.values) >= 2:
            return rng.choice([int(v) for v in signal.values])
        low, high = self.bounds(signal)
        return rng.choice([low, high, rng.randint(low, high), rng.randint(low, high), rng.randint(low, high)])

    @staticmethod
    def text(data):
        return data.hex() or "-"

    def test_both_know_the_same_messages_and_signals(self):
        theirs = {f.arbitration_id.id: (f.name, f.size, {s.name for s in f.signals}) for f in self.frames}
        ours = {id: (names[0], int(names[1]), set(names[2:])) for id, names in self.listed.items()}
        self.assertEqual(ours, theirs)
        self.assertGreaterEqual(len(ours), 20)

    def test_what_we_pack_is_what_they_encode(self):
        for frame in self.frames:
            rng = random.Random(frame.name)
            id, signals = frame.arbitration_id.id, self.signals(frame)
            raws = [[self.choose(s, rng) for s in signals] for _ in range(FRAMES)]
            lines = [f"pack {id} " + " ".join(repr(float(r * s.factor + s.offset)) for s, r in zip(signals, raw))
                     for raw in raws]
            for raw, ours in zip(raws, self.ask(lines), strict=True):
                theirs = frame.encode({s.name: r for s, r in zip(signals, raw)})
                self.assertEqual(ours, self.text(bytes(theirs)), f"{frame.name} {raw}")

    def test_what_they_decode_is_what_we_unpack(self):
        for frame in self.frames:
            rng = random.Random(frame.name)
            id, signals = frame.arbitration_id.id, self.signals(frame)
            raws = [bytes(frame.encode({s.name: self.choose(s, rng) for s in signals})) for _ in range(FRAMES // 2)]
            raws += [rng.randbytes(frame.size) for _ in range(FRAMES // 2)]
            refused = 0
            for data, ours in zip(raws, self.ask([f"unpack {id} {self.text(d)}" for d in raws]), strict=True):
                decoded = frame.decode(data) if signals else {}
                theirs = [decoded[s.name] for s in signals]
                if not all(self.declared(s, t.raw_value) for s, t in zip(signals, theirs)):
                    self.assertEqual(ours, "refused", f"{frame.name} {data.hex()}")
                    refused += 1
                    continue
                self.assertNotEqual(ours, "refused", f"{frame.name} {data.hex()}")
                for s, t, value in zip(signals, theirs, map(float, ours.split()), strict=True):
                    self.assertAlmostEqual(value, float(t.phys_value), delta=1e-9 * max(1, abs(value)),
                                           msg=f"{frame.name}.{s.name} {data.hex()}")
            self.assertLessEqual(refused, FRAMES // 2, frame.name)

    def test_values_just_outside_the_contract_are_refused(self):
        lines = []
        for frame in self.frames:
            signals = self.signals(frame)
            for wrong in signals:
                low, high = self.bounds(wrong)
                for raw in (low - 1, high + 1):
                    good = random.Random(0)
                    values = [raw if s is wrong else self.choose(s, good) for s in signals]
                    lines.append(f"pack {frame.arbitration_id.id} " +
                                 " ".join(repr(float(v) * float(s.factor)) for s, v in zip(signals, values)))
        answers = self.ask(lines)
        self.assertEqual(set(zip(answers)), {("refused",)}, [l for l, a in zip(lines, answers) if a != "refused"][:3])

    def test_the_crc_is_the_one_of_the_contract(self):
        self.assertEqual(crc8(b"123456789"), 0x37)
        rng = random.Random(1)
        for frame in self.frames:
            if not any(s.name == "Crc" for s in frame.signals):
                continue
            id = frame.arbitration_id.id
            datas = [rng.randbytes(8) for _ in range(200)]
            theirs = [crc8(bytes([id & 0xFF, id >> 8]) + d[1:]) for d in datas]
            self.assertEqual([int(a) for a in self.ask([f"crc {id} {d.hex()}" for d in datas])], theirs, frame.name)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--tool", help="the built codec_tool")
    options, rest = parser.parse_known_args()
    TOOL = options.tool
    unittest.main(argv=sys.argv[:1] + rest)
