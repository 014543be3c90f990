"""docs/faults.md names a test as proof of each fault: the tests are there, and so are the states."""

import itertools
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
TABLE = (ROOT / "docs/faults.md").read_text()
TEST = re.compile(r"\b(?:RC_GTEST_PROP|RC_GTEST_FIXTURE_PROP|TEST|TEST_F|TEST_P)\(\s*(\w+),\s*(\w+)")


def tests_in(text):
    """Each with its text."""
    return {f"{found[1]}.{found[2]}": text[found.start() : text.find("\n}\n", found.end())] for found in TEST.finditer(text)}


def known_tests():
    return {name: body for file in (ROOT / "tests").rglob("*_test.cpp") for name, body in tests_in(file.read_text()).items()}


def named_in(row):
    return re.findall(r"`(\w+\.\w+)`", row.rstrip(" |").split("|")[-1])


def unproven_states(row, tests):
    """The states beside the fault's name that occur in none of the tests that the row names."""
    bodies = "\n".join(tests.get(name, "") for name in named_in(row))
    states = re.findall(r"`\w+::(k\w+)`", "|".join(row.split("|")[2:-2]))
    return [state for state in states if not re.search(rf"\b{state}\b", bodies)]


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
        known = known_tests()
        rows = rows_with_proof(TABLE)
        self.assertGreater(len(rows), 30)
        for row in rows:
            named = named_in(row)
            self.assertTrue(named, f"no test proves: {row}")
            for name in named:
                self.assertIn(name, known)

    def test_every_state_occurs_in_a_test_that_its_row_names(self):
        known = known_tests()
        for row in rows_with_proof(TABLE):
            self.assertEqual(unproven_states(row, known), [], row)

    def test_a_state_that_no_named_test_looks_at_is_found(self):
        row = "| `K::kFault` | at once | `K::kLost`, `K::kGone` | – | `A.B` |"
        self.assertEqual(unproven_states(row, {"A.B": "is(K::kLost)", "C.D": "is(K::kGone)"}), ["kGone"])

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
        text = "TEST(A, B) {\n  b;\n}\n\nRC_GTEST_PROP(C,\n              D, ()) {\n  d;\n}\n"
        self.assertEqual(tests_in(text), {"A.B": "TEST(A, B) {\n  b;", "C.D": "RC_GTEST_PROP(C,\n              D, ()) {\n  d;"})


if __name__ == "__main__":
    unittest.main()
