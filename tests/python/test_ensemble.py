# SPDX-License-Identifier: Apache-2.0
"""kf.map over threads, processes, Dask and MPI: order, failures, resumption."""

import os
import pickle
import subprocess
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest
from ensemble_functions import as_set, dies, fails_at_three, logged, mixed, raises_stubbornly, small_run, square
from kalfem import ensemble
from kalfem.ensemble import Failure
from kalfem.errors import InvalidInput
from kalfem.grid import points
from kalfem.tasks import CaseTask
from programs import environment, output_under_mpi


def quiet_map(*arguments, **options):
    return ensemble.map(*arguments, progress=False, **options)


@pytest.fixture(params=["default", "threads", "processes"])
def executor(request):
    if request.param == "default":
        yield None
    else:
        with {"threads": ThreadPoolExecutor, "processes": ProcessPoolExecutor}[request.param](2) as pool:
            yield pool


def test_every_combination_of_a_dictionary_of_lists():
    grid = points({"a": [1, 2], "b": "text", "c": np.array([0.5, 1.5])})
    assert grid[:2] == [{"a": 1, "b": "text", "c": 0.5}, {"a": 1, "b": "text", "c": 1.5}] and len(grid) == 4
    assert type(points([{"a": np.float64(2)}])[0]["a"]) is float
    with pytest.raises(InvalidInput, match=r"grid\[1\] is 7: must be a dictionary of settings; give a list of dict"):
        points([{"a": 1}, 7])


def test_the_order_is_that_of_the_grid(executor):
    grid = [{"x": x, "sleep": 0.05 if x < 2 else 0.0} for x in range(20)]
    assert list(quiet_map(square, grid, executor)) == [x**2 for x in range(20)]


def test_a_large_grid_goes_in_chunks():
    with ProcessPoolExecutor(2) as pool:
        assert list(quiet_map(square, {"x": range(1000)}, pool)) == [x**2 for x in range(1000)]
    assert ensemble._chunk_size(1000, 2) == 15 and ensemble._chunk_size(10, 2) == 1


def test_failures_are_values(executor):
    results = quiet_map(fails_at_three, {"x": range(6)}, executor)
    assert [each for each in results if not isinstance(each, Failure)] == [0, 1, 2, 4, 5]
    failure = results[3]
    assert not failure and isinstance(failure.error, ValueError) and failure.settings == {"x": 3}
    assert str(failure) == "ValueError: three is not allowed" and results.failures == [failure]
    assert results.rows()[3] == {"x": 3, "error": "ValueError: three is not allowed"}
    assert "6 runs, 1 failed" in results._repr_html_()


def test_an_exception_that_cannot_travel_sends_its_message():
    with ProcessPoolExecutor(1) as pool:
        (failure,) = quiet_map(raises_stubbornly, [{}], pool)
    assert str(failure.error) == "Stubborn: one and two"


def test_a_worker_that_dies_is_a_failure():
    with ProcessPoolExecutor(1) as pool:
        (failure,) = quiet_map(dies, [{}], pool)
    assert not failure and "terminated abruptly" in str(failure)


def test_runs_are_small_and_whole_on_demand(executor):
    results = quiet_map(small_run, {"k": [19.0, 21.0]}, executor)
    assert [run.parameters["mount.k"].value for run in results] == [19.0, 21.0]
    assert results[1].verdict.state == "suspicious" and results[1].settings == {"k": 21.0}
    assert len(pickle.dumps(results[1])) < 4000
    assert results[1]["estimate/body.3/displacement"].std[0] == 2e-5
    assert len(pickle.dumps(results[1])) < 4000
    row = results.rows()[0]
    assert row["k"] == 19.0 and row["mount.k"] == 19.0 and row["mount.k std"] == 0.2 and row["verdict"] == "suspicious"


def test_a_run_that_gives_other_numbers_now_is_refused():
    calls = []

    def changes(settings):
        run = small_run({"k": 1.0})
        run.summary["run"] = f"{len(calls)}"
        calls.append(1)
        return run

    (run,) = quiet_map(changes, [{}])
    with pytest.raises(InvalidInput, match="gives other numbers now"):
        run["time"]


def test_a_table_of_the_ensemble():
    pytest.importorskip("pandas")
    table = quiet_map(square, {"x": [1, 2, 3]}).to_pandas()
    assert table["value"].tolist() == [1, 4, 9] and table["x"].tolist() == [1, 2, 3]


def test_a_folder_continues_where_it_stopped(tmp_path):
    log, folder = tmp_path / "log", tmp_path / "kept"
    grid = {"x": [1, 2], "log": str(log)}
    assert list(quiet_map(logged, grid, folder=folder)) == [1, 2]
    assert list(quiet_map(logged, {**grid, "x": [1, 2, 3]}, folder=folder)) == [1, 2, 3]
    assert len(log.read_text().splitlines()) == 3
    for file in folder.glob("*.json"):
        file.write_bytes(b"damaged")
    assert list(quiet_map(logged, grid, folder=folder)) == [1, 2]
    assert len(log.read_text().splitlines()) == 5
    assert not list(folder.glob("*.part"))


def test_failures_are_tried_again(tmp_path):
    assert len(quiet_map(fails_at_three, {"x": [2, 3]}, folder=tmp_path).failures) == 1
    assert len(list(tmp_path.glob("*.json"))) == 1


def test_runs_are_kept_as_text(tmp_path):
    quiet_map(small_run, {"k": [1.0]}, folder=tmp_path)
    (run,) = quiet_map(small_run, {"k": [1.0]}, folder=tmp_path)
    assert run.parameters["mount.k"].value == 1.0
    assert '"settings": {"k": 1.0}' in next(tmp_path.glob("*.json")).read_text()


@pytest.mark.parametrize("ending", [".json", ".npz"])
def test_damaged_files_count_as_absent(tmp_path, ending):
    for content in [b"", b"[]", b"7", b'{"value": {"array": 3}}', b'{"value": {"no": 1, "two": 2}}', b"PK\x03\x04"]:
        quiet_map(mixed, [{"x": 2}], folder=tmp_path)
        for file in [*tmp_path.glob("*.json"), *tmp_path.glob("*.npz")]:
            file.unlink()
            file.with_suffix(ending).write_bytes(content)
        assert quiet_map(mixed, [{"x": 2}], folder=tmp_path)[0]["square"] == 4
        for file in tmp_path.iterdir():
            file.unlink()


def test_values_come_back_as_they_were(tmp_path):
    (first,) = quiet_map(mixed, [{"x": 3}], folder=tmp_path)
    (again,) = quiet_map(mixed, [{"x": 3}], folder=tmp_path)
    assert [file.suffix for file in tmp_path.iterdir()] == [".npz"] and again is not first
    np.testing.assert_array_equal(again.pop("modes"), first.pop("modes"))
    assert again == first and type(again["pair"]) is tuple and type(again["scalar"]) is np.float32
    assert again["at"] == 1 + 3j


class Malicious:
    """A pickle of it makes a file when it is read."""

    def __init__(self, made):
        self.made = made

    def __reduce__(self):
        return open, (str(self.made), "w")


@pytest.mark.parametrize("trust", [False, True])
def test_a_pickle_in_the_folder_is_read_only_with_trust(tmp_path, trust):
    folder, made = tmp_path / "kept", tmp_path / "made"
    quiet_map(square, [{"x": 2}], folder=folder)
    (kept,) = folder.iterdir()
    kept.unlink()
    kept.with_suffix(".pickle").write_bytes(pickle.dumps(Malicious(made)))
    if trust:
        quiet_map(square, [{"x": 2}], folder=folder, trust=True)
    else:
        with pytest.raises(InvalidInput, match="is a pickle: reading a pickle runs code .*; pass trust=True"):
            quiet_map(square, [{"x": 2}], folder=folder)
    assert made.exists() == trust


def test_a_pickle_beside_a_case_is_not_read(tmp_path, monkeypatch):
    case, folder, made = tmp_path / "case.yaml", tmp_path / "kept", tmp_path / "made"
    case.write_text("kalfem: 1")
    monkeypatch.setattr(CaseTask, "__call__", lambda self, settings, progress=False: small_run({"k": 1.0}))
    quiet_map(case, [{}], folder=folder)
    (kept,) = folder.iterdir()
    assert kept.suffix == ".json"
    kept.unlink()
    kept.with_suffix(".pickle").write_bytes(pickle.dumps(Malicious(made)))
    with pytest.raises(InvalidInput, match="is a pickle"):
        quiet_map(case, [{}], folder=folder)
    assert not made.exists()


def test_values_that_need_a_pickle_ask_for_trust(tmp_path):
    with pytest.raises(InvalidInput, match="of type set, which the folder cannot keep.*pass trust=True"):
        quiet_map(as_set, [{"x": 2}], folder=tmp_path)
    assert quiet_map(as_set, [{"x": 2}], folder=tmp_path, trust=True)[0] == {2}
    assert len(list(tmp_path.glob("*.pickle"))) == 1
    assert quiet_map(as_set, [{"x": 2}], folder=tmp_path, trust=True)[0] == {2}


def test_a_pipe_in_the_folder_counts_as_absent(tmp_path):
    quiet_map(square, [{"x": 2}], folder=tmp_path)
    (kept,) = tmp_path.iterdir()
    kept.unlink()
    os.mkfifo(kept)
    assert list(quiet_map(square, [{"x": 2}], folder=tmp_path)) == [4]


def test_settings_that_cannot_be_stored_are_refused(tmp_path):
    with pytest.raises(InvalidInput, match="cannot be stored.*use numbers, text and lists"):
        quiet_map(square, [{"x": object()}], folder=tmp_path)


def test_the_identity_of_a_case_follows_its_files(tmp_path):
    case, record = tmp_path / "case.yaml", tmp_path / "record.csv"
    case.write_text("record: {file: '${KALFEM_ABSENT:-.}/record.csv'}")
    record.write_text("1")
    before = CaseTask(case).identity()
    assert CaseTask(case).identity() == before
    record.write_text("2")
    assert CaseTask(case).identity() != before
    with pytest.raises(InvalidInput, match="there is no case file"):
        CaseTask(tmp_path / "absent.yaml")


def test_an_interrupted_ensemble_stops_at_once(monkeypatch):
    """Ctrl-C while threads run: the points that wait are given up."""
    started = []

    def slow(settings):
        started.append(settings["x"])
        time.sleep(0.1)

    def interrupt(fraction, words):
        raise KeyboardInterrupt

    before = threading.active_count()
    with pytest.raises(KeyboardInterrupt):
        ensemble.map(slow, {"x": range(200)}, progress=interrupt)
    assert len(started) < 20 and threading.active_count() == before


def test_progress_counts_runs_and_failures():
    words = []
    ensemble.map(fails_at_three, {"x": [2, 3]}, progress=lambda fraction, text: words.append((fraction, text)))
    assert words[-1] == (1.0, "2 of 2 runs, 1 failed")


@pytest.fixture
def dask_client(tmp_path):
    """A scheduler and two workers on this machine."""
    distributed = pytest.importorskip("distributed")
    place = tmp_path / "scheduler.json"
    start = [sys.executable, "-m"]
    local = ["--scheduler-file", str(place), "--no-dashboard"]
    commands = [start + ["distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0", *local]]
    commands += 2 * [start + ["distributed.cli.dask_worker", "--host", "127.0.0.1", "--nthreads", "1", *local]]
    started = []
    try:
        for command in commands:
            log = open(tmp_path / f"log{len(started)}", "w")
            started.append(subprocess.Popen(command, env=environment(), cwd=tmp_path, stdout=log, stderr=log))
        with distributed.Client(scheduler_file=str(place), timeout=60) as client:
            client.wait_for_workers(2, timeout=60)
            yield client
    finally:
        for process in reversed(started):
            process.terminate()
            process.wait(30)


def test_dask(dask_client):
    executor = dask_client.get_executor()
    assert ensemble._workers(executor) == 2
    assert list(quiet_map(square, {"x": range(200)}, executor)) == [x**2 for x in range(200)]
    assert str(quiet_map(fails_at_three, {"x": [3]}, executor)[0]) == "ValueError: three is not allowed"
    (run,) = quiet_map(small_run, {"k": [5.0]}, executor)
    assert run.parameters["mount.k"].value == 5.0 and len(run["time"]) == 200


MPI_PROGRAM = """
from ensemble_functions import fails_at_three, small_run, square
from kalfem import ensemble
from mpi4py.futures import MPIPoolExecutor

if __name__ == "__main__":
    with MPIPoolExecutor() as executor:
        squares = list(ensemble.map(square, {"x": range(200)}, executor, progress=False))
        failure = ensemble.map(fails_at_three, {"x": [3]}, executor, progress=False)[0]
        (run,) = ensemble.map(small_run, {"k": [5.0]}, executor, progress=False)
    print(squares == [x**2 for x in range(200)], failure, run.parameters["mount.k"].value)
"""


def test_mpi(tmp_path):
    assert output_under_mpi(MPI_PROGRAM, tmp_path) == "True ValueError: three is not allowed 5.0"
