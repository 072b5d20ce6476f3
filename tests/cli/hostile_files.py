#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What no regular file is, in every place where the command opens a file, and damaged files of every format: no crash, no
hang, and never more memory than 200 MB and ten times the file.

    hostile_files.py KALFEM CORPUS [--count 2000] [--only places|damaged|memory]

KALFEM is the command, CORPUS the folder tests/fuzz/corpus. The files are the same ones every time.
"""
import argparse
import concurrent.futures
import dataclasses
import os
import pathlib
import random
import resource
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

LONGEST = 20.0  # [s] for one command
MEMORY, PER_BYTE = 200e6, 10.0
LOADED = 140  # [MB] of addresses that the loader and the libraries need before the program begins
GOOD_CODES = {0, 2, 3}  # done, mend the input, not usable: 1 is a bug


@dataclasses.dataclass
class Ended:
    code: int
    text: str
    peak: float  # [bytes]
    seconds: float


def run(command, folder, address_space=None):
    """Run a command; a hang is ended and has the code -9."""
    output = folder / "output.txt"

    def limit():
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if address_space:
            resource.setrlimit(resource.RLIMIT_AS, (address_space, address_space))

    begin = time.monotonic()
    with output.open("wb") as sink:
        child = subprocess.Popen(list(map(str, command)), cwd=folder, stdin=subprocess.DEVNULL, stdout=sink, stderr=sink,
                                 preexec_fn=limit)
        deadline = begin + LONGEST
        while True:
            done, status, usage = os.wait4(child.pid, os.WNOHANG)
            if done:
                break
            if time.monotonic() > deadline:
                child.kill()
                deadline = float("inf")
            time.sleep(0.002)
    child.returncode = 0
    code = -os.WTERMSIG(status) if os.WIFSIGNALED(status) else os.WEXITSTATUS(status)
    text = output.read_bytes().decode(errors="replace")
    return Ended(code, text, usage.ru_maxrss * 1024.0, time.monotonic() - begin)


def faults_of(ended, file_bytes, what):
    if ended.code == -signal.SIGKILL:
        yield f"{what}: it hangs"
    elif ended.code not in GOOD_CODES:
        yield f"{what}: it ends with {ended.code}: {ended.text[-300:]}"
    if ended.peak > MEMORY + PER_BYTE * file_bytes:
        yield f"{what}: it takes {ended.peak / 1e6:.0f} MB for a file of {file_bytes} bytes"


# --- what is no regular file ---


def make_pipe(file):
    os.mkfifo(file)


def make_socket(file):
    here = os.getcwd()
    os.chdir(file.parent)  # the name of a socket is short
    try:
        socket.socket(socket.AF_UNIX).bind(file.name)
    finally:
        os.chdir(here)


def make_unreadable(file):
    file.write_text("secret")
    file.chmod(0)


def make_zeros(file):
    with file.open("wb") as sparse:
        sparse.truncate(1 << 30)


KINDS = {
    "pipe": make_pipe,
    "socket": make_socket,
    "zero device": lambda file: file.symlink_to("/dev/zero"),
    "full device": lambda file: file.symlink_to("/dev/full"),
    "terminal": lambda file: file.symlink_to("/dev/tty"),
    "folder": lambda file: file.mkdir(),
    "missing": lambda file: None,
    "link to itself": lambda file: file.symlink_to(file.name),
    "unreadable": make_unreadable,
    "one line of 1 GiB": make_zeros,
}

CHAIN = """kalfem: 1
substructures:
  body: {masses: {m: 1 kg}, springs: [{from: ground, to: m, stiffness: 1 kN/m}], damping: {modal: 1 %}}
"""
BEAM = """kalfem: 1
substructures:
  arm:
    finite_elements:
      SOURCE
      materials: {steel: {youngs_modulus: 210 GPa, density: 7850 kg/m^3}}
      regions: {bar: {material: steel, beam: {section: {rectangle: {width: 20 mm, height: 10 mm}}}}}
      nodes: {root: 1}
      fixed: {clamp: {nodes: root}}
"""
NODES, ELEMENTS = "node,x,y,z\n1,0,0,0\n2,1,0,0\n", "element,node1,node2,region\n1,1,2,bar\n"
MATRIX = "%%MatrixMarket matrix coordinate real symmetric\n1 1 1\n1 1 4\n"


@dataclasses.dataclass
class Place:
    """A place where the command opens a file: the files around it, the name that is opened, and the arguments."""

    name: str
    opened: str
    arguments: list
    files: dict
    starter: str = ""  # of `kalfem new`
    must_refuse: bool = True  # a missing part of a finished run need not matter


def places():
    for ending in ("csv", "txt", "dat", "lvm", "unv", "tdms", "wav", "mat", "h5", "hdf5", "other"):
        yield Place(f"inspect .{ending}", f"x.{ending}", ["inspect", f"x.{ending}"], {})
    for verb in ("check", "modes", "run"):
        yield Place(f"{verb} case", "case.yaml", [verb, "case.yaml"], {})
    for ending in ("inp", "bdf", "dat", "nas"):
        yield Place(f"check deck .{ending}", f"x.{ending}", ["check", f"x.{ending}"], {})
        yield Place(f"modes of deck .{ending}", f"x.{ending}", ["modes", f"x.{ending}"], {})
    yield Place("INCLUDE", "part.bdf", ["check", "x.bdf"], {"x.bdf": "BEGIN BULK\nINCLUDE 'part.bdf'\nENDDATA\n"})
    yield Place("*INCLUDE", "part.inp", ["check", "x.inp"], {"x.inp": "*INCLUDE, INPUT=part.inp\n"})
    yield Place("*MATRIX INPUT", "k.mtx", ["check", "x.inp"], {"x.inp": "*MATRIX INPUT, NAME=K, INPUT=k.mtx\n"})
    for source, others in (("mesh: x.msh", {}), ("deck: x.bdf", {}),
                           ("tables: {nodes: x.csv, elements: e.csv}", {"e.csv": ELEMENTS}),
                           ("tables: {nodes: n.csv, elements: x.csv}", {"n.csv": NODES})):
        opened = source.split("x.")[1][:3]
        yield Place(source, f"x.{opened}", ["check", "case.yaml"], {"case.yaml": BEAM.replace("SOURCE", source), **others})
    for ending in ("mtx", "h5", "op4", "op2", "pch", "nc", "mat", "mtx.gz"):
        case = f"kalfem: 1\nsubstructures: {{arm: {{finite_elements: {{matrices: {{files: [x.{ending}, M.mtx]}}}}}}}}\n"
        yield Place(f"matrices .{ending}", f"x.{ending}", ["check", "case.yaml"], {"case.yaml": case, "M.mtx": MATRIX})
    case = "kalfem: 1\nsubstructures: {arm: {finite_elements: {matrices: {files: [K.mtx, M.mtx], dofs: x.dof}}}}\n"
    yield Place("map of degrees of freedom", "x.dof", ["check", "case.yaml"],
                {"case.yaml": case, "M.mtx": MATRIX, "K.mtx": MATRIX})
    for ending in ("csv", "h5", "mat", "lvm", "tdms", "unv", "wav"):
        case = CHAIN + (f"excitation: {{push: {{force: body.m, file: x.{ending}, channel: f}}}}\n"
                        "sensors: {a: {acceleration: body.m, noise: 5 %}}\nsimulate: {duration: 1 s, sample_rate: 100 Hz}\n")
        yield Place(f"excitation .{ending}", f"x.{ending}", ["check", "case.yaml"], {"case.yaml": case})
        case = CHAIN + (f"sensors: {{a: {{acceleration: body.m, noise: 5 %}}}}\nrecord: {{file: x.{ending}}}\n"
                        "estimate: {unknown: {body.m: {initial: 1 kg, std: 10 %}}}\n")
        yield Place(f"record .{ending}", f"x.{ending}", ["check", "case.yaml"], {"case.yaml": case})
    yield Place("record of `run`", "quarter_car.csv", ["run", "case.yaml"], {}, starter="measured")
    yield Place("record of a component", "damper.csv", ["check", "case.yaml"], {}, starter="component")
    yield Place("frequencies of `update`", "frequencies.csv", ["check", "case.yaml"], {}, starter="plate")
    yield Place("deck of `update`", "plate.bdf", ["update", "case.yaml"], {}, starter="plate")
    yield Place("tables of a structure", "beams.csv", ["check", "case.yaml"], {}, starter="vehicle")
    parts = {"summary.json": "{}", "case.resolved.yaml": "kalfem: 1\n"}
    finished = {f"{run_folder}/{name}": text for run_folder in ("out", "other") for name, text in parts.items()}
    for verb, opened in (("report", "summary.json"), ("compare", "summary.json"), ("plot", "summary.json"),
                         ("plot", "results.h5"), ("compare", "results.h5"), ("compare", "case.resolved.yaml")):
        files = {name: text for name, text in finished.items() if name != f"out/{opened}"}
        runs = ["out", "other"] if verb == "compare" else ["out"]
        yield Place(f"{opened} of `{verb}`", f"out/{opened}", [verb, *runs], files, must_refuse=opened == "summary.json")
    yield Place("note of `run --resume`", "out/run.resume.json", ["run", "--resume", "out"], {"out/.keep": ""})


def try_place(kalfem, place, kind, root):
    folder = pathlib.Path(tempfile.mkdtemp(dir=root))
    if place.starter:
        run([kalfem, "new", place.starter, folder / "new"], folder)
        for file in (folder / "new").iterdir():
            file.rename(folder / file.name)
    for name, text in place.files.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text)
    target = folder / place.opened
    target.unlink(missing_ok=True)
    target.parent.mkdir(exist_ok=True)
    KINDS[kind](target)
    ended = run([kalfem, *place.arguments], folder)
    size = (1 << 30) if kind.startswith("one line") else 0
    yield from faults_of(ended, size, f"{place.name}, {kind}")
    readable = kind == "unreadable" and os.geteuid() == 0
    if place.must_refuse and not readable and ended.code != 2:
        yield f"{place.name}, {kind}: it ends with {ended.code}, expected 2: {ended.text[-300:]}"
    named = pathlib.Path(place.opened).stem in ended.text or "out" in ended.text
    if place.must_refuse and not readable and ended.code == 2 and not named:
        yield f"{place.name}, {kind}: the message does not name the file: {ended.text[-300:]}"
    if "Traceback" in ended.text or "internal error" in ended.text:
        yield f"{place.name}, {kind}: {ended.text[-300:]}"
    if kind == "unreadable":
        target.chmod(0o600)
    shutil.rmtree(folder)


# --- damaged files ---

ODD = [b"0", b"-1", b"1e308", b"nan", b"-", b"99999999999", b"2147483648", b"\xff", b'"', b",", b"\n", b"*", b"+", b"",
       b"0x10", b"inf", b"$", b"\r\n", b"\t", b"1-1", b"=", b"  ", b"\0" * 9, b"A" * 300]
MESH_CASE = """kalfem: 1
substructures:
  plate:
    finite_elements:
      mesh: x.msh
      materials: {steel: {youngs_modulus: 210 GPa, density: 7850 kg/m^3}}
      regions: {plate: {material: steel, shell: {thickness: 5 mm}}}
"""
MATRIX_CASE = "kalfem: 1\nsubstructures: {arm: {finite_elements: {matrices: {files: [FILE, M.mtx]}}}}\n"
RECORD_CASE = (CHAIN + "sensors: {a: {acceleration: body.m, noise: 5 %}}\nrecord: {file: FILE}\n"
               "estimate: {unknown: {body.m: {initial: 1 kg, std: 10 %}}}\n")
# Folder of the corpus -> the case around its file, or the verb that reads it alone.
READERS = {
    "abaqus": "check", "nastran": "check", "case": "check", "csv": RECORD_CASE, "measured_table": "inspect",
    "lvm": "inspect", "tdms": "inspect", "wav": "inspect", "matlab_file": "inspect", "measured_hdf5": "inspect",
    "universal": "inspect", "gmsh": MESH_CASE, "matrix_market": MATRIX_CASE, "calculix_matrix": MATRIX_CASE,
    "dmig": MATRIX_CASE, "op2": MATRIX_CASE, "op4": MATRIX_CASE, "netcdf": MATRIX_CASE, "matlab": MATRIX_CASE,
}


def damaged(content, others, chance):
    for _ in range(chance.randrange(1, 5)):
        if not content:
            break
        place = chance.randrange(len(content))
        way = chance.randrange(7)
        if way == 0:
            content = content[:place]
        elif way == 1:
            content = content[:place] + bytes([chance.randrange(256)]) + content[place + 1:]
        elif way == 2:
            content = content[:place] + content[place + chance.randrange(1, 40):]
        elif way == 3:
            begin = chance.randrange(len(content))
            content = content[:place] + content[begin:begin + chance.randrange(200)] + content[place:]
        elif way == 4:
            content = content[:place] + chance.choice(ODD) + content[place:]
        elif way == 5:
            other = chance.choice(others)
            content = content[:place] + other[chance.randrange(len(other) + 1):]
        else:
            content = content[:place] + content[place:place + 60] * chance.randrange(1, 400) + content[place:]
    return content


def damaged_files(corpus, count):
    """(folder of the corpus, ending, content), the same number of each format."""
    share = -(-count // len(READERS))
    for name in READERS:
        seeds = sorted((corpus / name).iterdir())
        contents = [seed.read_bytes() for seed in seeds]
        chance = random.Random(name)
        for number in range(share):
            seed = number % len(seeds)
            suffix = "".join(seeds[seed].suffixes)
            yield name, suffix, damaged(contents[seed], contents, chance)


def try_damaged(kalfem, name, suffix, content, number, root):
    folder = pathlib.Path(tempfile.mkdtemp(dir=root))
    file = folder / f"x{suffix}"
    file.write_bytes(content)
    reader = READERS[name]
    if reader in ("check", "inspect"):
        ended = run([kalfem, reader, file.name], folder)
    else:
        (folder / "the_case.yaml").write_text(reader.replace("FILE", file.name))
        (folder / "M.mtx").write_text(MATRIX)
        ended = run([kalfem, "check", "the_case.yaml"], folder)
    faults = list(faults_of(ended, len(content), f"damaged {name} {number}"))
    shutil.rmtree(folder)
    return ended, faults


# --- too little memory ---


def try_little_memory(kalfem, megabytes, root):
    """A table of 60 MB, a deck of 40 MB: a message and a code, never the end by a signal."""
    folder = pathlib.Path(tempfile.mkdtemp(dir=root))
    (folder / "big.csv").write_bytes(b"t,a,b,c\n" + b"".join(b"%d,1.5,2.5,3.5\n" % i for i in range(1_500_000)))
    (folder / "big.bdf").write_bytes(b"BEGIN BULK\n" + b"".join(b"GRID,%d,,1.,2.,3.\n" % i for i in range(1, 1_500_000)))
    for arguments in (["inspect", "big.csv"], ["check", "big.bdf"]):
        ended = run([kalfem, *arguments], folder, address_space=megabytes << 20)
        what = f"{' '.join(arguments)} with {megabytes} MB"
        if ended.code == -signal.SIGKILL:
            yield f"{what}: it hangs"
        elif ended.code not in GOOD_CODES or not ended.text.strip():
            yield f"{what}: it ends with {ended.code}: {ended.text[-300:]}"
    shutil.rmtree(folder)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("kalfem", type=pathlib.Path)
    parser.add_argument("corpus", type=pathlib.Path)
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--only", choices=["places", "damaged", "memory"])
    arguments = parser.parse_args()
    kalfem, faults, told = arguments.kalfem.resolve(), [], []
    with tempfile.TemporaryDirectory(prefix="hostile") as root, concurrent.futures.ThreadPoolExecutor(2) as pool:
        if arguments.only in (None, "places"):
            pairs = [(place, kind) for place in places() for kind in KINDS]
            for found in pool.map(lambda pair: list(try_place(kalfem, *pair, root)), pairs):
                faults += found
            told.append(f"{len(pairs)} pairs of a place and a kind of file")
        if arguments.only in (None, "damaged"):
            files = list(damaged_files(arguments.corpus, arguments.count))
            jobs = [(kalfem, *file, number, root) for number, file in enumerate(files)]
            ends = list(pool.map(lambda job: try_damaged(*job), jobs))
            for _, found in ends:
                faults += found
            peak, longest = max(end.peak for end, _ in ends), max(end.seconds for end, _ in ends)
            read = sum(end.code != 2 for end, _ in ends)
            told.append(f"{len(ends)} damaged files ({read} read, the others refused), {peak / 1e6:.0f} MB and "
                        f"{longest:.1f} s at most")
        if arguments.only in (None, "memory"):
            limits = [*range(LOADED, 320, 20), 400, 600]
            for found in pool.map(lambda megabytes: list(try_little_memory(kalfem, megabytes, root)), limits):
                faults += found
            told.append(f"{len(limits)} limits of memory")
    print("\n".join(faults + told))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
