"""Many runs: over threads, processes, or a cluster."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .display import ensemble_html
from .errors import InvalidInput, Issue, optional
from .grid import points
from .progress import reporter
from .results import Run
from .store import OutcomeStore
from .tasks import Failed, Summary, compute, make_task

if TYPE_CHECKING:
    from concurrent.futures import Executor

    import pandas

_CHUNKS_PER_WORKER, _LARGEST_CHUNK = 32, 64


class Failure:
    """A point whose run raised an exception: `settings`, `error`. It is False in a condition."""

    def __init__(self, settings, error):
        self.settings, self.error = settings, error

    def __bool__(self):
        return False

    def __str__(self):
        return f"{type(self.error).__name__}: {self.error}"

    def __repr__(self):
        return f"Failure({self.settings}, {self})"


class MemberRun(Run):
    """A run of an ensemble. It holds its summary; its arrays are computed again when you ask for one."""

    def __init__(self, summary, task, settings):
        super().__init__(dict(summary), _Again(task, settings, summary.get("run")))
        self.settings = settings

    def report(self, path):
        """Write the report, see :meth:`Run.report`."""
        return self._source.run().report(path)


class _Again:
    """The arrays of a run that is made again; they stay in this process."""

    def __init__(self, task, settings, identity):
        self._task, self._settings, self._identity, self._run = task, settings, identity, None

    def run(self):
        if self._run is None:
            run = self._task(self._settings)
            if run.summary.get("run") != self._identity:
                why = "the case, its files or the program changed since"
                raise InvalidInput(Issue(f"the run with {self._settings} gives other numbers now", why, "map it again"))
            self._run = run
        return self._run

    def paths(self):
        return self.run()._source.paths()

    def read(self, path):
        return self.run()._source.read(path)

    def __getstate__(self):
        return {**self.__dict__, "_run": None}


class Ensemble(Sequence):
    """Outcomes in the order of the grid: of a case :class:`Run`, of a function its value, or :class:`Failure`."""

    def __init__(self, outcomes, settings):
        self._outcomes, self.settings = list(outcomes), list(settings)

    def __getitem__(self, place):
        return self._outcomes[place]

    def __len__(self):
        return len(self._outcomes)

    @property
    def failures(self) -> list[Failure]:
        return [each for each in self if isinstance(each, Failure)]

    def rows(self) -> list[dict]:
        """One dictionary a point: its settings, then parameters with deviations and the verdict, or the value."""
        return [{**settings, **_row(outcome)} for settings, outcome in zip(self.settings, self)]

    def to_pandas(self) -> pandas.DataFrame:
        """A ``pandas.DataFrame`` of :meth:`rows`."""
        return optional("pandas", "to_pandas()").DataFrame(self.rows())

    def __repr__(self):
        return f"Ensemble of {len(self)} runs, {len(self.failures)} failed"

    def _repr_html_(self):
        return ensemble_html(self)


def _row(outcome):
    if isinstance(outcome, Failure):
        return {"error": str(outcome)}
    if not isinstance(outcome, Run):
        return outcome if isinstance(outcome, dict) else {"value": outcome}
    row = {}
    for name, found in outcome.parameters.items():
        row[name], row[f"{name} std"] = found.value, found.std
    return {**row, "verdict": outcome.verdict.state}


def map(
    case_or_function: str | Path | Callable[[dict], Any],
    grid: Mapping[str, Any] | Iterable[Mapping[str, Any]],
    executor: Executor | None = None,
    folder: str | Path | None = None,
    progress: bool | Callable[[float, str], None] = True,
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
        continues, one that grows computes what is new. Failures are not kept.
    progress : bool or callable
        Show a bar, see :func:`kalfem.progress.reporter`.

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
    store = OutcomeStore(folder, task) if folder is not None else None
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
    return Ensemble((_finish(task, point, each) for point, each in zip(settings, outcomes)), settings)


def _finish(task, settings, outcome):
    if isinstance(outcome, Failed):
        return Failure(settings, outcome.error)
    return MemberRun(outcome, task, settings) if isinstance(outcome, Summary) else outcome


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
    size = 1 if in_threads else _chunk_size(len(places), _workers(executor))
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


def _chunk_size(count, workers):
    """Large enough that the way to a worker costs nothing, small enough that all workers end together."""
    return max(1, min(_LARGEST_CHUNK, count // (_CHUNKS_PER_WORKER * workers)))


def _workers(executor):
    client = getattr(executor, "_client", None)  # of dask.distributed
    if client is not None:
        return max(1, sum(client.ncores().values()))
    return getattr(executor, "_max_workers", None) or 8
