# SPDX-License-Identifier: Apache-2.0
"""kf.sweep: the bits of the command wherever runs are made, resumption, workers that die, wrong input."""

import os
import signal
import subprocess
import time
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

pytest.importorskip("kalfem._core", reason="the compiled module is not built")

import kalfem as kf  # noqa: E402
from kalfem import sweeping  # noqa: E402
from programs import output_under_mpi  # noqa: E402

CASE = """kalfem: 1
title: swept
substructures:
  wheel: {masses: {w: 1.5 kg}, springs: [{from: ground, to: w, stiffness: 20 kN/m}]}
  body: {chain: {masses: 2, mass: 1 kg, stiffness: 30 kN/m}, damping: {modal: 1 %}}
connectors:
  suspension: {from: wheel.w, to: body.1, law: linear, parameters: {k: 5 kN/m, c: 10 N s/m}}
excitation:
  road: {base_displacement: wheel.ground, random: {rms: 3 mm, band: [0.5, 30 Hz]}}
sensors:
  a: {acceleration: body.2, noise: 15 %}
simulate: {duration: 0.5 s, sample_rate: 1 kHz, tolerance: 1e-2}
estimate: {unknown: {suspension.k: {initial: 4 kN/m, std: 20 %}}, settle: 0.1 s}
"""
NOISE = "estimate.process_noise.acceleration"
GRID = {NOISE: [0.01, 0.1]}
FILES = ("runs.jsonl", "sweep.csv")


@pytest.fixture
def case(tmp_path):
    file = tmp_path / "case.yaml"
    file.write_text(CASE)
    return file


def quiet_sweep(case, *arguments, **options):
    return kf.sweep(case, *arguments, progress=False, **options)


def command(case, *arguments):
    program = os.environ.get("KALFEM_COMMAND")
    if not program:
        pytest.skip("KALFEM_COMMAND does not name the command")
    return [program, "sweep", str(case), *arguments]


@pytest.fixture(params=["default", "one thread", "processes"])
def executor(request):
    if request.param == "default":
        yield None
    else:
        with ThreadPoolExecutor(1) if request.param == "one thread" else ProcessPoolExecutor(2) as pool:
            yield pool


def test_the_bits_are_those_of_the_command(case, tmp_path, executor):
    options = ["--seeds", "3", "--grid", f"{NOISE}=0.01,0.1", "--out", str(tmp_path / "command")]
    subprocess.run(command(case, *options), check=True, capture_output=True)
    found = quiet_sweep(case, GRID, seeds=3, executor=executor, folder=tmp_path / "python")
    for name in FILES:
        assert (tmp_path / "python" / name).read_bytes() == (tmp_path / "command" / name).read_bytes()
    assert found.shape == (2, 3) and len(found.summaries) == 6 and not found.refused


def test_a_run_is_that_of_run(case):
    found = quiet_sweep(case, GRID, seeds=2, set={"simulate.duration": "0.6 s"})
    alone = kf.run(case, set={NOISE: 0.1, "simulate.seed": 2, "simulate.duration": "0.6 s"}, progress=False)
    assert found["parameters/suspension.k/estimate"][3] == alone.parameters["suspension.k"].value
    assert found.summaries[3]["parameters"] == alone.summary["parameters"]
    assert found.summaries[3]["verdict"] == alone.summary["verdict"]


def test_arrays_by_the_paths_of_the_file(case, tmp_path):
    found = quiet_sweep(case, GRID, seeds=2, folder=tmp_path / "out")
    assert list(found[f"axes/{NOISE}"]) == ["0.01", "0.01", "0.1", "0.1"]
    assert found["seed"].tolist() == [1, 2, 1, 2] and set(found["status"]) == {"ok"}
    assert found["parameters/suspension.k/true"].tolist() == 4 * [5000.0]
    assert found.unit("parameters/suspension.k/std") == "N/m" and found["mean_nis"].shape == (4,)
    with pytest.raises(kf.UnknownName, match=r"no array 'parameters/suspension.k'.*did you mean"):
        found["parameters/suspension.k"]
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "out/sweep.h5") as file:
        for path in found:
            values = file[path].asstr()[:] if file[path].dtype.kind == "O" else file[path][:]
            assert np.array_equal(values, found[path]), path
            assert file[path].attrs.get("unit", "") == found.unit(path)


def test_without_seeds_and_grid_it_is_one_run(case):
    found = quiet_sweep(case)
    assert found.shape == () and len(found.summaries) == 1 and "seed" not in found


def test_a_table(case):
    pytest.importorskip("pandas")
    table = quiet_sweep(case, seeds=2).to_pandas()
    assert table["seed"].tolist() == [1, 2] and "parameters/suspension.k/estimate" in table


def test_a_combination_that_cannot_be_run_says_why(case, executor):
    found = quiet_sweep(case, {"simulate.duration": ["0.5 s", "-1 s"]}, seeds=2, executor=executor)
    assert sorted(found.refused) == [2, 3] and "simulate.duration" in found.refused[3]
    assert found.summaries[2] is None and found["status"].tolist() == ["ok", "ok", "refused", "refused"]
    assert np.isnan(found["parameters/suspension.k/estimate"]).tolist() == [False, False, True, True]


def test_a_killed_command_goes_on_here(case, tmp_path):
    folder, whole = tmp_path / "out", tmp_path / "whole"
    killed = subprocess.Popen(
        command(case, "--seeds", "150", "--threads", "1", "--out", str(folder)), stdout=subprocess.DEVNULL
    )
    log = folder / "runs.jsonl"
    while not log.exists() or log.read_bytes().count(b"\n") < 4:
        assert killed.poll() is None
        time.sleep(0.01)
    killed.send_signal(signal.SIGKILL)
    killed.wait()
    known = log.read_bytes().count(b"\n") - 1
    assert 3 <= known < 150
    words = []
    kf.sweep(case, seeds=150, folder=folder, progress=lambda fraction, text: words.append(text))
    assert len(words) == 150 - known and words[-1] == "run 150 of 150"
    quiet_sweep(case, seeds=150, folder=whole)
    for name in FILES:
        assert (folder / name).read_bytes() == (whole / name).read_bytes()


def test_a_finished_folder_makes_nothing_again(case, tmp_path):
    first = quiet_sweep(case, seeds=3, folder=tmp_path / "out")
    words = []
    again = kf.sweep(case, seeds=3, folder=tmp_path / "out", progress=lambda *call: words.append(call))
    assert not words and again.summaries == first.summaries


def die_once(mark):
    """Where a worker begins: the first one that takes this up ends at once."""
    try:
        os.close(os.open(mark, os.O_CREAT | os.O_EXCL))
    except FileExistsError:
        return
    os._exit(1)


def always_die():
    os._exit(1)


def test_the_share_of_a_dead_worker_is_done_again(case, tmp_path):
    with ProcessPoolExecutor(2, initializer=die_once, initargs=(str(tmp_path / "dead"),)) as pool:
        found = quiet_sweep(case, seeds=6, executor=pool)
    assert (tmp_path / "dead").exists()
    assert found.summaries == quiet_sweep(case, seeds=6).summaries


def test_a_worker_that_is_killed_in_the_middle(case, tmp_path):
    with ProcessPoolExecutor(2) as pool:

        def kill_one(fraction, words):
            for process in list((pool._processes or {}).values())[:1]:
                process.kill()

        found = kf.sweep(case, seeds=60, executor=pool, folder=tmp_path / "out", progress=kill_one)
    assert len(found.summaries) == 60 and None not in found.summaries
    assert found.summaries == quiet_sweep(case, seeds=60).summaries


def test_workers_that_always_die_are_one_clear_error(case, tmp_path):
    with ProcessPoolExecutor(2, initializer=always_die) as pool:
        with pytest.raises(RuntimeError, match="workers died twice with run 0 and 3 others to make"):
            quiet_sweep(case, seeds=4, executor=pool, folder=tmp_path / "out")
    assert len(quiet_sweep(case, seeds=4, folder=tmp_path / "out").summaries) == 4


class Losing:
    """An executor of another kind whose first share gets lost."""

    def __init__(self):
        self.shares = 0

    def submit(self, function, *arguments):
        future, self.shares = Future(), self.shares + 1
        if self.shares == 1:
            future.set_exception(OSError("the worker is gone"))
        else:
            future.set_result(function(*arguments))
        return future


def test_any_executor_makes_a_lost_share_again(case):
    executor = Losing()
    assert quiet_sweep(case, seeds=3, executor=executor).summaries == quiet_sweep(case, seeds=3).summaries
    assert executor.shares == 4


def test_a_worker_with_another_case_is_refused(case):
    plan = sweeping._Plan(str(case), (), (), 2)
    with pytest.raises(kf.InvalidInput, match="a worker finds another sweep"):
        sweeping.make_runs(sweeping._Task(plan, "0123456789abcdef"), [0])


def test_an_exception_of_the_progress_stops_the_sweep(case):
    begin, made = time.perf_counter(), []

    def interrupt(fraction, words):
        made.append(words)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        kf.sweep(case, seeds=100000, progress=interrupt)
    assert len(made) == 1 and time.perf_counter() - begin < 20.0 and not sweeping._opened


@pytest.mark.parametrize(
    "arguments, words",
    [
        ({"grid": {"simulate.duration": []}}, "gives 'simulate.duration' no values"),
        ({"grid": {"simulate.duraton": ["1 s"]}}, "duraton"),
        ({"grid": [{"simulate.duration": "1 s"}]}, "must be a dictionary of sequences"),
        ({"grid": {"estimate.settle": ["0.1 s"]}, "set": {"estimate.settle": "0.2 s"}}, "'estimate.settle' twice"),
        ({"seeds": 0}, "seeds is 0: must be a whole number from 1"),
        ({"seeds": -2}, "seeds is -2"),
        ({"seeds": 2.5}, "seeds is 2.5"),
        ({"executor": 2}, r"the executor is 2: it has no method submit\(\)"),
        ({"set": {"simulate": None}, "seeds": 2}, "does not simulate its record|simulate"),
    ],
)
def test_wrong_arguments_are_refused(case, arguments, words):
    with pytest.raises(kf.InvalidInput, match=words):
        quiet_sweep(case, **arguments)


MPI_PROGRAM = """
import sys
import kalfem as kf
from mpi4py.futures import MPIPoolExecutor

if __name__ == "__main__":
    with MPIPoolExecutor() as executor:
        found = kf.sweep(sys.argv[1], seeds=6, executor=executor, progress=False)
    alone = kf.sweep(sys.argv[1], seeds=6, progress=False)
    print(found.summaries == alone.summaries)
"""


def test_mpi(case, tmp_path):
    assert output_under_mpi(MPI_PROGRAM, tmp_path, str(case)) == "True"
