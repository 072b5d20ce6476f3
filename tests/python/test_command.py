# SPDX-License-Identifier: Apache-2.0
"""The command inside the compiled module: the bytes, the exit codes and the signals of the program."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[2]
PROGRAM = Path(os.environ.get("KALFEM_COMMAND", PROJECT / "build/release/bin/kalfem"))
CHAIN = PROJECT / "examples/chain/chain.yaml"
MODULE = [sys.executable, "-m", "kalfem"]

pytestmark = pytest.mark.skipif(not PROGRAM.exists(), reason="there is no program to compare with: scripts/build")


def both(*words, **options):
    """What the program and the module do with the same words."""
    return [subprocess.run([*map(os.fspath, start), *words], capture_output=True, **options) for start in ([PROGRAM], MODULE)]


LINES = {
    "help": (["--help"], 0),
    "help of a verb": (["run", "--help"], 0),
    "no verb": ([], 2),
    "another verb": (["updat", "case.yaml"], 2),
    "no such case": (["run", "none.yaml"], 2),
    "a name that is no text": (["check", b"\xff.yaml"], 2),
    "case": (["check", str(CHAIN)], 0),
    "schema": (["schema", "--json"], 0),
    "laws": (["schema", "--laws"], 0),
    "manual page": (["completion", "man"], 0),
    "modes": (["modes", str(CHAIN), "--out", "modes"], 0),
    "run": (["run", str(CHAIN), "--quiet", "--set", "simulate.duration=2 s", "--out", "run"], 0),
    "a mistaken value": (["run", str(CHAIN), "--set", "simulate.duration=long"], 2),
}


@pytest.mark.parametrize("words, code", LINES.values(), ids=LINES)
def test_says_what_the_program_says(words, code, tmp_path):
    program, module = both(*words, cwd=tmp_path)
    assert program.returncode == module.returncode == code
    assert program.stdout == module.stdout
    assert program.stderr == module.stderr


def test_states_what_it_was_built_from():
    told = subprocess.run([*MODULE, "--version"], capture_output=True, text=True, check=True).stdout
    assert told.startswith("kalfem 0.") and "commit" in told and told.endswith("kernels)\n")


@pytest.mark.parametrize("start", [str(PROGRAM), " ".join(MODULE)], ids=["program", "module"])
@pytest.mark.parametrize(
    "line, code, told",
    [
        ("schema --json | head -c 10 >/dev/null; exit ${PIPESTATUS[0]}", 0, ""),
        ("schema >/dev/full", 1, "cannot write to the standard output"),
        ("schema >&-", 1, "cannot write to the standard output"),
        ("schema <&- >/dev/null", 0, ""),
        ("schema 2>&- >/dev/null", 0, ""),
    ],
)
def test_output_that_nobody_takes(start, line, code, told):
    done = subprocess.run(["bash", "-c", f"{start} {line}"], stderr=subprocess.PIPE, text=True, timeout=60)
    assert done.returncode == code
    assert told in done.stderr and done.stderr.count("\n") == (told != "")


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_it_with_nothing_left(sent, tmp_path):
    long_run = ["run", CHAIN, "--set", "simulate.duration=2000 s", "--out", tmp_path / "out"]
    command = subprocess.Popen([*MODULE, *long_run], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    time.sleep(1.5)
    command.send_signal(sent)
    errors = command.communicate(timeout=60)[1]
    assert (command.returncode, errors) == (130, "stopped before anything was finished\n")
    assert not (tmp_path / "out").exists()


def test_a_signal_keeps_what_is_finished(tmp_path):
    case, out = PROJECT / "examples/start/chain/case.yaml", tmp_path / "out"
    long_run = ["run", case, "--set", "infer={method: tempered, samples: 20000}", "--out", out]
    command = subprocess.Popen([*MODULE, *long_run], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    until = time.monotonic() + 120
    while not (out / "infer.checkpoint").exists():
        assert command.poll() is None and time.monotonic() < until
        time.sleep(0.01)
    command.send_signal(signal.SIGINT)
    assert "Traceback" not in command.communicate(timeout=60)[1]
    assert command.returncode == 130
    assert "estimation" in json.loads((out / "summary.json").read_text())


def test_little_memory_is_a_message_or_enough(tmp_path):
    """Threads of BLAS that get no buffer would hang."""
    limited = f"ulimit -v 700000; exec {' '.join(MODULE)} modes {CHAIN} --out {tmp_path / 'out'}"
    done = subprocess.run(["bash", "-c", limited], capture_output=True, timeout=60)
    assert done.returncode == 0, done.stderr


def test_needs_no_numpy(tmp_path):
    (tmp_path / "numpy.py").write_text("raise ImportError('there is no NumPy')\n")
    path = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run([*MODULE, "--version"], env=os.environ | {"PYTHONPATH": path}, capture_output=True)
    assert done.returncode == 0


def test_another_processor_is_one_line():
    program = "import sys, kalfem._built_for as b; b.FEATURES = ['warp_drive']; import kalfem.command as c; sys.exit(c.main())"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 1 and done.stderr.count("\n") == 1
    assert "a processor with warp_drive, which this one does not have" in done.stderr
