# SPDX-License-Identifier: Apache-2.0
"""The runner of the pages' blocks finds what is wrong with a page.

    KALFEM_BUILD=build/release python3 -m unittest tests/docs/test_run_blocks.py
"""

import os
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from outputs import first_difference, refreshed  # noqa: E402
from page_blocks import BadPage, blocks_of_text  # noqa: E402
from run_blocks import Tools, run_page  # noqa: E402
from run_notebook import difference, left_out, run  # noqa: E402


def block(language, text, marks=""):
    return f"{marks}\n```{language}\n{text}\n```\n"


def problems_of(*blocks):
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "page.md"
        page.write_text("Some words.\n\n" + "\n".join(blocks))
        return run_page(page, Tools(Path(os.environ["KALFEM_BUILD"])))[0]


class Outputs(unittest.TestCase):
    def test_numbers_agree_to_the_digits_shown(self):
        self.assertIsNone(first_difference("NIS 3.99 of 20,000", "a line\nNIS  3.9871 of 20,000\n"))
        self.assertEqual(first_difference("NIS 3.99", "NIS 3.97"), "NIS 3.99")
        self.assertIsNone(first_difference("nodes 117, 96 in a3", "nodes 117, 96 in a3"))
        self.assertEqual(first_difference("nodes 117, 96 in a3", "nodes 117, 98 in a3"), "nodes 117, 96 in a3")
        self.assertEqual(first_difference("f 1.2e-3 Hz", "f 1.4e-3 Hz"), "f 1.2e-3 Hz")

    def test_words_do_not_change(self):
        self.assertEqual(first_difference("Verdict: consistent", "Verdict: unusable"), "Verdict: consistent")

    def test_lines_follow_each_other_unless_dots_stand_between(self):
        self.assertEqual(first_difference("one\nthree", "one\ntwo\nthree"), "three")
        self.assertIsNone(first_difference("one\n...\nthree", "one\ntwo\nthree"))
        self.assertEqual(first_difference("three\n...\none", "one\ntwo\nthree"), "one")

    def test_dots_within_a_line_are_any_text(self):
        self.assertIsNone(first_difference("run ... took 3 s", "run 00ab took 3 s"))
        self.assertIsNotNone(first_difference("run ... took 3 s", "run 00ab took 5 s"))


class RefreshedOutputs(unittest.TestCase):
    def test_lines_are_those_most_like_them(self):
        shown = "k kN/m 17.9\n...\n\nVerdict: ...\nerror 0.3 mm"
        printed = "title\nk N/m 17991\nc N s/m 3\nVerdict: consistent\nerror 0.31 m\n"
        self.assertEqual(refreshed(shown, printed), "k N/m 17991\n...\n\nVerdict: ...\nerror 0.31 m\n")

    def test_what_agrees_stays(self):
        self.assertEqual(refreshed("k  17.9", "k 17.91"), "k  17.9\n")


class Pages(unittest.TestCase):
    def test_a_right_page(self):
        shown = block("text", "2.50 m", "<!-- output -->")
        self.assertEqual(
            problems_of(
                block("sh", "echo 2.5 m"),
                shown,
                block("python", "x = 1"),
                block("python", "print(x + 1)"),
                block("text", "2", "<!-- output -->"),
            ),
            [],
        )

    def test_commands_that_fail(self):
        self.assertIn("exit code 4, not 0", problems_of(block("sh", "exit 4"))[0])
        self.assertEqual(problems_of(block("sh", "exit 4", "<!-- exits with: 4 -->")), [])

    def test_outputs_that_differ(self):
        self.assertIn("no such line", problems_of(block("sh", "echo 2.5"), block("text", "2.7", "<!-- output -->"))[0])

    def test_outputs_of_nothing(self):
        self.assertIn("below a block that prints", problems_of(block("text", "2.5", "<!-- output -->"))[0])

    def test_programs_that_fail(self):
        self.assertIn("NameError", problems_of(block("python", "unknown"))[0])

    def test_whole_cases(self):
        case = (Path(__file__).parents[2] / "examples/start/chain/case.yaml").read_text()
        self.assertEqual(problems_of(block("yaml", case)), [])
        self.assertIn("durations", problems_of(block("yaml", case.replace("duration:", "durations:")))[0])

    def test_parts_of_cases(self):
        place = "<!-- in: examples/start/chain/case.yaml -->"
        self.assertEqual(problems_of(block("yaml", "simulate: {duration: 3 s}", place)), [])
        self.assertIn("durations", problems_of(block("yaml", "simulate: {durations: 3 s}", place))[0])
        self.assertIn("a part of a case", problems_of(block("yaml", "simulate: {duration: 3 s}"))[0])

    def test_sections_of_parts(self):
        place = "<!-- in: examples/start/chain/case.yaml at substructures.wheel.springs.0 -->"
        self.assertEqual(problems_of(block("yaml", "stiffness: 30 kN/m", place)), [])
        self.assertIn("kHz", problems_of(block("yaml", "stiffness: 30 kHz", place))[0])

    def test_files_of_the_reader_are_the_only_ones_that_may_lack(self):
        marks = "<!-- in: examples/start/measured/case.yaml -->\n<!-- absent: mine.csv -->"
        self.assertEqual(problems_of(block("yaml", "record: {file: mine.csv}", marks)), [])
        self.assertIn("ends", problems_of(block("yaml", "record: {file: mine.csv, ends: 3 s}", marks))[0])

    def test_marks_are_known(self):
        with self.assertRaisesRegex(BadPage, "line 2: 'outputs' is no mark"):
            blocks_of_text(block("text", "1", "<!-- outputs -->"))

    def test_commands_are_fenced(self):
        with self.assertRaisesRegex(BadPage, "line 3"):
            blocks_of_text("Try this:\n\n    kalfem run case.yaml\n")


def cell(text, shown="", tags=()):
    outputs = [{"text": [shown]}] if shown else []
    return {"cell_type": "code", "metadata": {"tags": list(tags)}, "source": [text], "outputs": outputs}


class Notebooks(unittest.TestCase):
    def test_cells_share_their_names(self):
        cells = [cell("x = 2.5"), {"cell_type": "markdown", "metadata": {}, "source": ["Words"]}, cell("print(x + 1)")]
        self.assertEqual(run({"cells": cells}), ["", "3.5\n"])

    def test_outputs_agree_to_the_digits_shown(self):
        self.assertIsNone(difference(cell("", "k = 2.5\n"), "k = 2.51\n"))
        self.assertIn("printed was", difference(cell("", "k = 2.5\n"), "k = 2.7\n"))

    def test_outputs_are_whole(self):
        self.assertIsNotNone(difference(cell("", "one\n"), "one\ntwo\n"))
        self.assertIsNotNone(difference(cell(""), "one\n"))

    def test_cells_that_fail_say_so(self):
        with self.assertRaises(NameError):
            run({"cells": [cell("unknown")]})

    def test_cells_of_an_absent_package_are_left_out(self):
        self.assertEqual(left_out(cell("", tags=["no_such_package"])), "no_such_package")
        self.assertIsNone(left_out(cell("", tags=["json"])))


if __name__ == "__main__":
    unittest.main()
