"""What is installed on a robot: the program starts from where it is installed, systemd and udev find their files and no
fault in them, and the Debian package holds the same.
"""

import argparse
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

BUILD = None
# What the unit refers to, and what systemd takes for granted.
UNITS = ("systemd-udev-settle.service", "modprobe@.service", "sysinit.target", "basic.target", "shutdown.target", "network.target", "multi-user.target")


def output(*command):
    done = subprocess.run(command, check=False, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode:
        raise AssertionError(f"{' '.join(map(str, command))}: {done.returncode}: {done.stdout}")
    return done.stdout


def need(case, tool):
    if not shutil.which(tool):
        case.skipTest(f"{tool} is not installed")


def files_below(folder):
    return {str(f.relative_to(folder)) for f in folder.rglob("*") if f.is_file()}


class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.root = pathlib.Path(cls.folder.name)
        output("cmake", "--install", BUILD, "--prefix", cls.root / "usr")
        cls.units = cls.root / "usr/lib/systemd/system"

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_the_program_runs_where_it_is_installed(self):
        share = self.root / "usr/share/headway/config"
        said = output(self.root / "usr/bin/headway", "characterise", share / "hrp2/rigs/bottom.yaml", "--out",
                      self.root / "out")
        self.assertTrue((self.root / "out/report.json").is_file(), said)

    def faults(self, text=None):
        """What systemd says of the unit, in a root of its own."""
        need(self, "systemd-analyze")
        unit = self.units / "headway.service"
        right = unit.read_text()
        for name in UNITS:
            service = "[Service]\nExecStart=/usr/bin/headway\n" if name.endswith(".service") else ""
            (self.units / name).write_text(f"[Unit]\nDescription={name}\n{service}")
        try:
            unit.write_text(text or right)
            return output("systemd-analyze", "verify", f"--root={self.root}", "headway.service").strip()
        finally:
            unit.write_text(right)

    def test_systemd_finds_no_fault_in_the_unit(self):
        self.assertEqual(self.faults(), "")

    def test_planted_faults_are_found(self):
        text = (self.units / "headway.service").read_text()
        for right, wrong in (("LimitRTPRIO=95", "LimitRTPRIOR=95"), ("Type=notify", "Type=notifies"),
                             ("WatchdogSec=2", "WatchdogSec=two"), ("NoNewPrivileges=yes", "NoNewPrivileges=maybe")):
            self.assertIn(right, text)
            self.assertNotEqual(self.faults(text.replace(right, wrong)), "", wrong)

    def test_the_service_may_do_little(self):
        need(self, "systemd-analyze")
        unit = self.units / "headway.service"
        said = output("systemd-analyze", "security", "--offline=yes", "--threshold=30", unit)
        self.assertIn("Overall exposure level", said)
        loose = self.root / "loose.service"
        loose.write_text("[Service]\nExecStart=/bin/true\n")
        with self.assertRaises(AssertionError):
            output("systemd-analyze", "security", "--offline=yes", "--threshold=30", loose)

    def test_the_services_user_can_be_made(self):
        need(self, "systemd-sysusers")
        (self.root / "etc").mkdir(exist_ok=True)
        output("systemd-sysusers", f"--root={self.root}", "headway.conf")
        groups = (self.root / "etc/group").read_text()
        for group in ("video", "plugdev", "dialout"):
            self.assertRegex(groups, rf"(?m)^{group}:.*\bheadway\b")

    def test_the_debian_package_holds_the_same(self):
        for tool in ("dpkg-deb", "dpkg-shlibdeps"):
            need(self, tool)
        with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as unpacked:
            output("cpack", "-G", "DEB", "--config", BUILD / "CPackConfig.cmake", "-B", folder)
            package, = pathlib.Path(folder).glob("*.deb")
            output("dpkg-deb", "-x", package, unpacked)
            output("dpkg-deb", "-e", package, pathlib.Path(unpacked) / "control")
            made = files_below(pathlib.Path(unpacked) / "usr")
            self.assertEqual(made, {f for f in files_below(self.root / "usr") if pathlib.Path(f).name not in UNITS})
            self.assertIn("bin/headway", made)
            for name in ("postinst", "prerm", "postrm"):
                script = pathlib.Path(unpacked) / "control" / name
                output("sh", "-n", script)
                self.assertTrue(script.stat().st_mode & 0o100, name)
            self.assertIn("libsystemd0", output("dpkg-deb", "-f", package, "Depends"))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=pathlib.Path, required=True, help="folder of a build with the program")
    arguments, rest = parser.parse_known_args()
    BUILD = arguments.build.resolve()
    unittest.main(argv=[sys.argv[0], *rest])
