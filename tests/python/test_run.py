# SPDX-License-Identifier: Apache-2.0
"""Case files run in this process: the numbers of the command, its messages, its files."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import kalfem as kf

PROJECT = Path(__file__).parents[2]
COMMAND = Path(os.environ.get("KALFEM_COMMAND", PROJECT / "build/release/bin/kalfem"))
CHAIN = PROJECT / "examples/chain/chain.yaml"
SHORT = {"simulate.duration": "2 s", "estimate.settle": "0.5 s"}


def run(**options):
    return kf.run(CHAIN, **{**dict(set=SHORT, progress=False), **options})


@pytest.fixture(scope="module")
def short():
    return run()


SCORES = {"innovation/scores/suspension.mu_k1", "innovation/scores/suspension.mu_c1"}


def without_times(summary):
    """What two runs of one case have in common."""
    if isinstance(summary, dict):
        return {k: without_times(v) for k, v in summary.items() if k not in ("timing", "seconds", "files")}
    return [without_times(each) for each in summary] if isinstance(summary, list) else summary


@pytest.fixture(scope="module")
def of_command(tmp_path_factory):
    """The folder that the command writes for the same settings."""
    folder = tmp_path_factory.mktemp("command")
    text = CHAIN.read_text().replace("duration: 20 s", "duration: 2 s").replace("settle: 2 s", "settle: 0.5 s")
    (folder / "chain.yaml").write_text(text)
    subprocess.run([COMMAND, "run", folder / "chain.yaml", "--out", folder / "out"], check=True, capture_output=True)
    return folder


def test_numbers_are_those_of_the_command_bit_for_bit(short, of_command):
    pytest.importorskip("h5py")
    written = kf.read_results(of_command / "out")
    assert without_times(short.summary) == without_times(written.summary)
    assert set(short.keys()) == set(written.keys()) | {"innovation/covariance"} | SCORES
    for path in written.keys():
        ours, theirs = short[path], written[path]
        assert np.array_equal(ours, theirs, equal_nan=True), path
        assert ours.unit == theirs.unit
        assert np.array_equal(ours.t, theirs.t) if theirs.t is not None else ours.t is None


def test_files_are_those_of_the_command_bit_for_bit(of_command, tmp_path):
    done = kf.run(of_command / "chain.yaml", out=tmp_path / "out", progress=False)
    assert {each.name for each in (tmp_path / "out").iterdir()} == {each.name for each in (of_command / "out").iterdir()}
    for name in ["results.h5", "case.resolved.yaml", "case.identified.yaml"]:
        assert (tmp_path / "out" / name).read_bytes() == (of_command / "out" / name).read_bytes(), name
    assert done.summary == json.loads((tmp_path / "out/summary.json").read_text())


def test_nothing_is_written_without_a_folder(tmp_path):
    shutil.copy(CHAIN, tmp_path)
    kf.run(tmp_path / "chain.yaml", set=SHORT, progress=False)
    assert [each.name for each in tmp_path.iterdir()] == ["chain.yaml"]


def test_settings_of_every_kind(short):
    assert len(short["time"]) == 2001
    truth = short.parameters["suspension.mu_k1"].truth
    assert truth == 20.0 and short.parameters["suspension.mu_k1"].unit == "N"
    other = run(
        set={
            **SHORT,
            "simulate.seed": np.int64(4),
            "estimate.unknown.suspension.mu_k1.initial": "12 N",
            "connectors.suspension.parameters.mu_k1": 22.0,
            "substructures.wheel.springs.k_w.stiffness": "21 kN/m",
            "sensors.a9": {"acceleration": "body.8", "noise": "0.5 m/s^2"},
            "report.displacements": ["body.3", "body.4"],
            "predict": None,
        }
    )
    assert other.parameters["suspension.mu_k1"].truth == 22.0 and other.parameters["suspension.mu_k1"].initial == 12.0
    assert "measurements/a9" in other and not any(path.startswith("prediction") for path in other.keys())


def test_steps_end_where_they_are_told_to(short):
    simulated = run(steps="simulate")
    assert "truth/body.3/displacement" in simulated and "estimate/body.3/displacement" not in simulated
    assert np.array_equal(simulated["measurements/a3"], short["measurements/a3"])
    with pytest.raises(kf.InvalidInput, match="no step 'simulation'"):
        run(steps="simulation")


def test_residuals_have_their_covariance(short):
    residuals = short.residuals
    assert residuals.covariance.shape == (2001, 4, 4)
    np.testing.assert_allclose(np.sqrt(residuals.covariance[:, 3, 3]), residuals["a11"].std, rtol=1e-14)


def test_messages_are_those_of_the_command(tmp_path):
    case = tmp_path / "wrong.yaml"
    case.write_text(CHAIN.read_text().replace("1.5 kg", "1.5 m").replace("duration: 20 s", "duration: 20 kg"))
    told = subprocess.run([COMMAND, "run", case], capture_output=True, text=True)
    with pytest.raises(kf.InvalidInput) as caught:
        kf.run(case)
    assert len(caught.value.issues) == 2
    for issue in caught.value.issues:
        assert issue.file == str(case) and issue.line > 0
        assert str(issue) in told.stderr


@pytest.mark.parametrize(
    "change, words",
    [
        ({"simulate.duration": "4 kg"}, r"set\['simulate.duration'\]: simulate.duration: .*4 kg"),
        ({"simulate.duratoin": "4 s"}, r"set\['simulate.duratoin'\]: .*duration"),
        ({"estimate.unknown.suspension.mu_k1.std": -1}, r"set\['estimate.unknown.suspension.mu_k1.std'\]"),
        ({"sensors.a3.acceleration": "body.77"}, r"sensors.a3"),
        ({"title.x": 1}, r"set\['title.x'\]: there is no key 'x'"),
        ({"simulate": "a: b: c"}, r"set\['simulate'\]: this is not YAML"),
    ],
)
def test_errors_name_the_setting(change, words):
    with pytest.raises(kf.InvalidInput, match=words):
        run(set=change)


def test_a_case_that_is_not_there():
    with pytest.raises(kf.InvalidInput, match="no such file"):
        kf.run("nowhere.yaml")


def test_the_report(short, tmp_path):
    page = short.report(tmp_path / "report.html").read_text()
    assert page.startswith("<!doctype html>") or "<html" in page[:200]
    assert short.summary["run"] in page


def test_memory_does_not_grow():
    """A run leaves nothing behind."""
    program = f"""
import kalfem as kf
def resident():
    return next(int(line.split()[1]) for line in open("/proc/self/status") if line.startswith("VmRSS"))
def once():
    kf.run({str(CHAIN)!r}, set={{"simulate.duration": "0.1 s", "excitation.road.random.fade_in": "0.02 s", "simulate.tolerance": 0.1, "estimate.settle": "0 s",
           "estimate.diagnose": False, "predict": None}}, progress=False)
for _ in range(40):
    once()
before = resident()
for _ in range(160):
    once()
print(resident() - before)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert int(done.stdout) < 2048  # KiB; found below 300
