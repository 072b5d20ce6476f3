# SPDX-License-Identifier: Apache-2.0
"""Case files as structures, records and arguments, and back."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .analysis import _estimate_arguments, _update_arguments
from .comparing import MeasuredModes
from .compiled import core
from .errors import InvalidInput, Issue
from .progress import reporter
from .recipes import made_by
from .records import Record
from .running import as_changes

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ._core import Structure


@dataclass
class Case:
    """What a case file says, in the arguments of the other functions.

    ``kf.estimate(case.structure, case.t, case.y, **case.estimate)`` is ``kf.run`` of that case, bit for bit.

    Attributes
    ----------
    title : str
    structure : Structure
        With the signals of its inputs.
    y : Record or None
        Of the sensors, in SI: measured and prepared, or simulated where the case says so.
    estimate : dict or None
        Arguments of :func:`kalfem.estimate`, without those that have their defaults.
    update : dict or None
        Those of :func:`kalfem.update`; `structure` stays at the values of the case.
    left_out : list of str
        Sections of the case that are not here: ``report``, ``predict``, ...
    """

    title: str
    structure: Structure
    y: Record | None
    estimate: dict[str, Any] | None
    update: dict[str, Any] | None
    left_out: list[str]

    @property
    def t(self) -> np.ndarray | None:
        """Time of the samples of `y` [s]."""
        return None if self.y is None else self.y.t

    def __repr__(self):
        record = "no record" if self.y is None else f"{len(self.y)} sensors, {len(self.y.t)} samples"
        return f"Case({self.title!r}, {self.structure!r}, {record})"


def read_case(
    case: str | Path,
    set: Mapping[str, Any] | None = None,
    progress: bool | Callable[[float, str], None] = True,
) -> Case:
    """Read a case file, to go on from it in Python.

    Parameters
    ----------
    case : path
    set : dict, optional
        Keys with other values, as of :func:`kalfem.run`.
    progress : bool or callable
        Of reductions, and of the simulation where the case makes its record by one.

    Returns
    -------
    Case

    Raises
    ------
    InvalidInput
        With every problem of the case, by file and line, and every key that the arguments have no word for, by its name.
    """
    path, changes = os.path.abspath(case), as_changes(set)
    with reporter(progress) as bar:
        read = core.read_case(path, changes, True, bar)
    record = None if read["record"] is None else Record.from_datasets(read["record"])
    structure = made_by(read["structure"], _structure_of_case, path, changes)
    update = read["update"]
    if update is not None:
        update["compare"] = {name: MeasuredModes(**each) for name, each in update["compare"].items()}
    return Case(read["title"], structure, record, read["estimate"], update, read["left_out"])


def _structure_of_case(path, changes):
    """The structure alone, where a pickle is loaded."""
    return made_by(core.read_case(path, changes, False)["structure"], _structure_of_case, path, changes)


def to_case(
    structure: Structure,
    t: ArrayLike | None = None,
    y: Any = None,
    *,
    inputs: Mapping[str, ArrayLike] | None = None,
    estimate: Mapping[str, Any] | None = None,
    update: Mapping[str, Any] | None = None,
    title: str = "",
    file: str | Path | None = None,
) -> str:
    """Write a structure, a record and what is done with it as a case file.

    Parameters
    ----------
    structure : Structure
        Read from a case or built; its present values count.
    t, y, inputs
        Times, record and samples of inputs, as of :func:`kalfem.estimate`.
    estimate, update : dict, optional
        Arguments of :func:`kalfem.estimate` and :func:`kalfem.update`, this one by natural frequencies.
    title : str
    file : path, optional
        The case file to write. Samples in memory go to tables beside it, with its name; without it they are refused.

    Returns
    -------
    str
        The text of the case. ``kalfem run`` of it gives the numbers of ``kf.estimate`` of the same arguments.

    Raises
    ------
    InvalidInput
        With all that a case cannot say, by its name: functions as laws, matrices of lumped substructures, finite
        elements that were not read with a case, virtual sensors.
    """
    if estimate is not None and t is None:
        raise InvalidInput(Issue("t is not given", "an estimation is one from a record", "give t and y"))
    arguments = None if estimate is None else _estimate_arguments(estimate)
    refined = None if update is None else _update_arguments(update)
    path = "" if file is None else os.fspath(file)
    return core.to_case(structure, t, y, dict(inputs or {}), arguments, refined, title, path)
