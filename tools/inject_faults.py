#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Puts one-line faults into the library, one at a time, and reports which of them the tests catch.

All faults of tools/faults/*.txt are put into a copy of the project at once, each behind a switch that the environment
variable KALFEM_FAULT turns on by its number, so that they cost one build together:

    python3 tools/inject_faults.py check                       whether each fault has its place in the sources
    python3 tools/inject_faults.py prepare build/faults        copy the project and put the faults in
    python3 tools/inject_faults.py build build/faults          configure and build what the faults need
    python3 tools/inject_faults.py run build/faults            run the tests of each fault, and all of them without one
    python3 tools/inject_faults.py list                        what is in the table

A fault is caught when one of its test programs fails, ends by a signal or runs out of time. Without a fault they must pass.

A file of faults names its test programs in lines "tests: wiring_test, system_test:Gap*" (after the colon a filter of
GoogleTest). A line "in src/kalfem/...cpp:" says where the next faults go, and each fault is one line

    <text> => <other text>           an expression, or a statement with its semicolon
    VectorXd: <text> => <other>      an expression whose two forms have different types: both are converted

[[ ]] marks the part that is replaced where the rest of the text only says where it is. The text must stand in the file exactly
once. "\\n" is a line end; blanks around the arrow do not count. Lines that begin with # are comments.
"""

import argparse
import os
import pathlib
import re
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

PROJECT = pathlib.Path(__file__).resolve().parent.parent
SWITCH = """#include <cstdlib>
[[maybe_unused]] static bool kalfem_fault(int number) {
  static const int on = std::getenv("KALFEM_FAULT") ? std::atoi(std::getenv("KALFEM_FAULT")) : 0;
  return on == number;
}
"""


@dataclass
class Fault:
    number: int
    group: str
    file: str
    text: str
    other: str
    tests: list
    kind: str = ""

    def title(self):
        text, other = (" ".join(part.split()) for part in (self.text, self.other))
        return f"{self.number:3d} {self.group:9s} {pathlib.Path(self.file).name}: {text} => {other}"


def read_table():
    faults = []
    for path in sorted((PROJECT / "tools" / "faults").glob("*.txt")):
        tests, file = [], ""
        for place, line in enumerate(path.read_text().splitlines(), 1):
            line = line.strip()
            if not line or line.startswith("#"):
                continue
            if line.startswith("tests:"):
                tests = [name.strip() for name in line[6:].split(",")]
            elif line.startswith("in ") and line.endswith(":"):
                file = line[3:-1].strip()
            elif " =>" in line:
                text, other = line.split(" =>", 1)
                kind = re.match(r"((?:Eigen::)?[A-Z]\w+): ", text)
                if kind:
                    text = text[kind.end():]
                text, other = (part.strip().replace("\\n", "\n") for part in (text, other))
                faults.append(Fault(len(faults) + 1, path.stem, file, text, other, tests, kind.group(1) if kind else ""))
            else:
                sys.exit(f"{path}:{place}: this line says nothing: {line}")
    return faults


def switched(fault, text):
    """The text with its fault behind a switch."""
    on = f"kalfem_fault({fault.number})"
    if text.rstrip().endswith(";"):
        return f"{{ if ({on}) {{ {fault.other} }} else {{ {text} }} }}"
    if fault.kind:
        return f"({on} ? {fault.kind}({fault.other}) : {fault.kind}({text}))"
    return f"({on} ? ({fault.other}) : ({text}))"


def place_of(fault, source, problems):
    """Begin and end of the text that the fault replaces; (0, 0) and a problem where it does not stand there once."""
    marked = re.match(r"(.*)\[\[(.*)\]\](.*)", fault.text, re.DOTALL)
    before, text, after = marked.groups() if marked else ("", fault.text, "")
    count = source.count(before + text + after)
    if count != 1:
        problems.append(f"{fault.file}: this text stands there {count} times: {before + text + after}")
        return 0, 0
    begin = source.index(before + text + after) + len(before)
    return begin, begin + len(text)


def put_in(faults, source, problems):
    """The source with all these faults in it."""
    last = len(source)
    places = [(place_of(fault, source, problems), fault) for fault in faults]
    for (begin, end), fault in sorted(places, key=lambda each: each[0], reverse=True):
        if end == 0:
            continue
        if end > last:
            problems.append(f"{fault.file}: two faults in one text: {source[begin:end]}")
            continue
        last = begin
        source = source[:begin] + switched(fault, source[begin:end]) + source[end:]
    return SWITCH + source


def write_if_other(path, content):
    if path.exists() and path.read_bytes() == content:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)


def with_faults(faults):
    """The sources that faults belong to, with all of them in it: {file: content}. Ends where one has no place."""
    by_file = {}
    for fault in faults:
        by_file.setdefault(fault.file, []).append(fault)
    problems = [f"there is no file {name}" for name in by_file if not (PROJECT / name).is_file()]
    contents = {
        name: put_in(own, (PROJECT / name).read_text(), problems).encode() for name, own in by_file.items() if (PROJECT / name).is_file()
    }
    if problems:
        sys.exit("\n".join(problems))
    print(f"{len(faults)} faults in {len(by_file)} files")
    return contents


def prepare(folder, faults):
    changed = with_faults(faults)
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=PROJECT, capture_output=True, text=True, check=True)
    for name in listed.stdout.splitlines():
        if (PROJECT / name).is_file():
            write_if_other(folder / name, changed[name] if name in changed else (PROJECT / name).read_bytes())


def programs(faults):
    return sorted({test.split(":")[0] for fault in faults for test in fault.tests})


def build(folder, faults, jobs):
    if not (folder / "build/release/build.ninja").exists():
        subprocess.run(["cmake", "--preset", "release", "-DKALFEM_TESTS=ON"], cwd=folder, check=True)
    subprocess.run(["ninja", f"-j{jobs}", *programs(faults)], cwd=folder / "build/release", check=True)


def passes(folder, test, number, limit):
    program, _, chosen = test.partition(":")
    command = [str(folder / "build/release/tests" / program), "--gtest_brief=1", "--gtest_fail_fast"]
    if chosen:
        command.append("--gtest_filter=" + chosen)
    environment = {**os.environ, "KALFEM_FAULT": str(number), "OPENBLAS_NUM_THREADS": "1"}
    try:
        done = subprocess.run(command, env=environment, capture_output=True, timeout=limit, check=False)
        return done.returncode == 0
    except subprocess.TimeoutExpired:
        return False


class Limits:
    """Time that each test may take, from a run without a fault, which must pass; made when it is first asked for."""

    def __init__(self, folder):
        self.folder, self.lock, self.limits = folder, threading.Lock(), {}

    def of(self, test):
        with self.lock:
            if test not in self.limits:
                begin = time.time()
                if not passes(self.folder, test, 0, 1200):
                    raise RuntimeError(f"{test} fails without a fault")
                self.limits[test] = 20 + 10 * (time.time() - begin)
            return self.limits[test]


def run(folder, faults, jobs):
    limits = Limits(folder)

    def judge(fault):
        return next((test for test in fault.tests if not passes(folder, test, fault.number, limits.of(test))), None)

    caught = {}
    with ThreadPoolExecutor(jobs) as pool:
        for fault, test in zip(faults, pool.map(judge, faults)):
            caught.setdefault(fault.group, []).append(test is not None)
            print(("caught  " if test else "MISSED  ") + fault.title() + (f"   [{test}]" if test else ""), flush=True)
    for group, results in caught.items():
        print(f"{group}: {sum(results)} of {len(results)} caught ({100.0 * sum(results) / len(results):.1f} %)")
    return all(all(results) for results in caught.values())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("command", choices=["check", "prepare", "build", "run", "list"])
    parser.add_argument("folder", nargs="?", type=pathlib.Path, default=PROJECT / "build/faults")
    parser.add_argument("--only", help="numbers of faults, such as 3,7-12, or a group")
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
    everything = read_table()
    chosen = everything
    if given.only and not given.only[0].isdigit():
        chosen = [fault for fault in everything if fault.group == given.only]
    elif given.only:
        numbers = set()
        for part in given.only.split(","):
            first, _, last = part.partition("-")
            numbers.update(range(int(first), int(last or first) + 1))
        chosen = [fault for fault in everything if fault.number in numbers]
    if given.command == "list":
        print("\n".join(fault.title() for fault in chosen))
    elif given.command == "check":
        with_faults(everything)
    elif given.command == "prepare":
        prepare(given.folder, everything)
    elif given.command == "build":
        build(given.folder, everything, given.jobs)
    elif not run(given.folder, chosen, given.jobs):
        sys.exit(1)


if __name__ == "__main__":
    main()
