# SPDX-License-Identifier: Apache-2.0
"""What an ensemble gives: runs that hold their summary, failures as values, and both as a table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from .display import ensemble_html
from .errors import InvalidInput, Issue, optional
from .results import Run
from .tasks import Failed, Summary

if TYPE_CHECKING:
    import pandas


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


def finished(task, settings, outcome):
    """What the caller gets of the outcome of a worker."""
    if isinstance(outcome, Failed):
        return Failure(settings, outcome.error)
    return MemberRun(outcome, task, settings) if isinstance(outcome, Summary) else outcome
