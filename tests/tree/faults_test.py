"""docs/faults.md names a test as proof of each fault: the tests are there, and so are the states."""

import itertools
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
TABLE = (ROOT / "docs/faults.md").read_text()
TEST = re.compile(r"\b(?:RC_GTEST_PROP|RC_GTEST_FIXTURE_PROP|TEST|TEST_F|TEST_P)\(\s*(\w+),\s*(\w+)")


def tests_in(text):
    return {f"{suite}.{name}" for suite, name in TEST.findall(text)}


def rows_with_proof(text):
    """The rows of all tables whose last column says what proves them."""
    rows, proven = [], False
    for before, line in itertools.pairwise(["", *text.splitlines()]):
        if line.startswith("|--"):
            proven = before.rstrip(" |").endswith("proven by")
        elif not line.startswith("|"):
            proven = False
        elif proven:
            rows.append(line)
    return rows


class Faults(unittest.TestCase):
    def test_every_row_names_tests_that_exist(self):
        known = set()
        for file in (ROOT / "tests").rglob("*_test.cpp"):
            known |= tests_in(file.read_text())
        rows = rows_with_proof(TABLE)
        self.assertGreater(len(rows), 30)
        for row in rows:
            named = re.findall(r"`(\w+\.\w+)`", row.rstrip(" |").split("|")[-1])
            self.assertTrue(named, f"no test proves: {row}")
            for name in named:
                self.assertIn(name, known)

    def test_every_state_exists(self):
        sources = "\n".join(file.read_text() for room in ("hal", "nav", "runtime") for file in (ROOT / room).glob("*.h"))
        for kind, value in set(re.findall(r"`(\w+)::(\w+)(?:\(\))?`", TABLE)):
            body = re.search(rf"\b(?:enum class|struct|class) {kind}\b[^;{{]*{{(.*?)\n}};", sources, re.DOTALL)
            self.assertTrue(body, kind)
            self.assertRegex(body[1], rf"\b{value}\b", f"{kind}::{value}")

    def test_only_tables_of_proofs_are_read(self):
        text = "| fault | proven by |\n|---|---|\n| a | `A.B` |\n\n| kind | keys |\n|---|---|\n| c | d |\n"
        self.assertEqual(rows_with_proof(text), ["| a | `A.B` |"])

    def test_an_unknown_test_is_found(self):
        self.assertEqual(tests_in("TEST(A, B) {\nRC_GTEST_PROP(C,\n              D, ()) {"), {"A.B", "C.D"})


if __name__ == "__main__":
    unittest.main()
