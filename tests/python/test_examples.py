# SPDX-License-Identifier: Apache-2.0
"""The scripts of examples/python, run as a user runs them, and their length."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

kalfem = pytest.importorskip("kalfem._core", reason="the compiled module is not built")

PROJECT = Path(__file__).parents[2]
SCRIPTS = sorted((PROJECT / "examples/python").glob("*.py"))

EXPECTED = {
    "chain": ["consistent", "95 % from"],
    "dask_ensemble": ["of 12 runs"],
    "filters_compared": ["partially_linear_ukf", "ekf"],
    "live_loop": ["same estimate: True"],
    "own_deck": ["consistent"],
    "sensor_grid": ["the worst pair"],
}
ARGUMENTS = {"dask_ensemble": ["12"]}


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_example(script, tmp_path):
    (tmp_path / "examples").symlink_to(PROJECT / "examples")
    path = os.pathsep.join([str(Path(kalfem.__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, "-W", "error::DeprecationWarning:__main__", script, *ARGUMENTS.get(script.stem, [])],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": path, "MPLBACKEND": "Agg"},
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    for words in EXPECTED[script.stem]:
        assert words in done.stdout
    if script.stem != "dask_ensemble":  # its workers may say that they end late
        assert done.stderr == ""


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_examples_are_short(script):
    licence, *lines = script.read_text().splitlines()
    assert licence.startswith("# SPDX")
    assert len(lines) < 60
