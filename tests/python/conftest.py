# SPDX-License-Identifier: Apache-2.0
"""Fixtures: a small folder of results with the layout of results.h5, without the compiled module."""

import json

import numpy as np
import pytest


def small_results():
    """Summary and datasets of a run of 200 samples with one sensor, one point, one connector and one parameter."""
    rng = np.random.default_rng(4)
    time = np.arange(200) / 100.0
    motion = 1e-3 * np.sin(12 * time)
    rate = {"sample_rate": 100.0}

    def series(values, unit):
        return np.asarray(values, dtype=float), {"unit": unit, **rate}

    deformation = motion + 1e-5
    course = 20 - 10 * np.exp(-3 * time)
    datasets = {
        "time": series(time, "s"),
        "measurements/a3": series(rng.normal(size=200), "m/s^2"),
        "truth/body.3/displacement": series(motion, "m"),
        "estimate/body.3/displacement": series(motion + 2e-5 * rng.normal(size=200), "m"),
        "estimate/body.3/displacement_std": series(np.full(200, 2e-5), "m"),
        "estimate/mount/deformation": series(deformation, "m"),
        "estimate/mount/rate": series(np.gradient(deformation, time), "m/s"),
        "estimate/mount/force": series(1e4 * deformation + 1e9 * deformation**3, "N"),
        "truth/mount/deformation": series(motion, "m"),
        "truth/mount/force": series(1e4 * motion + 1e9 * motion**3, "N"),
        "estimate/parameters/mount.k": series(course, "N/m"),
        "estimate/parameters/mount.k_std": series(5 * np.exp(-2 * time) + 0.2, "N/m"),
        "innovation/value/a3": series(np.where(time == time[7], np.nan, rng.normal(size=200)), "m/s^2"),
        "innovation/deviation/a3": series(np.ones(200), "m/s^2"),
        "innovation/nis": series(rng.chisquare(1, size=200), "-"),
        "validation/time": (np.arange(50) / 50.0, {"unit": "s"}),
        "validation/a3/measured": (np.ones(50), {"unit": "m/s^2"}),
        "updating/residual": (np.array([3.0, 1.0]), {"unit": "-"}),
    }
    summary = {
        "kalfem": "1",
        "run": "0123456789abcdef",
        "case": "small.yaml",
        "title": "a <small> case",
        "status": "ok",
        "message": "",
        "verdict": {
            "state": "suspicious",
            "reasons": [
                {"code": "innovation_large", "subject": "a3", "text": "2 times as large", "remedy": "check <its> noise"}
            ],
        },
        "parameters": {
            "mount.k": {
                "true": 20.0,
                "initial": 10.0,
                "estimate": 19.97832,
                "std": 0.2,
                "std_robust": None,
                "interval_95": [19.6, 20.4],
                "unit": "N/m",
            }
        },
        "updating": {"parameters": {"body.k": {"initial": 1.0, "estimate": 2.0, "std": None, "interval_95": None}}},
        "estimation": {"filter": "partially linear UKF", "nis": {"mean": 1.02, "expected": 1}},
    }
    return summary, datasets


def write_folder(folder, summary, datasets):
    """The files that the command would write."""
    h5py = pytest.importorskip("h5py")
    folder.mkdir(exist_ok=True)
    (folder / "summary.json").write_text(json.dumps(summary))
    (folder / "report.html").write_text("<html>report</html>")
    with h5py.File(folder / "results.h5", "w") as file:
        file.attrs["run"] = summary["run"]
        for path, (values, attributes) in datasets.items():
            file[path] = values
            file[path].attrs.update(attributes)
    return folder


@pytest.fixture
def results_folder(tmp_path):
    return write_folder(tmp_path / "out", *small_results())


@pytest.fixture
def memory_run():
    from kalfem.results import Run

    return Run.from_memory(*small_results())
