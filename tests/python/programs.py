# SPDX-License-Identifier: Apache-2.0
"""Programs in processes of their own."""

import os
import subprocess
import sys
from pathlib import Path

import kalfem
import pytest

HERE = Path(__file__).parent


def environment():
    """Of worker processes: they find the package and the functions of the tests."""
    package = str(Path(kalfem.__file__).parents[1])
    return {**os.environ, "PYTHONPATH": os.pathsep.join([package, str(HERE), os.environ.get("PYTHONPATH", "")])}


def output_under_mpi(text, folder, *arguments):
    """What a program for mpi4py.futures prints with a master and two workers; skips where MPI is not installed."""
    pytest.importorskip("mpi4py")
    program = folder / "program.py"
    program.write_text(text)
    command = ["mpiexec", "-n", "3", "--oversubscribe", "--allow-run-as-root", sys.executable, "-m", "mpi4py.futures"]
    try:
        done = subprocess.run(
            [*command, program, *arguments], env=environment(), capture_output=True, text=True, timeout=120
        )
    except FileNotFoundError:
        pytest.skip("mpiexec is not installed")
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()
