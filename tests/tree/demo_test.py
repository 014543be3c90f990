"""The scripts refuse wrong arguments in one line, before they build or remove anything."""

import pathlib
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Scripts(unittest.TestCase):
    def refused(self, *arguments, script="demo"):
        run = subprocess.run([ROOT / "scripts" / script, *arguments], cwd="/", capture_output=True, text=True,
                             check=False)
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

    def test_no_test_runs_for_an_option_that_ctest_passes_over(self):
        self.assertIn("unknown option '--bogus'", self.refused("--bogus", script="test"))
        self.assertIn("unknown option '-Z'", self.refused("-j", "2", "-L", "nav", "-Z", script="test"))
        self.assertIn("unknown argument 'nav'", self.refused("nav", script="test"))

    def test_a_benchmark_that_is_none_is_named(self):
        self.assertIn("no benchmark 'nope'", self.refused("nope", script="bench"))


if __name__ == "__main__":
    unittest.main()
