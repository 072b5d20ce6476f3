# SPDX-License-Identifier: Apache-2.0
"""Results of a run, from a folder or from memory.

Both sources use the paths and attributes of ``results.h5``, so that ``kf.run(...)["estimate/body.3/displacement"]`` and
``kf.read_results("out/chain")["estimate/body.3/displacement"]`` are the same array. Nothing here needs the compiled
module.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from .display import run_html
from .errors import InvalidInput, Issue, unknown_name
from .fixed_numbers import FixedNumbers, Freed
from .held_out import HeldOut
from .parameters import Parameter, Parameters, Verdict
from .residuals import Residuals
from .series import TimeSeries
from .sources import FolderSource, MemorySource, read_summary

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure


def read_results(folder: str | Path) -> Run:
    """Read the results that the command or ``kf.run`` wrote.

    Parameters
    ----------
    folder : path
        That of ``kalfem run CASE --out FOLDER``; one of its files names it too.

    Returns
    -------
    Run
        Its series are read from ``results.h5`` when you ask for them, which needs h5py.

    Raises
    ------
    InvalidInput
        Where the folder holds no results.
    """
    return Run.from_folder(folder)


class Run:
    """The results of one run. ``run["estimate/body.3/displacement"]`` is a :class:`TimeSeries`.

    Attributes
    ----------
    summary : dict
        The content of ``summary.json``; what is not known is None.
    parameters : Parameters
        Estimated and updated ones by name: ``run.parameters["suspension.mu_k1"].value``.
    verdict : Verdict
        ``run.verdict.state`` is ``consistent``, ``suspicious`` or ``unusable``.
    """

    def __init__(self, summary: dict, source, report=None):
        self.summary = summary
        self.verdict = Verdict.from_summary(summary.get("verdict", {}))
        entries = {**summary.get("updating", {}).get("parameters", {}), **summary.get("parameters", {})}
        self.parameters = Parameters(Parameter.from_summary(*item) for item in entries.items())
        self._source, self._report = source, report

    @classmethod
    def from_folder(cls, folder: str | Path) -> Run:
        """The results in a folder, see :func:`read_results`."""
        folder = Path(folder)
        if folder.is_file():
            folder = folder.parent
        summary = read_summary(folder)
        return cls(summary, FolderSource(folder, summary.get("run")), folder / "report.html")

    @classmethod
    def from_memory(cls, summary: dict | str, datasets, report: Callable[[str], None] | None = None) -> Run:
        """Results that the compiled module computed.

        Parameters
        ----------
        summary : dict or str
            The content of ``summary.json``; of its keys ``verdict``, ``status``, ``message``, ``parameters`` and
            ``estimation`` are used where they exist.
        datasets : dict of path to (array, dict), or a function that returns it
            The datasets of ``results.h5`` with their attributes ``unit`` and, for a series over ``time``,
            ``sample_rate``. Further ones that the file does not hold: ``innovation/covariance`` (samples x sensors x
            sensors) and ``innovation/scores/PARAMETER`` (samples).
        report : callable, optional
            ``report(path)`` writes the page ``report.html``.
        """
        summary = json.loads(summary) if isinstance(summary, (str, bytes)) else summary
        return cls(summary, MemorySource(datasets), report)

    @property
    def usable(self) -> bool:
        """Whether every step ran to its end and nothing in the numbers makes them worthless."""
        return self.summary.get("status") == "ok"

    @property
    def message(self) -> str:
        """Why the run is not usable, in words; empty if it is."""
        return self.summary.get("message") or ""

    @property
    def sensitivity(self) -> FixedNumbers:
        """Numbers that the estimation held fixed, and how much they matter: see :class:`FixedNumber`."""
        return FixedNumbers(self.summary.get("sensitivity", {"numbers": []}))

    @property
    def freed(self) -> Freed:
        """Fixed numbers that the record asks to change, tried as unknowns: see :class:`Freed`."""
        return Freed.from_summary(self.summary.get("freed", {}))

    @property
    def held_out(self) -> HeldOut:
        """Sensors predicted from all others, as virtual ones: see :class:`HeldOutSensor`."""
        return HeldOut(self.summary.get("held_out", {}))

    @property
    def residuals(self) -> Residuals:
        """Innovations with their deviations: see :class:`Residuals`."""
        return Residuals(self)

    def keys(self) -> list[str]:
        """Paths of all arrays, as in ``results.h5``."""
        return self._source.paths()

    def __iter__(self):
        return iter(self.keys())

    def __contains__(self, path: str) -> bool:
        return path.strip("/") in self.keys()

    def __getitem__(self, path: str) -> TimeSeries:
        path = path.strip("/")
        if path not in self.keys():
            raise unknown_name("array", path, self.keys())
        values, attributes = self._source.read(path)
        std = self._source.read(path + "_std")[0] if path + "_std" in self.keys() else None
        return TimeSeries(values, self._time_of(path, len(values), attributes), std, attributes.get("unit", ""), path)

    def _time_of(self, path, count, attributes):
        """Samples of a group have the group's own time, or the first ones of the run's."""
        for group in list(Path(path).parents)[:-1]:
            if f"{group}/time" in self.keys():
                return self._source.read(f"{group}/time")[0]
        if "sample_rate" not in attributes or "time" not in self.keys():
            return None
        return self._source.read("time")[0][:count]

    def to_pandas(self, group: str = "") -> pandas.DataFrame:
        """A ``pandas.DataFrame`` over time with one column a path; `group`: of those that begin with it."""
        from .tables import run_to_pandas

        return run_to_pandas(self, group)

    def to_xarray(self, group: str = "") -> xarray.Dataset:
        """An ``xarray.Dataset`` over ``time`` with units; `group`: of the paths that begin with it."""
        from .tables import run_to_xarray

        return run_to_xarray(self, group)

    def report(self, path: str | Path) -> Path:
        """Write the report, one self-contained HTML page. Returns its path."""
        path = Path(path)
        if callable(self._report):
            self._report(str(path))
        elif self._report is None or not self._report.exists():
            fix = "run a case file: kf.run(CASE, ...).report(PATH)"
            raise InvalidInput(Issue("this run has no report", "only case files make one", fix))
        elif path.resolve() != self._report.resolve():
            path.write_bytes(self._report.read_bytes())
        return path

    def plot(self, what: str = "overview", **options) -> Figure:
        """Draw with Matplotlib: ``overview``, ``parameters``, ``states``, ``innovations`` or ``law``.

        Options are those of the function of that name in :mod:`kalfem.plots`. Returns the figure.
        """
        from . import plots

        kinds = {kind: getattr(plots, kind) for kind in ("overview", "parameters", "states", "innovations", "law")}
        if what not in kinds:
            raise unknown_name("plot", what, kinds)
        return kinds[what](self, **options)

    def _ipython_key_completions_(self):
        return self.keys()

    def __getstate__(self):
        """Runs travel between processes; a function that writes the report stays behind."""
        state = dict(self.__dict__)
        if callable(self._report):
            state["_report"] = None
        return state

    def __repr__(self):
        title = self.summary.get("title") or self.summary.get("case") or "run"
        return "\n".join([f"{title}: {self.verdict.state}", *map(str, self.parameters.values())])

    def _repr_html_(self):
        return run_html(self)
