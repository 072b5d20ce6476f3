# SPDX-License-Identifier: Apache-2.0
"""A live case that a program of Python feeds: `kalfem watch` without a process."""

import json
import os
import subprocess
import warnings

import numpy as np
import pytest

import kalfem as kf

COMMAND = os.environ.get("KALFEM_COMMAND")

STRUCTURE = """kalfem: 1
substructures:
  wheel: {masses: {w: 40 kg}, springs: [{name: tyre, from: ground, to: w, stiffness: 180 kN/m, damping: 200 N s/m}]}
  body: {masses: {b: 300 kg}}
connectors:
  strut: {from: wheel.w, to: body.b, law: polynomial, parameters: {k1: 20 kN/m, k3: 3e6, c1: 1200 N s/m}}
sensors:
  wheel: {acceleration: wheel.w, noise: 0.05 m/s^2}
  body: {acceleration: body.b, noise: 0.02 m/s^2}
"""
DRIVE = STRUCTURE + """excitation:
  road: {base_displacement: wheel.ground, random: {rms: 8 mm, band: [0.5, 12 Hz], seed: 4}}
simulate: {duration: 4 s, sample_rate: 500 Hz, tolerance: 1e-5}
"""
LIVE = STRUCTURE + """excitation:
  road: {base_displacement: wheel.ground, file: live, channel: road}
live: {sample_rate: 500 Hz, horizon: 0.5 s, every: 0.5 s}
estimate:
  unknown: {strut.k3: {initial: 2e6, std: 2e6}}
"""


@pytest.fixture(scope="module")
def cases(tmp_path_factory):
    if not COMMAND:
        pytest.skip("KALFEM_COMMAND does not name the command")
    folder = tmp_path_factory.mktemp("watch")
    for name, text in (("drive", DRIVE), ("live", LIVE)):
        (folder / f"{name}.yaml").write_text(text)
    play = [COMMAND, "play", folder / "drive.yaml", "--speed", "0"]
    stream = subprocess.run(play, capture_output=True, text=True, check=True)
    return folder / "live.yaml", stream.stdout


def test_gives_what_the_command_gives(cases):
    case, stream = cases
    command = subprocess.run([COMMAND, "watch", case], input=stream, capture_output=True, text=True, check=True)
    live = kf.watch(case)
    found = live.take(stream) + [live.tell()]
    assert found == [json.loads(line) for line in command.stdout.splitlines()]
    k3 = found[-1]["parameters"]["strut.k3"]
    assert abs(k3["estimate"] - 3e6) < 3.0 * k3["std"]


def test_takes_dictionaries_and_arrays_as_it_takes_lines(cases):
    case, stream = cases
    expected = kf.watch(case).take(stream)
    blocks = [json.loads(line) for line in stream.splitlines()]
    assert kf.watch(case).take(blocks) == expected
    live = kf.watch(case)
    arrays = [{name: np.array(value, float) for name, value in each.items()} for each in blocks]
    assert [each for block in arrays for each in live.take(block)] == expected


def test_goes_on_from_a_state_with_the_same_bits(cases, tmp_path):
    case, stream = cases
    lines = stream.splitlines()
    half = len(lines) // 2
    whole = kf.watch(case)
    first = whole.take("\n".join(lines[:half]))
    whole.write_state(tmp_path / "state")
    rest = whole.take("\n".join(lines[half:]))
    again = kf.watch(case, state=tmp_path / "state")
    assert again.take("\n".join(lines[half:])) == rest and first
    (tmp_path / "state").write_bytes((tmp_path / "state").read_bytes()[:-20])
    with pytest.raises(kf.InvalidInput, match="state"):
        kf.watch(case, state=tmp_path / "state")


def test_warns_of_what_it_cannot_use(cases):
    live = kf.watch(cases[0])
    with pytest.warns(RuntimeWarning, match="no channel 'whel' .*did you mean 'wheel'"):
        live.take({"t": 0.0, "whel": 1.0})
    with pytest.warns(RuntimeWarning, match="line 2"):
        live.take("{broken")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        live.take({"t": 0.0, "wheel": float("nan"), "body": None, "road": 0.0})


def test_refuses_a_case_without_a_stream(cases):
    with pytest.raises(kf.InvalidInput, match="the case has no `live`"):
        kf.watch(cases[0].with_name("drive.yaml"))
