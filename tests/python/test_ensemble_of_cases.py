# SPDX-License-Identifier: Apache-2.0
"""kf.map over a case: the numbers of single runs, its mistakes as values, and what the ensemble itself costs."""

import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("kalfem._core", reason="the compiled module is not built")

import kalfem as kf  # noqa: E402

CHAIN = Path(__file__).parents[2] / "examples/chain/chain.yaml"
SHORT = {"simulate.duration": "1 s", "estimate.settle": "0.2 s"}


@pytest.fixture(params=["threads", "processes"])
def executor(request):
    if request.param == "threads":
        yield None
    else:
        with ProcessPoolExecutor(2) as pool:
            yield pool


def test_runs_of_an_ensemble_are_single_runs(executor):
    runs = kf.map(CHAIN, {"simulate.seed": [1, 2], **SHORT}, executor, progress=False)
    alone = kf.run(CHAIN, set={"simulate.seed": 2, **SHORT}, progress=False)
    assert runs[1].summary["run"] == alone.summary["run"] != runs[0].summary["run"]
    assert dict(runs[1].parameters) == dict(alone.parameters)
    path = "estimate/body.3/displacement"
    assert np.array_equal(runs[1][path], alone[path])
    assert runs[1].keys() == alone.keys()


def test_a_mistake_in_the_settings_is_a_failure_with_its_issues(executor):
    wrong = {"simulate.duration": "4 kg"}
    failure, run = kf.map(CHAIN, [wrong, SHORT], executor, progress=False)
    assert isinstance(failure.error, kf.InvalidInput) and "simulate.duration" in str(failure.error.issues[0])
    assert run.usable


def test_a_folder_of_cases_continues(tmp_path):
    grid = {"simulate.seed": [1, 2], **SHORT}
    first = kf.map(CHAIN, grid, folder=tmp_path, progress=False)
    words = []
    again = kf.map(CHAIN, grid, folder=tmp_path, progress=lambda *call: words.append(call))
    assert [run.summary for run in again] == [run.summary for run in first] and not words


def timed(settings):
    """A run that takes the time of its own work with it."""
    start = time.perf_counter()
    run = kf.run(CHAIN, set={**SHORT, **settings}, progress=False)
    run.summary["timing"]["own"] = time.perf_counter() - start
    return run


@pytest.mark.parametrize("count", [100])
def test_an_ensemble_costs_little_more_than_its_runs(count):
    with ProcessPoolExecutor(2) as pool:
        kf.map(timed, [{}, {}], pool, progress=False)  # workers have started and loaded the package
        start = time.perf_counter()
        runs = kf.map(timed, {"simulate.seed": range(count)}, pool, progress=False)
        elapsed = time.perf_counter() - start
    assert 2 * elapsed < 1.2 * sum(run.summary["timing"]["own"] for run in runs)
