#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reference results: the estimates and deviations of twelve records, tests/reference/results.txt.

    reference_results.py check     run the records and compare; fails with a line for each number that differs
    reference_results.py print     run them and print the file
    reference_results.py renew     run them and write the file: a change of behaviour is its diff

--command says which kalfem runs them, build/release/bin/kalfem if nothing does: a packaged one is checked as well.
Numbers agree to 1e-6; where the arithmetic is that of the file (compiler, processor that it compiled for, vector width
and BLAS kernels), to 12 digits. Both are relative to the larger of the number and the deviation of its parameter.
"""

import argparse
import concurrent.futures
import json
import math
import os
import platform
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1]
RESULTS = PROJECT / "tests/reference/results.txt"
HEADING = re.compile(r"\[(?P<name>[\w-]+)\] (?P<verb>\w+) (?P<arguments>.*)")
EVERYWHERE, SAME_ARITHMETIC = 1e-6, 1e-12
WIDTHS = (("avx512f", "AVX-512"), ("avx2", "AVX2"), ("asimd", "Advanced SIMD"))
SCALARS = ("estimation.log_likelihood", "estimation.nis.mean", "updating.objective", "inference.log_evidence")

RECORDS = """\
[quarter-car] run examples/start/measured/case.yaml
[quarter-car-robust] run examples/start/measured/case.yaml --set estimate.outliers=robust
[quarter-car-ekf] run examples/start/measured/case.yaml --set estimate.filter=ekf
[damper] run examples/start/component/case.yaml
[plate] run examples/start/plate/case.yaml
[small-chain] run examples/start/chain/case.yaml
[frame-on-suspensions] run examples/start/vehicle/case.yaml
[chain] run examples/chain/chain.yaml --set simulate.duration="4 s"
[chain-written-law] run examples/chain/expression.yaml
[chain-hysteresis] run examples/chain/bouc_wen.yaml --set simulate.duration="4 s"
[chain-wheel-alone] run examples/chain/local.yaml --set simulate.duration="4 s"
[chain-posterior] infer examples/start/chain/case.yaml --set infer="{method: laplace, samples: 100, predictions: 0}"
"""


def arithmetic(command):
    """What rounding depends on: how the command was compiled, the vectors of the processor, the kernels of OpenBLAS."""
    told = subprocess.run(
        [command, "--version"], env={**os.environ, "OPENBLAS_VERBOSE": "2"}, capture_output=True, text=True, check=True
    )
    compiled = re.sub(r"^.*?\(|\)$|commit [^,]*, ", "", told.stdout.strip())
    kernels = re.search(r"Core: (\S+)", told.stdout + told.stderr)
    flags = set(re.split(r"\s+", Path("/proc/cpuinfo").read_text())) if Path("/proc/cpuinfo").exists() else set()
    width = next((name for flag, name in WIDTHS if flag in flags), "no wide vectors")
    return f"{compiled}; {platform.machine()}, {width}; kernels for {kernels[1] if kernels else 'any processor'}"


def numbers_of(summary):
    """Name -> value of what a summary.json states: parameters with deviations, modes, and the sums over the record."""
    found = {}
    for step in (summary, summary.get("updating", {}), summary.get("inference", {})):
        prefix = "posterior." if step is summary.get("inference") else ""
        for name, parameter in step.get("parameters", {}).items():
            for key in ("estimate", "mean", "std", "std_robust"):
                if parameter.get(key) is not None:
                    found[f"{prefix}{name}.{key}"] = parameter[key]
    for path in SCALARS:
        value = summary
        for key in path.split("."):
            value = value.get(key) if isinstance(value, dict) else None
        if isinstance(value, float):
            found[path] = value
    return found


def measured(command, record):
    """The verdict and the numbers of one record; its results go to a folder that does not stay."""
    heading = HEADING.fullmatch(record)
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [command, heading["verb"], *shlex.split(heading["arguments"]), "--out", folder, "--quiet"],
            cwd=PROJECT,
            capture_output=True,
            text=True,
        )
        if done.returncode not in (0, 3):
            raise RuntimeError(f"[{heading['name']}] ends with {done.returncode}: {done.stderr.strip()}")
        summary = json.loads((Path(folder) / "summary.json").read_text())
    return {"verdict": summary["verdict"]["state"], **numbers_of(summary)}


def all_measured(command, records):
    with concurrent.futures.ThreadPoolExecutor(max_workers=2) as pool:
        return dict(zip(records, pool.map(lambda record: measured(command, record), records)))


def written(arithmetic, results):
    lines = ["# Estimates and deviations in SI units; tools/reference_results.py renew writes this file.", arithmetic]
    for record, numbers in results.items():
        lines += ["", record, *(f"{name} = {value}" for name, value in numbers.items())]
    return "\n".join(lines) + "\n"


def read(text):
    """The arithmetic and the results of a file; the inverse of `written`.

    >>> read(written("clang", {"[a] run a.yaml": {"verdict": "consistent", "k.std": 0.1 + 0.2}}))
    ('clang', {'[a] run a.yaml': {'verdict': 'consistent', 'k.std': 0.30000000000000004}})
    """
    arithmetic, results = "", {}
    for line in text.splitlines():
        if not line or line.startswith("#"):
            continue
        if HEADING.fullmatch(line):
            numbers = results[line] = {}
        elif results:
            name, value = line.split(" = ")
            numbers[name] = value if name == "verdict" else float(value)
        else:
            arithmetic = line
    return arithmetic, results


def scale_of(name, numbers):
    """An estimate may be as small as zero beside its deviation: the larger of the two is what its error counts from."""
    stem = name.rpartition(".")[0]
    return max(abs(numbers[key]) for key in (name, f"{stem}.std") if key in numbers)


def differences(stated, found, tolerance):
    """A line for each number that is not the stated one.

    >>> differences({"verdict": "consistent", "k.estimate": 2.0}, {"verdict": "consistent", "k.estimate": 2.0 + 1e-6}, 1e-6)
    []
    >>> differences({"verdict": "consistent", "k.estimate": 2.0}, {"verdict": "unusable", "k.estimate": 2.1}, 1e-6)
    ['verdict: unusable, not consistent', 'k.estimate: 2.1, not 2.0 (5.0e-02)']
    >>> differences({"x.estimate": 1e-9, "x.std": 1.0}, {"x.estimate": 2e-9, "x.std": 1.0}, 1e-6)
    []
    >>> differences({"x.std": 1.0}, {"y.std": 1.0}, 1e-6)
    ['x.std: is missing', 'y.std: is new']
    >>> differences({"x.std": 1.0}, {"x.std": math.nan}, 1e-6)
    ['x.std: nan, not 1.0 (nan)']
    """
    lines = []
    for name, value in stated.items():
        if name not in found:
            lines.append(f"{name}: is missing")
        elif name == "verdict":
            lines += [f"verdict: {found[name]}, not {value}"] if found[name] != value else []
        else:
            error = abs(found[name] - value)
            scale = scale_of(name, stated)
            if not error <= tolerance * scale:
                lines.append(f"{name}: {found[name]}, not {value} ({error / (scale or 1.0):.1e})")
    return lines + [f"{name}: is new" for name in found if name not in stated]


def check(command):
    stated_with, stated = read(RESULTS.read_text())
    if list(stated) != RECORDS.splitlines():
        sys.exit(f"{RESULTS}: its records are not those of this script; renew it")
    here = arithmetic(command)
    tolerance = SAME_ARITHMETIC if here == stated_with else EVERYWHERE
    print(f"{len(stated)} records to {tolerance:g}: {here}" + ("" if here == stated_with else f", not {stated_with}"))
    wrong = [
        f"{HEADING.fullmatch(record)['name']}: {line}"
        for record, found in all_measured(command, list(stated)).items()
        for line in differences(stated[record], found, tolerance)
    ]
    if wrong:
        sys.exit("\n".join([*wrong, "where the change is meant: tools/reference_results.py renew"]))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("action", choices=["check", "print", "renew"])
    parser.add_argument("--command", default=PROJECT / "build/release/bin/kalfem", help="the kalfem that runs the records")
    options = parser.parse_args()
    if options.action == "check":
        return check(options.command)
    text = written(arithmetic(options.command), all_measured(options.command, RECORDS.splitlines()))
    if options.action == "print":
        print(text, end="")
    else:
        RESULTS.write_text(text)
        print(f"{RESULTS}: {text.count(' = ')} numbers of {len(RECORDS.splitlines())} records")


if __name__ == "__main__":
    main()
