#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs clang-tidy on the sources of the libraries and the command that have changed.

    tools/tidy.py BUILD [--all] [--most N]

BUILD is a configured build folder. Changed is what differs from origin/main, and where nothing does, from the commit
before. An Eigen file costs half a minute of one core, as clang-tidy walks through all of its headers: of many changed
files those with most changed lines are taken, at most N (6), and the others are counted. --all takes every source.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

root = pathlib.Path(__file__).resolve().parent.parent
# clang-tidy walks the whole of a precompiled header; without it, only the headers that a file includes.
PRECOMPILED = r"-Winvalid-pch|-fpch-instantiate-templates|-Xclang -include(-pch)? -Xclang \S+|-Xclang -fno-pch-timestamp"


def git(*arguments):
    done = subprocess.run(["git", "-C", root, *arguments], capture_output=True, text=True)
    return done.stdout.splitlines() if done.returncode == 0 else []


def changed_sources():
    """Sources that differ, those with most changed lines first."""
    for since in ("origin/main", "HEAD~1"):
        lines = [line.split("\t") for line in git("diff", "--numstat", "--diff-filter=d", since, "--", "src/*.cpp", "apps/*.cpp")]
        lines.sort(key=lambda line: -int(line[0]) if line[0].isdigit() else 0)
        if lines:
            return [root / line[2] for line in lines]
    return []


def database(build):
    """The compile commands by file, without precompiled headers."""
    entries = json.loads((build / "compile_commands.json").read_text())
    for entry in entries:
        entry["command"] = re.sub(PRECOMPILED, "", entry["command"])
    return {pathlib.Path(entry["file"]): entry for entry in entries}


def run(command, folder, file):
    done = subprocess.run([command, "--quiet", "-p", folder, "--warnings-as-errors=*", str(file)], capture_output=True, text=True)
    return file, done.returncode, done.stdout + (done.stderr if done.returncode and not done.stdout else "")


def main():
    options = argparse.ArgumentParser()
    options.add_argument("build", type=pathlib.Path)
    options.add_argument("--all", action="store_true")
    options.add_argument("--most", type=int, default=6)
    options.add_argument("--command", default="clang-tidy-16")
    given = options.parse_args()
    entries = database(given.build)
    files = [file for file in (entries if given.all else changed_sources())
             if file in entries and not file.is_relative_to(root / "tests") and not file.is_relative_to(given.build.resolve())]
    chosen = files if given.all else files[:given.most]
    if len(chosen) < len(files):
        print(f"clang-tidy: {len(files)} sources have changed, the {len(chosen)} most changed ones are checked")
    failed = 0
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        (pathlib.Path(folder) / "compile_commands.json").write_text(json.dumps([entries[file] for file in chosen]))
        for file, code, text in pool.map(lambda file: run(given.command, folder, file), chosen):
            failed += code != 0
            if code:
                print(text or f"clang-tidy failed on {file}")
    print(f"clang-tidy: {len(chosen)} files, {failed} with findings")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
