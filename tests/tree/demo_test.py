"""The scripts refuse wrong arguments in one line, before they build or remove anything."""

import os
import pathlib
import shutil
import subprocess
import tempfile
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

    def test_help_is_found_from_every_folder(self):
        for folder, name in ((ROOT, "scripts/setup"), (ROOT / "scripts", "./setup"), (ROOT / "docs", "../scripts/setup")):
            run = subprocess.run([name, "--help"], cwd=folder, capture_output=True, text=True, check=False)
            self.assertEqual((run.returncode, run.stderr), (0, ""), folder)
            self.assertTrue(run.stdout.startswith("scripts/setup ["), run.stdout)

    def test_setup_goes_on_where_no_registry_is_reached_but_in_ci(self):
        with tempfile.TemporaryDirectory() as folder:
            tree, bin_ = pathlib.Path(folder) / "tree", pathlib.Path(folder) / "bin"
            (tree / "scripts").mkdir(parents=True)
            bin_.mkdir()
            shutil.copy(ROOT / "scripts/setup", tree / "scripts")
            programs = {"npm": "echo no registry >&2; exit 1", "apt-get": "exit 1",
                        "dpkg-query": "shift 3; printf 'ii %s\\n' \"$@\""}
            for name, text in programs.items():
                (bin_ / name).write_text(f"#!/bin/sh\n{text}\n")
                (bin_ / name).chmod(0o755)
            for ci, code in (("", 0), ("true", 1)):
                run = subprocess.run([tree / "scripts/setup"], capture_output=True, text=True, check=False,
                                     env={**os.environ, "PATH": f"{bin_}:{os.environ['PATH']}", "CI": ci})
                self.assertEqual(run.returncode, code, run.stderr)
                self.assertIn("npm could not fetch", run.stderr)

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
