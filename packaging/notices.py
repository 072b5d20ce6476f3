#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The licences and notices of what goes with a program, as its Debian packages state them, into a folder: a file for
each that differs, and which packages it is of in packages.txt.

    notices.py FOLDER < LIBRARIES      LIBRARIES: a path a line, as bundle.py prints them
"""
import pathlib
import sys

from sbom import HEADERS, package_of


def main():
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    names = {package_of(file).split(":")[0] for file in sys.stdin.read().split()} | set(HEADERS)
    first, lines = {}, []
    for name in sorted(names):
        text = pathlib.Path(f"/usr/share/doc/{name}/copyright").read_text()
        place = first.setdefault(text, f"{name}.txt")
        (folder / place).write_text(text)
        lines.append(f"{name}: {place}\n")
    (folder / "packages.txt").write_text("".join(lines))


if __name__ == "__main__":
    main()
