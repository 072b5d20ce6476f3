# SPDX-License-Identifier: Apache-2.0
"""Many runs: over threads, processes, or a cluster."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .grid import points
from .outcomes import Ensemble, Failure, finished
from .progress import reporter
from .store import OutcomeStore
from .tasks import Failed, compute, make_task

if TYPE_CHECKING:
    from concurrent.futures import Executor

__all__ = ["Ensemble", "Failure", "map"]

_CHUNKS_PER_WORKER, _LARGEST_CHUNK = 32, 64


def map(
    case_or_function: str | Path | Callable[[dict], Any],
    grid: Mapping[str, Any] | Iterable[Mapping[str, Any]],
    executor: Executor | None = None,
    folder: str | Path | None = None,
    progress: bool | Callable[[float, str], None] = True,
    trust: bool = False,
) -> Ensemble:
    """Run a case, or call a function, at every point of a grid.

    Parameters
    ----------
    case_or_function : path or callable
        A case file, run with the settings of each point as ``kf.run(case, set=settings)`` does; or a function of the
        settings. A function that returns a :class:`Run` counts as a case.
    grid : dict of sequences, or list of dict
        Settings by their place in the case: ``{"simulate.seed": range(40), "estimate.filter": ["ukf", "ekf"]}`` is
        every combination; a list gives the points themselves.
    executor : concurrent.futures.Executor, optional
        Threads or processes, ``dask.distributed.Client.get_executor()`` or ``mpi4py.futures.MPIPoolExecutor()``. By
        default threads, one per processor. Processes need functions that can be imported.
    folder : path, optional
        Keeps each outcome as soon as it arrives, by the content of case and settings: an ensemble that was killed
        continues, one that grows computes what is new. Failures are not kept. Runs, and values of numbers, text,
        arrays, lists, tuples and dictionaries, are kept as JSON or npz.
    progress : bool or callable
        Show a bar, see :func:`kalfem.progress.reporter`.
    trust : bool, optional
        Keep other values in the folder too, as pickles. Reading a pickle runs code of whoever wrote it: pass True only
        if nobody else can write into the folder.

    Returns
    -------
    Ensemble
        Outcomes in the order of the grid. A point that raises becomes a :class:`Failure` and stops no other. A run
        holds its parameters, verdict and summary; its arrays are computed again when you ask for one.

    Examples
    --------
    >>> def double(settings):
    ...     return 2 * settings["x"]
    >>> list(map(double, {"x": [1, 2, 3]}, progress=False))
    [2, 4, 6]
    """
    task, settings = make_task(case_or_function), points(grid)
    store = OutcomeStore(folder, task, trust) if folder is not None else None
    kept = [store.load(point) if store else None for point in settings]
    outcomes = [each[0] if each else None for each in kept]
    open_points = [i for i, each in enumerate(kept) if each is None]
    done, failed = len(settings) - len(open_points), 0
    with reporter(progress) as report:
        for place, outcome in _computed(task, settings, open_points, executor):
            outcomes[place] = outcome
            if isinstance(outcome, Failed):
                failed += 1
            elif store:
                store.save(settings[place], outcome)
            done += 1
            report(done / len(settings), f"{done} of {len(settings)} runs" + (f", {failed} failed" if failed else ""))
    return Ensemble((finished(task, point, each) for point, each in zip(settings, outcomes)), settings)


def _computed(task, settings, places, executor):
    """(place, outcome) of each open point as they arrive."""
    from concurrent.futures import ThreadPoolExecutor  # here: importing the package stays quick

    if executor is None:
        with ThreadPoolExecutor(os.cpu_count()) as threads:
            yield from _computed(task, settings, places, threads)
        return
    stop = threading.Event()

    def stop_if_told(fraction, words):
        if stop.is_set():
            raise InterruptedError("the ensemble was interrupted")

    in_threads = isinstance(executor, ThreadPoolExecutor)
    size = share_size(len(places), executor)
    try:
        yield from _submitted(executor, task, settings, places, size, stop_if_told if in_threads else False)
    finally:
        stop.set()


def _submitted(executor, task, settings, places, size, progress):
    from concurrent.futures import as_completed

    chunks = [places[i : i + size] for i in range(0, len(places), size)]
    waiting = {executor.submit(compute, task, [settings[i] for i in chunk], progress): chunk for chunk in chunks}
    try:
        for future in as_completed(waiting):
            chunk = waiting[future]
            error = future.exception()  # of the worker itself: it died, or could not receive the task
            yield from zip(chunk, [Failed(error)] * len(chunk) if error else future.result())
    finally:
        for future in waiting:
            future.cancel()


def share_size(count, executor):
    """How many of `count` tasks go to a worker at once; one to a thread, which they reach at no cost."""
    from concurrent.futures import ThreadPoolExecutor

    return 1 if isinstance(executor, ThreadPoolExecutor) else _chunk_size(count, _workers(executor))


def _chunk_size(count, workers):
    """Large enough that the way to a worker costs nothing, small enough that all workers end together."""
    return max(1, min(_LARGEST_CHUNK, count // (_CHUNKS_PER_WORKER * workers)))


def _workers(executor):
    client = getattr(executor, "_client", None)  # of dask.distributed
    if client is not None:
        return max(1, sum(client.ncores().values()))
    return getattr(executor, "_max_workers", None) or 8
