#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Puts the shared libraries that programs and modules need beside them, so that only the C library comes from outside.

    bundle.py LIBRARIES FILE ...      FILEs find what they need in the folder LIBRARIES, wherever both are moved to

Each library gets a name with a digest of its content: no other package of a process can mean the same name and get, or
give, another version. The C++ run time keeps its name, as a process has one. Prints the libraries taken, as they are on
this system, for sbom.py.
"""
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

C_LIBRARY = {"libc.so.6", "libm.so.6", "libpthread.so.0", "libdl.so.2", "librt.so.1", "libresolv.so.2",
             "ld-linux-x86-64.so.2", "ld-linux-aarch64.so.1"}
CPLUSPLUS = {"libstdc++.so.6", "libgcc_s.so.1"}
# OpenBLAS has all of both: SuiteSparse would bring the alternatives that this system has chosen.
SAME = {"libblas.so.3": "libopenblas.so.0", "liblapack.so.3": "libopenblas.so.0"}
# What is made here in the place of a library: source and the version of its symbols.
STAND_INS = {"libcurl.so.4": (pathlib.Path(__file__).with_name("no_network.c"), "CURL_OPENSSL_4")}


def patch(file, *options):
    """One kind of change at a time: patchelf 0.14 loses names where it changes a search path with them."""
    if options:
        subprocess.run(["patchelf", *options, file], check=True)


def needed_by(file):
    listed = subprocess.run(["patchelf", "--print-needed", file], check=True, capture_output=True, text=True)
    return listed.stdout.split()


def found_for(file):
    """Every library that the dynamic linker loads for a file, by the name under which it is asked for."""
    listed = subprocess.run(["ldd", file], check=True, capture_output=True, text=True).stdout
    if absent := re.findall(r"(\S+) => not found", listed):
        sys.exit(f"bundle.py: {file} needs {', '.join(absent)}, which this system does not have: scripts/setup")
    return dict(re.findall(r"(\S+) => (/\S+)", listed))


def stand_in(name, folder):
    source, version = STAND_INS[name]
    (folder / "symbols").write_text(version + " { global: *; };\n")
    subprocess.run(["cc", "-shared", "-fPIC", "-O2", "-Wl,-z,relro,-z,now", f"-Wl,-soname,{name}", f"-Wl,--version-script={folder}/symbols",
                    "-o", folder / name, source], check=True)
    return folder / name


def libraries_of(files, scratch):
    """What the files need in the end, C library aside."""
    found = {name: path for file in files for name, path in found_for(file).items()}
    taken, open_names = {}, [name for file in files for name in needed_by(file)]
    while open_names:
        name = open_names.pop()
        name = SAME.get(name, name)
        if name in C_LIBRARY or name in taken:
            continue
        taken[name] = stand_in(name, scratch) if name in STAND_INS else pathlib.Path(found[name]).resolve()
        open_names += needed_by(taken[name])
    return dict(sorted(taken.items()))


def bundled_name(name, path):
    if name in CPLUSPLUS:
        return name
    stem, ending = name.split(".so", 1)
    return f"{stem}-{hashlib.sha256(path.read_bytes()).hexdigest()[:8]}.so{ending}"


def renaming(file, names):
    """Options of patchelf: the libraries of a file by their names in the bundle."""
    options = []
    for name in needed_by(file):
        if name not in C_LIBRARY:
            options += ["--replace-needed", name, names[SAME.get(name, name)]]
    return options


def bundle(folder, files, scratch):
    libraries = libraries_of(files, scratch)
    names = {name: bundled_name(name, path) for name, path in libraries.items()}
    folder.mkdir(parents=True, exist_ok=True)
    for name, path in libraries.items():
        copy = folder / names[name]
        shutil.copyfile(path, copy)
        copy.chmod(0o644)
        patch(copy, *renaming(path, names))
        patch(copy, "--set-soname", names[name])
        patch(copy, "--set-rpath", "$ORIGIN")
    for file in files:
        patch(file, *renaming(file, names))
        patch(file, "--set-rpath", "$ORIGIN/" + os.path.relpath(folder, file.parent))
    for file in [*files, *folder.iterdir()]:
        if outside := set(needed_by(file)) - C_LIBRARY - set(names.values()):
            sys.exit(f"bundle.py: {file} still needs {outside}")
    return [path for name, path in libraries.items() if name not in STAND_INS]


def main():
    folder, *files = map(pathlib.Path, sys.argv[1:])
    with tempfile.TemporaryDirectory() as scratch:
        print(*bundle(folder, files, pathlib.Path(scratch)), sep="\n")


if __name__ == "__main__":
    main()
