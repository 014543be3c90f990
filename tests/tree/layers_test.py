"""Who may use whom. Reads the includes of every room and fails on an edge that docs/architecture.md does not allow.

The first half is the table; the second proves, on a small tree made for it, that each kind of breach is found.
"""

import fnmatch
import pathlib
import re
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]

# Plain values of the hal, which vision and nav may see, and that work can be divided, without a word about threads; the
# rest of the hal is devices and their protocols.
HAL_VALUES = [f"hal/{name}.h" for name in ("angle", "error", "time", "pose2", "frame", "footstep", "walk_order", "step_number", "head",
                                        "head_kinematics", "two_processors")]

# Libraries by the headers they own.
LIBRARIES = {
    "Eigen": ["Eigen/*"],
    "OpenCV": ["opencv2/*"],
    "qhull": ["libqhull_r/*", "libqhullcpp/*"],
    "OctoMap": ["octomap/*"],
    "Embree": ["embree3/*"],
    "yaml-cpp": ["yaml-cpp/*"],
    "fmt": ["fmt/*"],
    "spdlog": ["spdlog/*"],
    "json": ["nlohmann/*"],
    "expected": ["tl/expected.hpp"],
    "CLI11": ["CLI/*"],
    "Highway": ["hwy/*"],
    "Boost": ["boost/*"],
    "OpenSSL": ["openssl/*"],
    "libusb": ["libusb.h", "libusb-1.0/*"],
    "libjpeg": ["jpeglib.h", "turbojpeg.h"],
    "zstd": ["zstd.h"],
    "zlib": ["zlib.h"],
    "systemd": ["systemd/*"],
    "threads": ["thread", "mutex", "shared_mutex", "atomic", "condition_variable", "future", "semaphore", "latch",
                "barrier", "stop_token", "pthread.h", "sched.h", "execution"],
    "files": ["fstream"],
    "system": ["fcntl.h", "unistd.h", "poll.h", "termios.h", "signal.h", "dlfcn.h", "netdb.h", "errno.h", "time.h", "malloc.h",
               "csignal", "sys/*", "linux/*", "net/*", "netinet/*", "arpa/*"],
    "intrinsics": ["immintrin.h", "x86intrin.h", "arm_neon.h"],
}

# Room -> project headers it may include (its own always), and libraries. The standard library's other headers are
# free. The longest room that a file lies in counts.
ROOMS = {
    "hal": ([], ["Eigen", "threads", "system"]),
    "config": (["hal/error.h"], ["yaml-cpp", "fmt", "files"]),
    "vision": (HAL_VALUES + ["config/*"], ["Eigen", "OpenCV", "qhull", "fmt", "expected", "Highway", "intrinsics"]),
    "nav/walking": (HAL_VALUES, ["Eigen", "fmt", "expected"]),
    "nav": (HAL_VALUES + ["hal/walker.h", "nav/walking/*", "vision/range_view.h", "vision/polytope.h", "config/*"],
            ["Eigen", "OctoMap", "fmt", "expected", "Highway", "intrinsics"]),
    "drivers": (["hal/*"], ["Eigen", "fmt", "expected", "threads", "system", "libusb", "libjpeg"]),
    "sim_hal": (["hal/*", "config/*", "nav/walking/*"], ["Eigen", "Embree", "fmt", "expected"]),
    "runtime/recording": (["hal/error.h", "hal/time.h", "config/*"], ["fmt", "system", "zstd", "zlib"]),
    "runtime": (["hal/*", "config/*", "vision/*", "nav/*", "runtime/recording/*"],
                ["Eigen", "fmt", "spdlog", "json", "expected", "threads", "system", "files", "zlib"]),
    "operator": (["hal/*", "runtime/*", "runtime/recording/*", "nav/body_outline.h"],
                 ["Eigen", "fmt", "spdlog", "json", "expected", "Boost", "OpenSSL", "libjpeg", "zlib", "threads", "system", "files"]),
    "app": (["*"], ["*"]),
}

# Files of these names in vision and nav may use file streams: they turn a path into values or values into a file.
FILE_READERS = ["*_file.h", "*_file.cpp", "*_files.h", "*_files.cpp"]

# What code (comments and texts taken out) may not say, in which rooms, and why. The last: files that may.
PHRASES = [
    (r"\bstd\s*::\s*(jthread|thread|async)\b|\bpthread_create\b",
     ["hal", "config", "vision", "nav", "drivers", "sim_hal", "runtime", "operator", "app"],
     "starts a thread; all threads stand in runtime/threads", ["runtime/threads.*"]),
    (r"\b(system|steady|high_resolution)_clock\b|\b(clock_gettime|gettimeofday|usleep|nanosleep)\b|\bsleep_(for)\b"
     r"|\bMonotonicClock\b|(?<![\w.>])time\s*\(\s*(NULL|nullptr|0|&\w+)\s*\)",
     ["hal", "config", "vision", "nav", "drivers", "sim_hal"],
     "reads a clock; time comes in as an argument or through hal::Clock", ["hal/clock.*", "hal/wall_clock.*"]),
    (r"(::|\.|->)\s*now\s*\(", ["config", "vision", "nav"],
     "asks what time it is; time comes in as an argument", []),
    (r"\bstd\s*::\s*random_device\b|\b(std\s*::\s*|(?<![\w:.>]))s?rand\s*\(|\bdrand48\b",
     ["hal", "config", "vision", "nav", "drivers", "sim_hal", "runtime", "operator", "app"],
     "draws numbers that no seed repeats", []),
]

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)


def room_of(path):
    """The room of a file or of an include, by the longest folder that is one."""
    rooms = [room for room in ROOMS if path.startswith(room + "/")]
    return max(rooms, key=len) if rooms else None


def library_of(header):
    for library, patterns in LIBRARIES.items():
        if any(fnmatch.fnmatch(header, pattern) for pattern in patterns):
            return library
    return None


def is_standard(header):
    """C++ headers have neither folder nor ending; of C's, only those with a C++ name."""
    return "/" not in header and "." not in header


def without_comments_and_texts(code):
    """Blanks them, keeping the lines."""
    pattern = re.compile(r'//[^\n]*|/\*.*?\*/|R"\((?:.*?)\)"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'', re.DOTALL)
    return pattern.sub(lambda m: re.sub(r"[^\n]", " ", m.group()), code)


def without_comments(code):
    pattern = re.compile(r'("(?:\\.|[^"\\\n])*")|//[^\n]*|/\*.*?\*/', re.DOTALL)
    return pattern.sub(lambda m: m.group(1) or re.sub(r"[^\n]", " ", m.group()), code)


def allowed(name, patterns):
    return any(fnmatch.fnmatch(name, pattern) for pattern in patterns)


def include_fault(file, quote, header, root):
    """Why `file` may not include `header`, or None."""
    room = room_of(file)
    headers, libraries = ROOMS[room]
    if quote == '"':
        target = room_of(header)
        if not (root / header).is_file():
            return f'"{header}" is not a file from the top folder'
        if target is None:
            return f'"{header}" lies in no room'
        if target == room or allowed(header, headers):
            return None
        return f'"{header}": {room} may not use this of {target}'
    if room_of(header):
        return f'<{header}> is a project header; write "{header}"'
    library = library_of(header)
    if library is None:
        return None if is_standard(header) else f"<{header}> belongs to no library of the table"
    if allowed(library, libraries):
        return None
    if library == "files" and allowed(pathlib.PurePath(file).name, FILE_READERS):
        return None
    return f"<{header}>: {room} may not use {library}"


def faults(root):
    """Every breach in the tree, as 'file:line: what'."""
    found = []
    for room in ROOMS:
        for path in sorted((root / room).glob("**/*")):
            file = path.relative_to(root).as_posix()
            if path.suffix not in (".h", ".cpp") or room_of(file) != room:
                continue
            text = path.read_text(encoding="utf-8")
            for match in INCLUDE.finditer(without_comments(text)):
                fault = include_fault(file, match[1], match[2], root)
                if fault:
                    found.append(f"{file}:{text.count(chr(10), 0, match.start(2)) + 1}: {fault}")
            code = without_comments_and_texts(text)
            for pattern, rooms, why, exempt in PHRASES:
                if not any(room == r or room.startswith(r + "/") for r in rooms) or allowed(file, exempt):
                    continue
                for match in re.finditer(pattern, code):
                    line = code.count("\n", 0, match.start()) + 1
                    found.append(f"{file}:{line}: '{match.group().strip()}' {why}")
    return found


class Layers(unittest.TestCase):
    def test_no_room_uses_what_the_table_does_not_allow(self):
        found = faults(ROOT)
        self.assertFalse(found, "\n" + "\n".join(found))

    def test_the_rooms_are_there(self):
        for room in ("hal", "vision", "nav", "drivers", "sim_hal", "runtime", "app"):
            self.assertTrue(list((ROOT / room).glob("*.h")), f"{room} holds no header: is the table out of date?")


class PlantedBreaches(unittest.TestCase):
    """On a tree where all is well but one line, exactly that line is found."""

    GOOD = {
        "hal/error.h": "#include <string>\n",
        "hal/time.h": "#include <chrono>\n",
        "hal/can_bus.h": '#include <atomic>\n#include "hal/time.h"\n',
        "hal/walker.h": '#include "hal/can_bus.h"\n',
        "hal/clock.cpp": "#include <ctime>\nvoid f() { clock_gettime(0, nullptr); }\n",
        "config/yaml_reader.h": '#include <yaml-cpp/yaml.h>\n#include "hal/error.h"\n',
        "vision/range_view.h": "#include <Eigen/Core>\n",
        "vision/matcher.cpp": '#include <opencv2/core.hpp>\n#include "vision/range_view.h"\n'
                              "// std::thread and ::now() in a comment, and in a text:\n"
                              'const char* k = "std::thread ::now()";\n',
        "vision/rig_files.cpp": "#include <fstream>\n",
        "nav/planner.h": '#include "hal/walker.h"\n#include "vision/range_view.h"\n#include <octomap/octomap.h>\n',
        "nav/walking/pattern.h": '#include "hal/time.h"\n',
        "drivers/head.h": '#include "hal/can_bus.h"\n',
        "sim_hal/robot.h": '#include "nav/walking/pattern.h"\n#include <embree3/rtcore.h>\n',
        "runtime/loop.h": '#include "nav/planner.h"\n#include "hal/can_bus.h"\n#include <thread>\n',
        "runtime/threads.cpp": "std::jthread t;\n",
        "app/main.cpp": '#include "drivers/head.h"\n#include "sim_hal/robot.h"\n#include <CLI/CLI.hpp>\n',
    }

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        for name, text in self.GOOD.items():
            self.write(name, text)

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def test_the_good_tree_has_none(self):
        self.assertEqual(faults(self.root), [])

    def test_each_breach_is_found(self):
        breaches = [
            ("hal/x.h", '#include "nav/planner.h"', "hal may not use"),
            ("hal/x.h", "#include <opencv2/core.hpp>", "hal may not use OpenCV"),
            ("config/x.h", '#include "hal/time.h"', "config may not use"),
            ("vision/x.h", '#include "nav/planner.h"', "vision may not use"),
            ("vision/x.h", '#include "hal/can_bus.h"', "vision may not use"),
            ("vision/x.h", '#include "hal/walker.h"', "vision may not use"),
            ("vision/x.h", "#include <mutex>", "vision may not use threads"),
            ("vision/x.h", "#include <fcntl.h>", "vision may not use system"),
            ("vision/x.cpp", "#include <fstream>", "vision may not use files"),
            ("vision/x.cpp", "auto t = std::chrono::steady_clock::now();", "clock"),
            ("vision/x.cpp", "auto t = clock.now();", "what time it is"),
            ("nav/x.h", '#include "vision/matcher.cpp"', "nav may not use"),
            ("nav/x.h", '#include "hal/can_bus.h"', "nav may not use"),
            ("nav/x.h", "#include <opencv2/core.hpp>", "nav may not use OpenCV"),
            ("nav/x.h", "#  include  <atomic>", "nav may not use threads"),
            ("nav/x.h", "#include <sys/mman.h>", "nav may not use system"),
            ("nav/walking/x.h", '#include "nav/planner.h"', "nav/walking may not use"),
            ("nav/walking/x.h", "#include <octomap/octomap.h>", "nav/walking may not use OctoMap"),
            ("nav/walking/x.h", "auto t = std::chrono::system_clock::now();", "clock"),
            ("drivers/x.h", '#include "sim_hal/robot.h"', "drivers may not use"),
            ("drivers/x.h", '#include "vision/range_view.h"', "drivers may not use"),
            ("sim_hal/x.h", '#include "drivers/head.h"', "sim_hal may not use"),
            ("sim_hal/x.h", '#include "nav/planner.h"', "sim_hal may not use"),
            ("sim_hal/x.h", '#include "vision/range_view.h"', "sim_hal may not use"),
            ("sim_hal/x.cpp", "std::mt19937_64 g(std::random_device{}());", "seed"),
            ("sim_hal/x.cpp", "int x = rand();", "seed"),
            ("runtime/x.h", '#include "drivers/head.h"', "runtime may not use"),
            ("runtime/x.h", '#include "sim_hal/robot.h"', "runtime may not use"),
            ("runtime/x.h", '#include "app/main.cpp"', "runtime may not use"),
            ("runtime/x.cpp", "std::thread t;", "starts a thread"),
            ("app/x.cpp", "auto f = std :: async(g);", "starts a thread"),
            ("app/x.cpp", "pthread_create(&t, 0, f, 0);", "starts a thread"),
            ("app/x.cpp", '#include "hal/absent.h"', "is not a file"),
            ("app/x.cpp", "#include <hal/error.h>", "is a project header"),
            ("nav/x.cpp", "#include <unknown/thing.h>", "belongs to no library"),
        ]
        for name, line, expected in breaches:
            with self.subTest(f"{name}: {line}"):
                self.write(name, f"#pragma once\n\n{line}\n")
                found = faults(self.root)
                (self.root / name).unlink()
                self.assertTrue(found)
                for fault in found:
                    self.assertTrue(fault.startswith(f"{name}:3: "), fault)
                self.assertIn(expected, " ".join(found))


if __name__ == "__main__":
    unittest.main()
