# SPDX-License-Identifier: Apache-2.0
"""Sweeps: one case many times, its runs shared out to threads, processes or a cluster."""

from __future__ import annotations

import contextlib
import json
import os
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .compiled import core
from .ensemble import share_size
from .errors import InvalidInput, Issue, optional, unknown_name
from .grid import sequence
from .progress import reporter
from .running import as_changes, as_yaml

if TYPE_CHECKING:
    from concurrent.futures import Executor

    import pandas


def sweep(
    case: str | Path,
    grid: Mapping[str, Any] | None = None,
    seeds: int | None = None,
    set: Mapping[str, Any] | None = None,
    executor: Executor | None = None,
    folder: str | Path | None = None,
    progress: bool | Callable[[float, str], None] = True,
) -> Sweep:
    """Run a case with every combination of some values, and with many realisations of the noise.

    A combination is read, and its reference simulated, once for all its seeds in each worker. Every run is that of
    :func:`kalfem.run` with the same settings, to the last bit, whoever makes it.

    Parameters
    ----------
    case : path
    grid : dict of sequences, optional
        Keys of the case with the values that they take; the last key changes fastest.
    seeds : int, optional
        Realisations of the noise of a simulated record, ``simulate.seed`` from 1 to `seeds`; they change faster than
        the keys. By default the case's own noise.
    set : dict, optional
        Keys of every run, see :func:`kalfem.run`.
    executor : concurrent.futures.Executor, optional
        Threads or processes, ``dask.distributed.Client.get_executor()`` or ``mpi4py.futures.MPIPoolExecutor()``. By
        default threads, one per processor: the runs release the interpreter. The share of a worker that died is done
        again, once.
    folder : path, optional
        For the files of ``kalfem sweep``: ``runs.jsonl``, ``sweep.csv``, ``sweep.h5``. A sweep that was killed, here or
        as a command, goes on from there.
    progress : bool or callable
        Show a bar, see :func:`kalfem.progress.reporter`.

    Raises
    ------
    InvalidInput
        Where the first combination cannot be run, or an argument is wrong. Another combination that cannot be run is in
        :attr:`Sweep.refused`.
    RuntimeError
        Where workers died twice. The runs that were made are in the folder.
    """
    plan = _Plan(os.path.abspath(case), tuple(as_changes(set)), _axes(grid), _count(seeds))
    if executor is not None and not callable(getattr(executor, "submit", None)):
        fix = "give for example concurrent.futures.ProcessPoolExecutor(), or leave it out for threads"
        raise InvalidInput(Issue(f"the executor is {executor!r}", "it has no method submit()", fix))
    opened = core.Sweep(*plan)
    files = None if folder is None else core.SweepFolder(os.fspath(folder), opened)
    lines = dict(files.known) if files else {}
    task = _Task(plan, opened.identity)
    missing = [number for number in range(len(opened)) if number not in lines]
    with reporter(progress) as report, _kept(task, opened):
        for number, line in _made(task, missing, executor, opened.stop):
            lines[number] = line
            if files:
                files.add(line)
            report(len(lines) / len(opened), f"run {len(lines)} of {len(opened)}")
    in_order = [lines[number] for number in range(len(opened))]
    if files:
        files.finish(in_order)
    return Sweep(plan, in_order, opened.arrays(in_order))


class Sweep(Mapping):
    """The results of a sweep: arrays over its runs, by the paths of ``sweep.h5``.

    ``sweep["parameters/mount.k/estimate"]``, also ``std`` and ``true``; ``axes/KEY``, ``seed``, ``status``, ``verdict``
    and ``mean_nis``. What is not known is NaN. ``array.reshape(sweep.shape)`` has one dimension a key, then the seeds.
    """

    def __init__(self, plan, lines, arrays):
        runs = [json.loads(line) for line in lines]
        #: ``summary.json`` of every run as a dictionary, without times; None where the case cannot be run.
        self.summaries: list[dict | None] = [run.get("summary") for run in runs]
        #: Why some runs cannot be run, by their numbers.
        self.refused: dict[int, str] = {run["run"]: run["refused"] for run in runs if "refused" in run}
        #: Number of values of each key, and of seeds if there are any.
        self.shape: tuple[int, ...] = tuple(len(values) for _, values in plan.axes) + ((plan.seeds,) * (plan.seeds > 0))
        self._arrays = {path.lstrip("/"): np.asarray(values) for path, (values, _) in arrays.items()}
        self._units = {path.lstrip("/"): unit for path, (_, unit) in arrays.items()}

    def __getitem__(self, path: str) -> np.ndarray:
        if path not in self._arrays:
            raise unknown_name("array", path, self._arrays)
        return self._arrays[path]

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)

    def unit(self, path: str) -> str:
        """The unit of an array."""
        return self._units[path] if path in self._units else self[path]

    def to_pandas(self) -> pandas.DataFrame:
        """A ``pandas.DataFrame`` with one row a run."""
        return optional("pandas", "to_pandas()").DataFrame(self._arrays)

    def __repr__(self):
        refused = f", {len(self.refused)} refused" if self.refused else ""
        return f"<Sweep of {len(self.summaries)} runs{refused}: {', '.join(self)}>"


class _Plan(NamedTuple):
    """The arguments of the compiled Sweep."""

    case: str
    set: tuple
    axes: tuple
    seeds: int


def _axes(grid):
    if grid is not None and not isinstance(grid, Mapping):
        fix = "give keys with their values: {'simulate.duration': ['4 s', '8 s']}"
        raise InvalidInput(Issue(f"the grid is {grid!r}", "must be a dictionary of sequences", fix))
    return tuple((key, tuple(as_yaml(value) for value in sequence(values))) for key, values in (grid or {}).items())


def _count(seeds):
    if seeds is None:
        return 0
    if isinstance(seeds, bool) or not isinstance(seeds, (int, np.integer)) or seeds < 1:
        raise InvalidInput(Issue(f"seeds is {seeds!r}", "must be a whole number from 1", "leave it out for one run"))
    return int(seeds)


class _Task(NamedTuple):
    """What a worker needs to make any run of a sweep."""

    plan: _Plan
    identity: str


_opened: dict[_Task, Any] = {}  # sweeps of this process, shared by its threads
_opening = threading.Lock()


@contextlib.contextmanager
def _kept(task, opened):
    """While it lasts, threads of this process find the sweep as it was opened."""
    _opened[task] = opened
    try:
        yield
    finally:
        _opened.pop(task, None)


def _open(task):
    with _opening:
        if task not in _opened:
            found = core.Sweep(*task.plan)
            if found.identity != task.identity:
                why = "its case, its data or its version of kalfem are not those of who shares the runs out"
                raise InvalidInput(Issue(f"a worker finds another sweep in '{task.plan.case}'", why))
            _opened.clear()  # a worker keeps the last one
            _opened[task] = found
        return _opened[task]


def make_runs(task: _Task, numbers: Sequence[int]) -> list[str]:
    """Runs as lines of ``runs.jsonl``: what a worker does."""
    opened = _open(task)
    return [opened.run_one(number) for number in numbers]


def _made(task, numbers, executor, stop):
    """(number, line) of each run as they are finished. `stop` ends those that threads of this process make."""
    from concurrent.futures import ThreadPoolExecutor  # here: importing the package stays quick

    if executor is None:
        with ThreadPoolExecutor(os.cpu_count()) as threads:
            yield from _made(task, numbers, threads, stop)
        return
    lost, _ = yield from _shared_out(task, numbers, executor, stop)
    if not lost:
        return
    with _renewed(executor) as again:
        lost, error = yield from _shared_out(task, lost, again, stop)
    if lost:
        where = f"run {lost[0]}" + (f" and {len(lost) - 1} others" if len(lost) > 1 else "")
        raise RuntimeError(f"workers died twice with {where} to make: {str(error) or type(error).__name__}") from error


def _shared_out(task, numbers, executor, stop):
    """The same; returns the numbers that dead workers left, and what the last one died of."""
    from concurrent.futures import BrokenExecutor, as_completed

    size = share_size(len(numbers), executor)
    lost, death, waiting = [], None, {}
    try:
        for share in (numbers[i : i + size] for i in range(0, len(numbers), size)):
            try:
                waiting[executor.submit(make_runs, task, share)] = share
            except BrokenExecutor as error:
                lost, death = lost + share, error
        for future in as_completed(list(waiting)):
            share, error = waiting.pop(future), future.exception()
            if isinstance(error, InvalidInput):
                raise error
            if error:
                lost, death = lost + share, error
            else:
                yield from zip(share, future.result())
    except BaseException:
        stop()  # otherwise threads finish their runs before anybody hears of it
        raise
    finally:
        for future in waiting:
            future.cancel()
    return sorted(lost), death


def _renewed(executor):
    """The executor itself, or where its processes have died a new one like it."""
    from concurrent.futures import ProcessPoolExecutor

    if not isinstance(executor, ProcessPoolExecutor):
        return contextlib.nullcontext(executor)
    return ProcessPoolExecutor(executor._max_workers, executor._mp_context, executor._initializer, executor._initargs)
