"""docs/architecture.md shows the table of safety states as runtime/safety_table.h has it."""

import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


def rows(text, pattern, separator):
    return {name: [cell.strip().removeprefix("k") for cell in cells.strip(separator + " ").split(separator)]
            for name, cells in re.findall(pattern, text, re.MULTILINE)}


def table_in_code():
    text = (ROOT / "runtime/safety_table.h").read_text()
    return rows(text, r"/\* (\w+)\s*\*/ \{(.*)\},$", ",")


def table_in_document():
    text = (ROOT / "docs/architecture.md").read_text()
    section = text.partition("### Safety\n")[2].partition("\n### ")[0]
    return rows(section, r"^\| (\w+) \|(.*)\|$", "|")


class SafetyTable(unittest.TestCase):
    def test_the_document_shows_what_the_code_has(self):
        self.assertEqual(len(table_in_code()), 6)
        self.assertEqual(table_in_document(), table_in_code())


if __name__ == "__main__":
    unittest.main()
