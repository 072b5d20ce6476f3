# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C stops long calls within a second."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

TESTS = Path(__file__).parent
CHAIN = TESTS.parents[1] / "examples/chain/chain.yaml"

LONG_RUN = f"kf.run({str(CHAIN)!r}, set={{'simulate.duration': '2000 s'}}, progress=PROGRESS)"
LONG_ESTIMATE = """
t = np.arange(300_000) / RATE
y = {name: np.zeros(len(t)) for name in SENSORS}
kf.estimate(chain(20), t, y, sensors=SENSORS, inputs={'road': np.zeros(len(t))}, unknown=UNKNOWN, substeps=4, filter='ukf',
            progress=PROGRESS)
"""
LONG_SIMULATION = """
t = np.arange(5_000_000) / RATE
kf.simulate(chain(20), t, sensors=SENSORS, inputs={'road': 1e-3 * np.sin(t)}, progress=PROGRESS)
"""


@pytest.mark.parametrize("call", [LONG_RUN, LONG_ESTIMATE, LONG_SIMULATION], ids=["run", "estimate", "simulate"])
@pytest.mark.parametrize("progress", ["False", "lambda fraction, words: None"], ids=["silent", "told"])
def test_control_c_stops(call, progress):
    program = "\n".join(
        [
            "import sys, time, numpy as np, kalfem as kf",
            f"sys.path.insert(0, {str(TESTS)!r})",
            "from structures import RATE, SENSORS, UNKNOWN, chain",
            f"PROGRESS = {progress}",
            "print('begun', flush=True)",
            "try:",
            *("    " + line for line in call.strip().splitlines()),
            "    print('ended')",
            "except KeyboardInterrupt:",
            "    print('interrupted', time.time())",
        ]
    )
    python = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True, env=os.environ)
    assert python.stdout.readline() == "begun\n"
    time.sleep(1.5)
    sent = time.time()
    python.send_signal(signal.SIGINT)
    words = python.communicate(timeout=30)[0].split()
    assert words[0] == "interrupted"
    assert float(words[1]) - sent < 1.0


def test_a_stopped_run_leaves_its_folder_clean(tmp_path):
    program = f"import kalfem as kf; print('begun', flush=True); kf.run({str(CHAIN)!r}, out={str(tmp_path / 'out')!r}, " \
              "set={'simulate.duration': '2000 s'})"
    python = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    python.stdout.readline()
    time.sleep(1.0)
    python.send_signal(signal.SIGINT)
    assert "KeyboardInterrupt" in python.communicate(timeout=30)[1]
    assert not (tmp_path / "out").exists()
