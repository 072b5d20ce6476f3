#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Runs what a page of the documentation shows: commands, cases, programs.

    run_blocks.py PAGE --build BUILD [--python FOLDER] [--compile COMMAND]    run the page's blocks
    run_blocks.py --accept PAGE ... --build BUILD ...                         and writes what they print into the pages
    run_blocks.py --not-run PAGE ...                                          list the blocks that no test runs

A page runs in a copy of the examples. Shell blocks and Python blocks run as they stand, cases pass `kalfem check`, C++
blocks compile as one program; page_blocks.py lists the marks by which a page says more. Measured data are in
$KALFEM_DATA, by default in ../shared/data. A page with Python is skipped (exit code 77) where the package is not built.
With CI=true all must be there.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import case_blocks
from outputs import first_difference, refreshed
from page_blocks import BadPage, blocks_of_text

PROJECT = Path(__file__).resolve().parents[2]
MOST_NOT_RUN = 13
SKIPPED = 77
NEXT_BLOCK = "-- the next block prints:"


class Different(Exception):
    """A block that does not do what the page says."""


def blocks_of(page):
    try:
        return blocks_of_text(page.read_text())
    except BadPage as problem:
        sys.exit(f"{page}: {problem}")


def data_folder():
    return Path(os.environ.get("KALFEM_DATA") or PROJECT.parent / "shared/data").resolve()


class PageRun:
    """The blocks of one page, run one after the other in a folder of their own."""

    def __init__(self, blocks, folder, tools):
        self.blocks, self.folder, self.tools = blocks, folder, tools
        self.printed = {}  # number of a block -> its output
        self.environment = {
            **os.environ,
            "PATH": os.pathsep.join([str(tools.build.resolve() / "bin"), os.environ["PATH"]]),
            "PYTHONPATH": str(tools.python.resolve() if tools.python else ""),
            "KALFEM_DATA": str(data_folder()),
            "MPLBACKEND": "Agg",
        }
        shutil.copytree(PROJECT / "examples", folder / "examples")
        (folder / "build").mkdir()
        (folder / "build/release").symlink_to(tools.build.resolve())

    def run(self, *command, code=0):
        done = subprocess.run(
            command, cwd=self.folder, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        if done.returncode != code:
            raise Different(f"exit code {done.returncode}, not {code}\n{done.stdout}")
        return done.stdout

    def shell(self, number):
        block = self.blocks[number]
        code = int(block.marks.get("exits with", 0))
        self.printed[number] = self.run("bash", "-ec", block.marks.get("before", "") + "\n" + block.text, code=code)

    def case(self, block):
        """A whole case, or a part in the place where it belongs; without its files it may only lack these."""
        base = self.folder / block.marks.get("in", "case.yaml").split(" at ")[0]
        text = block.text
        if "in" in block.marks:
            place = (block.marks["in"].split(" at ") + [""])[1]
            text = case_blocks.completed(text, base.read_text(), place, block.marks.get("without", ""))
        elif not case_blocks.is_whole(text):
            raise Different("a part of a case: say of which one, <!-- in: examples/chain/chain.yaml -->")
        file = self.folder / block.marks["file"] if "file" in block.marks else base.with_name("page.yaml")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        if "absent" not in block.marks:
            self.run("kalfem", "check", str(file))
            return
        printed = self.run("kalfem", "check", str(file), code=2)
        absent = [name.strip() for name in block.marks["absent"].split(",")]
        complaints = [line for line in printed.splitlines() if line.startswith(str(self.folder))]
        other = [line for line in complaints if not any(name in line for name in absent)]
        if other or not complaints:
            raise Different("\n".join(other) or printed)

    def python(self):
        """The page's blocks of Python are one program."""
        numbers = self.numbers_of("python")
        text = "".join(
            f"print({NEXT_BLOCK!r})\n{self.blocks[n].marks.get('before', '')}\n{self.blocks[n].text}\n" for n in numbers
        )
        (self.folder / "page.py").write_text(text)
        parts = self.run(sys.executable, "page.py").split(NEXT_BLOCK + "\n")[1:]
        self.printed |= dict(zip(numbers, parts))

    def cpp(self):
        """The page's blocks of C++ are one program, which is compiled against the public headers."""
        lines = "".join(
            self.blocks[n].marks.get("before", "") + "\n" + self.blocks[n].text for n in self.numbers_of("cpp")
        ).splitlines()
        first = [line for line in lines if line.startswith(("#include", "using namespace"))]
        body = [line for line in lines if line not in first]
        (self.folder / "page.cpp").write_text("\n".join([*first, "int main() {", *body, "}", ""]))
        self.run(*self.tools.compile.split(), "page.cpp")

    def numbers_of(self, language):
        return [n for n, block in enumerate(self.blocks) if block.language == language and self.runs(block)]

    def runs(self, block):
        return "not run" not in block.marks and (
            "data" not in block.marks or (data_folder() / block.marks["data"]).is_dir()
        )

    def compare(self, number):
        shown = self.blocks[number].text
        if number not in self.numbers_of("text") or self.blocks[number - 1].language not in ("sh", "python"):
            raise Different("an output is text below a block that prints it")
        if number - 1 not in self.printed:  # not run, or it failed
            return
        if (line := first_difference(shown, self.printed[number - 1])) is not None:
            raise Different(f"the output has no such line, or not here:\n  {line}\nIt is\n{self.printed[number - 1]}")

    def do(self, number):
        """One block; the first of Python or C++ does all of its language."""
        block = self.blocks[number]
        if "output" in block.marks:
            self.compare(number)
        elif block.language == "sh":
            self.shell(number)
        elif block.language == "yaml":
            self.case(block)
        elif block.language in ("python", "cpp"):
            if number == self.numbers_of(block.language)[0]:
                getattr(self, block.language)()
        elif "file" in block.marks:
            (self.folder / block.marks["file"]).write_text(block.text)


@dataclass
class Tools:
    """What the blocks are run with."""

    build: Path  # has bin/kalfem
    python: Path | None = None  # the folder of the Python package
    compile: str = ""


def accept(page, run):
    """Writes what the blocks printed into the page, in the places of what it shows."""
    text = page.read_text()
    for number, block in enumerate(run.blocks):
        if "output" in block.marks and block.text and number - 1 in run.printed:
            text = text.replace(block.text, refreshed(block.text, run.printed[number - 1]))
    page.write_text(text)


def run_page(page, tools, accepts=False):
    """What is wrong with each block, and how many ran."""
    blocks = blocks_of(page)
    problems, ran = [], 0
    with tempfile.TemporaryDirectory(prefix="kalfem-docs-") as scratch:
        run = PageRun(blocks, Path(scratch), tools)
        for number, block in enumerate(blocks):
            if not run.runs(block):
                if "data" in block.marks:
                    absent = f"{page}:{block.line}: {data_folder() / block.marks['data']} is absent"
                    print(absent)
                    problems += [absent] if os.environ.get("CI") == "true" else []
                continue
            try:
                run.do(number)
                ran += 1
            except Different as problem:
                problems.append(f"{page}:{block.line}: {problem}")
        if accepts:
            accept(page, run)
    return problems, ran


def list_not_run(pages):
    lines = [
        f"{page}:{block.line}: {block.marks['not run']}"
        for page in pages
        for block in blocks_of(page)
        if "not run" in block.marks
    ]
    print("\n".join([f"{len(lines)} blocks are not run:", *lines]))
    if len(lines) > MOST_NOT_RUN:
        sys.exit(f"more than {MOST_NOT_RUN}: make them run, or leave them out")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pages", nargs="+", type=Path)
    parser.add_argument("--build", type=Path, default=PROJECT / "build/release", help="the folder of bin/kalfem")
    parser.add_argument("--python", type=Path, help="the folder of the Python package")
    parser.add_argument("--compile", default="", help="compiler with flags, to which the C++ program is given")
    parser.add_argument("--not-run", action="store_true")
    parser.add_argument("--accept", action="store_true")
    arguments = parser.parse_args()
    if arguments.not_run:
        return list_not_run(arguments.pages)
    tools = Tools(arguments.build, arguments.python, arguments.compile)
    for page in arguments.pages:
        if not tools.python and "```python" in page.read_text() and os.environ.get("CI") != "true":
            print(f"{page}: the Python package is not built; scripts/python builds it")
            sys.exit(SKIPPED)
        problems, ran = run_page(page, tools, arguments.accept)
        print(f"{page}: {ran} blocks ran")
        if problems:
            sys.exit("\n".join(problems))


if __name__ == "__main__":
    main()
