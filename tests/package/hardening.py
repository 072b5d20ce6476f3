#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reads every program, Python module and shared library of a build folder, and says which of them can be turned
against its user: a search path that depends on the current folder, or compiled without the usual protection.

    hardening.py BUILD_FOLDER [--compiler cc]

The check is first tried on programs that are made wrong on purpose. Programs of the tests are left out.
"""
import argparse
import os
import pathlib
import re
import stat
import subprocess
import sys
import tempfile

LEFT_OUT = {"CMakeFiles", "tests", "_deps", "benchmarks", "docs", "node_modules"}
# Functions that _FORTIFY_SOURCE replaces by name_chk wherever the compiler knows the size of the target.
# Copies of memory whose size the compiler does not know stay as they are.
FORTIFIED = {"strcpy", "strncpy", "strcat", "sprintf", "snprintf", "vsnprintf", "printf",
             "fprintf", "vfprintf", "read", "fread", "realpath", "gethostname", "getcwd"}


def readelf(file, *options):
    return subprocess.run(["readelf", "-W", *options, file], capture_output=True, text=True, check=False).stdout


def elf_files(folder):
    """Executables and shared objects below a folder, tests and objects aside."""
    for path in sorted(folder.rglob("*")):
        if LEFT_OUT & set(path.relative_to(folder).parts) or path.suffix in {".o", ".a", ".pch", ".gch"}:
            continue
        if path.is_symlink() or not path.is_file():
            continue
        with path.open("rb") as file:
            if file.read(4) == b"\x7fELF":
                yield path


def search_path_problems(dynamic):
    for kind, elements in re.findall(r"\((RPATH|RUNPATH)\).*?\[(.*)\]", dynamic):
        for element in elements.split(":"):
            if element.startswith("$ORIGIN") or element.startswith("${ORIGIN}"):
                continue
            if not element.startswith("/"):
                yield f"{kind} '{elements}' has the element '{element}': libraries are looked for in the current folder"
            elif os.path.isdir(element) and os.stat(element).st_mode & stat.S_IWOTH:
                yield f"{kind} '{elements}' has the element '{element}', into which everybody may write"


def protection_problems(header, dynamic, segments, symbols):
    if "Type:" in header and not re.search(r"Type:\s+DYN", header):
        yield "it is not position-independent (-fPIE -pie)"
    if "GNU_RELRO" not in segments:
        yield "it has no RELRO segment (-Wl,-z,relro)"
    if not re.search(r"BIND_NOW|Flags:.*\bNOW\b", dynamic):
        yield "its addresses stay writable: no BIND_NOW (-Wl,-z,now)"
    if re.search(r"GNU_STACK.*\sRWE\s", segments):
        yield "its stack is executable"
    if "(TEXTREL)" in dynamic:
        yield "its code is relocated: TEXTREL"
    if "__stack_chk_fail" not in symbols:
        yield "it has no stack protector (-fstack-protector-strong)"
    checked = {name for name in symbols if name.endswith("_chk")}
    if FORTIFIED & symbols and not checked:
        yield "none of its calls is fortified (-D_FORTIFY_SOURCE=2)"


def problems_of(file):
    dynamic = readelf(file, "-d")
    symbols = set(re.findall(r"\sUND\s+(\w+)", readelf(file, "--dyn-syms")))
    yield from search_path_problems(dynamic)
    yield from protection_problems(readelf(file, "-h"), dynamic, readelf(file, "-l"), symbols)


SOURCE = """#include <stdio.h>
#include <string.h>
int main(int count, char** arguments) {
  char text[40];
  for (int i = 0; i < count; ++i) strcpy(text, arguments[i]), printf("%s", text);
  return 0;
}
"""
GOOD = ["-O2", "-U_FORTIFY_SOURCE", "-D_FORTIFY_SOURCE=2", "-fstack-protector-strong", "-fPIE", "-pie", "-Wl,-z,relro,-z,now"]
WRONG = {
    "the element ''": ["-Wl,-rpath,/usr/lib:"],
    "the element 'lib'": ["-Wl,-rpath,lib"],
    "everybody may write": ["-Wl,-rpath,/tmp"],
    "position-independent": ["-no-pie", "-fno-pie"],
    "no RELRO": ["-Wl,-z,norelro"],
    "no BIND_NOW": ["-Wl,-z,lazy"],
    "stack is executable": ["-Wl,-z,execstack"],
    "no stack protector": ["-fno-stack-protector"],
    "none of its calls is fortified": ["-U_FORTIFY_SOURCE"],
}


def faults_of_the_check(compiler):
    """What the check does not find in programs made wrong, and what it finds in a right one."""
    with tempfile.TemporaryDirectory() as folder:
        source, program = pathlib.Path(folder) / "program.c", pathlib.Path(folder) / "program"
        source.write_text(SOURCE)

        def found(flags):
            subprocess.run([compiler, *GOOD, *flags, "-w", "-o", program, source], check=True)
            return list(problems_of(program))

        if found([]):
            yield f"a protected program is refused: {found([])}"
        for words, flags in WRONG.items():
            if not any(words in problem for problem in found(flags)):
                yield f"{' '.join(flags)} is not found: {found(flags)}"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--compiler", default="cc")
    arguments = parser.parse_args()
    told = [f"this check: {fault}" for fault in faults_of_the_check(arguments.compiler)]
    files = list(elf_files(arguments.folder))
    told += [f"{file}: {problem}" for file in files for problem in problems_of(file)]
    if not files:
        told.append(f"{arguments.folder} holds no program: build the command first")
    print("\n".join(told) if told else f"{len(files)} programs and libraries are protected: {[file.name for file in files]}")
    return 1 if told else 0


if __name__ == "__main__":
    sys.exit(main())
