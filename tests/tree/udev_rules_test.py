"""What config/udev/60-headway.rules does: udev itself finds no fault in it, and adapters and cameras get the names and
permissions that its comments promise.

udev of Debian 12 cannot apply a file of rules to a device that is not there, so the second half reads them by itself,
as udev(7) says, with as much of the language as the file uses.
"""

import fnmatch
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
RULES = ROOT / "config/udev/60-headway.rules"

TOKEN = re.compile(r'\s*([A-Z]+)(?:\{([^}]*)\})?\s*(==|!=|\+=|=)\s*"([^"]*)"\s*(?:,|$)')
MATCHES = ("ACTION", "SUBSYSTEM", "ENV", "ATTR")
ASSIGNMENTS = ("GOTO", "LABEL", "ENV", "MODE", "GROUP", "SYMLINK", "IMPORT")


def parsed(text):
    """Lines of (key, attribute, operator, value)."""
    lines = []
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip() or line.startswith("#"):
            continue
        tokens, at = [], 0
        while at < len(line):
            token = TOKEN.match(line, at)
            if token is None:
                raise ValueError(f"line {number}: not understood from '{line[at:]}'")
            key, _, operator, _ = token.groups()
            if key not in (MATCHES if operator in ("==", "!=") else ASSIGNMENTS):
                raise ValueError(f"line {number}: {key} does not go with {operator}")
            tokens.append(token.groups())
            at = token.end()
        lines.append(tokens)
    return lines


class Device:
    """A device as udev sees it, and what rules make of it."""

    def __init__(self, subsystem, attributes, action="add", path=None, **env):
        self.values = {"SUBSYSTEM": subsystem, "ACTION": action}
        self.attributes, self.path, self.env = attributes, path, dict(env)
        self.given, self.links = {}, []

    def value(self, key, attribute):
        if key == "ENV":
            return self.env.get(attribute, "")
        if key == "ATTR":
            return self.attributes.get(attribute)
        return self.values[key]

    def fits(self, key, attribute, operator, pattern):
        value = self.value(key, attribute)
        if value is None:  # an attribute that is not there fits nothing
            return False
        return fnmatch.fnmatchcase(value, pattern) == (operator == "==")

    def filled_in(self, text):
        text = re.sub(r"\$attr\{(\w+)\}", lambda m: self.attributes[m[1]], text)
        return re.sub(r"\$env\{(\w+)\}", lambda m: self.env[m[1]], text)

    def assign(self, key, attribute, value):
        if key == "ENV":
            self.env[attribute] = value
        elif key == "SYMLINK":
            self.links.append(self.filled_in(value))
        elif key == "IMPORT":
            if self.path is not None:
                self.env["ID_PATH"] = self.path
        else:
            self.given[key] = value

    def apply(self, lines):
        label = None
        for tokens in lines:
            if label:
                if ("LABEL", None, "=", label) not in tokens:
                    continue
                label = None
            matches = [t for t in tokens if t[2] in ("==", "!=")]
            if not all(self.fits(*t) for t in matches):
                continue
            for key, attribute, operator, value in tokens:
                if operator in ("==", "!="):
                    continue
                if key == "GOTO":
                    label = value
                elif key != "LABEL":
                    self.assign(key, attribute, value)
        return self


def adapter(vendor, product, serial="0031", **more):
    attributes = {"idVendor": vendor, "idProduct": product} | ({"serial": serial} if serial else {})
    return Device("usb", attributes, **({"DEVTYPE": "usb_device"} | more)).apply(parsed(RULES.read_text()))


def camera(index="0", **more):
    return Device("video4linux", {"index": index}, **more).apply(parsed(RULES.read_text()))


PORT = "pci-0000:00:14.0-usb-0:2:1.0"


class Names(unittest.TestCase):
    def products(self):
        """The adapters that the driver takes."""
        header = (ROOT / "drivers/gs_usb_protocol.h").read_text()
        listed = re.search(r"kProducts\{(.*?)\};", header, re.DOTALL)[1]
        return [tuple(n.lower() for n in pair) for pair in re.findall(r"0x(\w{4}), 0x(\w{4})", listed)]

    def test_every_adapter_that_the_driver_takes_may_be_used_and_is_named_by_serial_number(self):
        self.assertEqual(len(self.products()), 4)
        for vendor, product in self.products():
            device = adapter(vendor, product)
            self.assertEqual(device.links, ["headway/can-0031"])
            self.assertEqual(device.given, {"MODE": "0660", "GROUP": "plugdev"})

    def test_an_adapter_without_a_serial_number_may_be_used_and_has_no_name(self):
        device = adapter("1d50", "606f", serial=None)
        self.assertEqual((device.links, device.given["GROUP"]), ([], "plugdev"))

    def test_other_devices_are_left_alone(self):
        for device in (adapter("1d50", "6070"), adapter("1209", "606f"),
                       adapter("1d50", "606f", DEVTYPE="usb_interface"), adapter("1d50", "606f", action="remove"),
                       Device("net", {"idVendor": "1d50", "idProduct": "606f"}).apply(parsed(RULES.read_text()))):
            self.assertEqual((device.links, device.given), ([], {}))

    def test_a_camera_is_named_by_its_port(self):
        for device in (camera(path=PORT), camera(ID_PATH=PORT)):
            self.assertEqual(device.links, [f"headway/camera-{PORT}"])
            self.assertEqual(device.given, {"MODE": "0660", "GROUP": "video"})

    def test_only_a_cameras_images_are_named(self):
        self.assertEqual(camera("1", path=PORT).links, [])
        self.assertEqual(camera().links, [], "no port is known")


class Udev(unittest.TestCase):
    """udev's own reader: `udevadm test` tells of every fault in the rules that it finds in its folders. A file of ours
    is laid there for it alone, in a mount namespace."""

    SCRIPT = ('mount -t tmpfs none /run && mkdir -p /run/udev/rules.d && cp "$1" /run/udev/rules.d/ && '
              "udevadm test /sys/class/net/lo 2>&1")

    def faults(self, file):
        for tool in ("udevadm", "unshare"):
            if not shutil.which(tool):
                self.skipTest(f"{tool} is not installed")
        if os.geteuid() != 0 or subprocess.run(["unshare", "-m", "true"], check=False, capture_output=True).returncode:
            self.skipTest("a mount namespace takes root")
        said = subprocess.run(["unshare", "-m", "sh", "-c", self.SCRIPT, "sh", file], check=False, text=True,
                              stdout=subprocess.PIPE).stdout
        name = f"/run/udev/rules.d/{file.name}"
        self.assertIn(f"Reading rules file: {name}", said)
        return [line for line in said.splitlines() if line.startswith(f"{name}:")]

    def test_udev_finds_no_fault(self):
        self.assertEqual(self.faults(RULES), [])

    def test_planted_faults_are_found(self):
        text = RULES.read_text()
        for right, wrong in (("SUBSYSTEM!=", "SUBSYTEM!="), ('MODE="0660"', 'MODE=="0660"'),
                             ('LABEL="headway_cameras"', 'LABEL="headway_camera"'), ('"plugdev"', '"plugdef"')):
            self.assertIn(right, text)
            with tempfile.TemporaryDirectory() as folder:
                planted = pathlib.Path(folder) / "61-planted.rules"
                planted.write_text(text.replace(right, wrong, 1))
                self.assertTrue(self.faults(planted), wrong)


class Reader(unittest.TestCase):
    """The reader above refuses what udev would."""

    def test_lines_that_are_none(self):
        for line in ('SUBSYTEM=="usb"', 'MODE=="0660"', 'SUBSYSTEM="usb"', 'SUBSYSTEM==usb', 'MODE="0660" GROUP="x"'):
            with self.assertRaises(ValueError, msg=line):
                parsed(line)


if __name__ == "__main__":
    unittest.main()
