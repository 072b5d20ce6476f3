# SPDX-License-Identifier: Apache-2.0
"""Finished runs side by side."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .compiled import core


def compare_runs(folders: Sequence[str | Path], population: bool = False) -> RunComparison:
    """Compare finished runs as `kalfem compare` does: filters, sensor sets or records beside each other.

    Parameters
    ----------
    folders : sequence of paths
        Of two or more runs, by the command or by ``kf.run(case, out=folder)``. The others are compared with the first.
    population : bool
        The runs are of nominally equal structures, or campaigns at one, each with data of its own:
        ``summary["population"]`` then has, of each parameter, the mean, the spread (standard deviation of the true
        values) and the interval of the next member, 95 %, and each run's value with what the others tell of it.

    Returns
    -------
    RunComparison
        ``print(found)`` shows the tables of the command; ``found.summary`` has their numbers, ``found.warnings`` what
        keeps the runs from being compared.

    Raises
    ------
    InvalidInput
        With every folder that holds no results, where fewer than two are given, or where no parameter has a population.
    """
    one = isinstance(folders, (str, os.PathLike))
    return RunComparison(core.compare_runs([os.fspath(folder) for folder in ([folders] if one else folders)], population))


class RunComparison:
    """Finished runs side by side. As text it is what `kalfem compare` prints.

    Attributes
    ----------
    summary : dict
        What `kalfem compare --json` prints: numbers in SI units, None for what a run does not have.
    warnings : list of str
        Where the runs do not rest on the same data or the same truth; empty if they do.
    """

    def __init__(self, compared):
        self._compared = compared
        self.summary: dict[str, Any] = json.loads(compared.summary)
        self.warnings: list[str] = compared.warnings

    def __repr__(self):
        return str(self._compared)

    def report(self, path: str | Path) -> None:
        """Write the page of ``kalfem compare --page``: the tables, the identified laws, the parameters over time."""
        self._compared.write_page(os.fspath(path))
