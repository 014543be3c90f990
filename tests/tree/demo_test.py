"""scripts/demo refuses wrong arguments in one line, before it builds or removes anything."""

import pathlib
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Demo(unittest.TestCase):
    def refused(self, *arguments):
        run = subprocess.run([ROOT / "scripts/demo", *arguments], cwd="/", capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 2, run.stderr)
        self.assertEqual(run.stdout, "")
        self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
        return run.stderr

    def test_wrong_arguments_are_named(self):
        self.assertIn("--world no/such.yaml: no such world file", self.refused("--world", "no/such.yaml"))
        self.assertIn("--world: expected", self.refused("--world"))
        self.assertIn("--seed -1: expected a whole number", self.refused("--seed", "-1"))
        self.assertIn("--seed : expected", self.refused("--seed"))
        self.assertIn("unknown argument '--fly'", self.refused("--fly"))


if __name__ == "__main__":
    unittest.main()
