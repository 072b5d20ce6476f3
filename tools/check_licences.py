#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Whether every source says its licence; with --add, says it where it is missing.

    check_licences.py [--add] FOLDER
"""
import argparse
import pathlib
import sys

TAG = "SPDX-License-Identifier: Apache-2.0"
COMMENT = {".c": "/*", ".cpp": "//", ".hpp": "//", ".py": "#", ".cmake": "#", ".mjs": "//", ".js": "//", ".css": "/*", ".sh": "#"}
FOLDERS = ("apps", "benchmarks", "cmake", "examples", "packaging", "python", "scripts", "src", "tests", "tools")
FIRST_LINES = 3  # behind `#!` and an encoding


def comment_of(file):
    """The beginning of a comment in this kind of source; nothing for what is none."""
    if file.name == "CMakeLists.txt" or file.parent.name == "scripts":
        return "#"
    return COMMENT.get(file.suffix)


def sources(folder):
    for name in FOLDERS:
        for file in sorted((folder / name).rglob("*")):
            foreign = {"corpus", "node_modules", "__pycache__"} & set(file.parts)
            if file.is_file() and not foreign and comment_of(file):
                yield file


def is_tagged(file):
    return any(TAG in line for line in file.read_text().splitlines()[:FIRST_LINES])


def add_tag(file):
    lines = file.read_text().splitlines(keepends=True)
    opening = comment_of(file)
    closing = " */" if opening == "/*" else ""
    place = 1 if lines and lines[0].startswith("#!") else 0
    lines.insert(place, f"{opening} {TAG}{closing}\n")
    file.write_text("".join(lines))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--add", action="store_true")
    parser.add_argument("folder", type=pathlib.Path)
    arguments = parser.parse_args()
    untagged = [file for file in sources(arguments.folder) if not is_tagged(file)]
    for file in untagged:
        if arguments.add:
            add_tag(file)
        else:
            print(f"{file}:1: it does not say its licence; add '{comment_of(file)} {TAG}'")
    return 1 if untagged and not arguments.add else 0


if __name__ == "__main__":
    sys.exit(main())
