# SPDX-License-Identifier: Apache-2.0
"""Runs from a folder and from memory, their arrays, parameters and tables."""

import doctest
import importlib
import json
import pickle
import sys

import numpy as np
import pytest
from conftest import small_results, write_folder
from kalfem.errors import InvalidInput, Issue, MissingPackage, UnknownName
from kalfem.results import Run, read_results
from kalfem.series import TimeSeries


@pytest.fixture(params=["folder", "memory"])
def run(request):
    if request.param == "folder":
        return read_results(request.getfixturevalue("results_folder"))
    return request.getfixturevalue("memory_run")


def test_an_array_knows_its_time_deviation_and_unit(run):
    y = run["estimate/body.3/displacement"]
    assert isinstance(y, np.ndarray) and y.unit == "m" and y.name == "estimate/body.3/displacement"
    assert np.array_equal(y.t, np.arange(200) / 100.0)
    assert np.array_equal(y.std, np.full(200, 2e-5))
    assert np.array_equal(run["/estimate/body.3/displacement"], y)


def test_arrays_have_the_time_of_their_group(run):
    assert np.array_equal(run["validation/a3/measured"].t, np.arange(50) / 50.0)
    assert run["updating/residual"].t is None


def test_a_series_that_ended_early_has_the_first_times():
    summary, datasets = small_results()
    values, attributes = datasets["estimate/body.3/displacement"]
    datasets["estimate/body.3/displacement"] = (values[:20], attributes)
    run = Run.from_memory(summary, datasets)
    assert np.array_equal(run["estimate/body.3/displacement"].t, np.arange(20) / 100.0)
    column = run.to_pandas("estimate")["estimate/body.3/displacement"]
    assert np.array_equal(column[:0.19], values[:20]) and column[0.2:].isna().all()


def test_parameters(run):
    k = run.parameters["mount.k"]
    assert (k.value, k.std, k.truth, k.initial, k.unit) == (19.97832, 0.2, 20.0, 10.0, "N/m")
    assert k.interval == (19.6, 20.4) and k.std_robust is None
    assert str(k) == "mount.k = 19.98 +- 0.20 N/m"
    assert list(run.parameters) == ["body.k", "mount.k"]
    assert run.parameters["body.k"].interval is None


def test_verdict(run):
    assert run.verdict.state == "suspicious" and run.usable
    assert run.verdict.reasons[0].code == "innovation_large"
    assert str(run.verdict.reasons[0]) == "a3: 2 times as large; check <its> noise"


def test_residuals(run):
    residuals = run.residuals
    assert residuals.sensors == ["a3"] and residuals.value.shape == (200, 1)
    assert not residuals.used[7, 0] and residuals.used.sum() == 199
    assert residuals["a3"].std is not None and residuals["a3"].unit == "m/s^2"
    assert np.array_equal(residuals.t, run["time"])
    assert residuals.covariance is None and residuals.scores is None
    with pytest.raises(UnknownName, match=r"there is no sensor 'a4' \(did you mean 'a3'\?\)"):
        residuals["a4"]


def test_residuals_with_covariance_and_scores():
    summary, datasets = small_results()
    datasets["innovation/covariance"] = (np.ones((200, 1, 1)), {"sample_rate": 100.0})
    datasets["innovation/scores/mount.k"] = (np.arange(200.0), {"sample_rate": 100.0})
    residuals = Run.from_memory(json.dumps(summary), datasets).residuals
    assert residuals.covariance.shape == (200, 1, 1)
    assert np.array_equal(residuals.scores, np.arange(200.0)[:, None])


def test_a_wrong_name_is_told_with_the_nearest(run):
    with pytest.raises(UnknownName, match="did you mean 'estimate/body.3/displacement'"):
        run["estimate/body.3/displacment"]
    with pytest.raises(UnknownName, match=r"there is no parameter 'mount.kk' \(did you mean 'mount.k'\?\)"):
        run.parameters["mount.kk"]
    with pytest.raises(UnknownName, match="no plot 'nothing'; there are overview, parameters"):
        run.plot("nothing")


def test_folders_without_results_are_refused(tmp_path, results_folder):
    with pytest.raises(InvalidInput, match="there is no summary.json; give the folder"):
        read_results(tmp_path)
    (results_folder / "summary.json").write_text("{")
    with pytest.raises(InvalidInput, match="summary.json is damaged"):
        read_results(results_folder)


def test_a_file_of_the_folder_names_it(results_folder):
    assert read_results(results_folder / "results.h5").summary["run"] == "0123456789abcdef"


def test_paths_of_a_file_are_in_natural_order(tmp_path):
    summary, datasets = small_results()
    points = [f"truth/body.{i}/displacement" for i in (10, 2, 1)]
    folder = write_folder(tmp_path / "out", summary, {point: datasets["time"] for point in points})
    assert read_results(folder).keys() == points[::-1]


def test_a_run_without_series_has_a_summary(results_folder):
    (results_folder / "results.h5").unlink()
    run = read_results(results_folder)
    assert run.keys() == [] and run.residuals.sensors == [] and run.parameters["mount.k"].value == 19.97832
    assert run.to_pandas().empty


def test_series_of_another_run_are_refused(results_folder):
    run = read_results(results_folder)
    summary, datasets = small_results()
    write_folder(results_folder, {**summary, "run": "fedcba9876543210"}, datasets)
    with pytest.raises(InvalidInput, match="belongs to the run fedcba9876543210, not to 0123456789abcdef"):
        run["time"]


def test_the_report_is_copied_or_written(results_folder, memory_run, tmp_path):
    page = read_results(results_folder).report(tmp_path / "page.html")
    assert page.read_text() == "<html>report</html>"
    assert read_results(results_folder).report(results_folder / "report.html").exists()
    with pytest.raises(InvalidInput, match="this run has no report"):
        memory_run.report(tmp_path / "page.html")
    written = []
    Run.from_memory(*small_results(), report=written.append).report(tmp_path / "other.html")
    assert written == [str(tmp_path / "other.html")]


def test_runs_travel_between_processes(run):
    other = pickle.loads(pickle.dumps(run))
    assert np.array_equal(other["time"], run["time"])
    writes = Run.from_memory(*small_results(), report=lambda path: None)
    assert pickle.loads(pickle.dumps(writes)).parameters["mount.k"] == run.parameters["mount.k"]


def test_arrays_of_a_function_are_made_when_asked_for():
    summary, datasets = small_results()
    calls = []
    run = Run.from_memory(summary, lambda: calls.append(1) or datasets)
    assert run.parameters["mount.k"].value == 19.97832 and not calls
    assert len(run["time"]) == 200 and len(pickle.loads(pickle.dumps(run))["time"]) == 200 and calls == [1]


def test_pandas(run):
    pytest.importorskip("pandas")
    table = run.to_pandas("estimate")
    assert table.index.name == "time" and len(table) == 200
    assert np.array_equal(table["estimate/body.3/displacement"], run["estimate/body.3/displacement"])
    assert not any(column.startswith(("truth", "validation")) for column in table)
    parameters = run.parameters.to_pandas()
    assert parameters.loc["mount.k", "lower_95"] == 19.6 and np.isnan(parameters.loc["body.k", "std"])
    assert run["innovation/nis"].to_pandas().index[1] == 0.01


def test_xarray(run):
    pytest.importorskip("xarray")
    data = run.to_xarray()
    assert data["estimate/body.3/displacement"].attrs["units"] == "m"
    assert float(data["estimate/parameters/mount.k"].sel(time=0.5)) == run["estimate/parameters/mount.k"][50]
    assert data.attrs["status"] == "ok" and "validation/a3/measured" not in data


@pytest.mark.parametrize(
    "module, name, call",
    [
        ("h5py", "h5py", lambda folder: read_results(folder).keys()),
        ("pandas", "pandas", lambda folder: read_results(folder).to_pandas()),
        ("xarray", "xarray", lambda folder: read_results(folder).to_xarray()),
        ("matplotlib.pyplot", "matplotlib", lambda folder: read_results(folder).plot()),
    ],
)
def test_an_absent_package_is_one_message(results_folder, monkeypatch, module, name, call):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(MissingPackage, match=rf"needs {name}: install python3-{name} \(Debian\) or '{name}' \(pip\)"):
        call(results_folder)


def test_series_keep_time_where_samples_are_taken():
    y = TimeSeries([1.0, 2.0, 4.0], t=[0, 1, 2], std=[3, 4, 5], unit="m", name="y")
    assert y[1:].t.tolist() == [1, 2] and y[y > 1.5].std.tolist() == [4, 5] and y[::2].unit == "m"
    assert isinstance(y[1], float) and type(y + 1) is np.ndarray and type(np.sqrt(y)) is np.ndarray
    assert type(y.mean()) is np.float64
    again = pickle.loads(pickle.dumps(y))
    assert again.t.tolist() == [0, 1, 2] and again.unit == "m" and again.name == "y"
    assert repr(y) == "TimeSeries([1., 2., 4.], unit='m', name='y')"


def test_errors_carry_their_issues():
    error = InvalidInput([Issue("k is -1", "must be > 0", "take 1", "a.yaml", 3), Issue("c is missing")])
    assert str(error) == "a.yaml:3: k is -1: must be > 0; take 1\nc is missing"
    again = pickle.loads(pickle.dumps(error))
    assert str(again) == str(error) and again.issues == error.issues and again.issues[0].line == 3


@pytest.mark.parametrize("module", ["errors", "series", "display", "ensemble", "grid"])
def test_examples_in_the_docstrings(module):
    assert doctest.testmod(importlib.import_module(f"kalfem.{module}")).failed == 0
