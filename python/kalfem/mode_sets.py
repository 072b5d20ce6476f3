# SPDX-License-Identifier: Apache-2.0
"""Modes that were measured, whoever identified them."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .comparing import MeasuredModes
from .compiled import core
from .errors import InvalidInput, Issue


@dataclass(frozen=True)
class ModeSet:
    """Modes at the points of a test. What is not known is nan, or None."""

    points: list[str]  #: of the shapes: names of channels, or node and direction, ``"12:+Z"``
    frequencies: np.ndarray  #: undamped natural frequencies [Hz], shape (modes,)
    shapes: np.ndarray = field(repr=False)  #: complex, shape (points, modes); nan: not measured
    frequency_std: np.ndarray | None = field(default=None, repr=False)  #: [Hz]
    dampings: np.ndarray | None = None  #: ratios to critical
    damping_std: np.ndarray | None = field(default=None, repr=False)
    covariances: Sequence[np.ndarray] | None = field(default=None, repr=False)  #: of real parts, then imaginary ones
    degrees_of_freedom: np.ndarray | None = field(default=None, repr=False)  #: of the covariances
    nodes: dict[int, tuple[float, float, float]] = field(default_factory=dict, repr=False)  #: positions, where known [m]

    def __len__(self):
        return len(self.frequencies)

    def measured(
        self,
        substructure: str,
        points: Mapping[str, str] | Sequence[str] | None = None,
        *,
        std: float | None = None,
        shape_std: float | None = None,
        dampings: bool = False,
        damping_std: float | None = None,
        max_complexity: float = 0.25,
        **options: Any,
    ) -> MeasuredModes:
        """What :func:`update` compares a model with. Complex shapes are turned to be real.

        Parameters
        ----------
        substructure : str
        points : dict of str to str, or list of str, optional
            Points of the model with the set's names of them, ``{"frame.tip.z": "12:+Z"}``; ``"12:-Z"`` and ``"-a3"``
            look against them. A list: of all points of the set, in their order. None: frequencies alone.
        std, shape_std, damping_std : float, optional
            Relative deviations of frequencies, of entries (to a shape's largest) and of dampings; default: those that
            the modes bring, otherwise 1, 5 and 10 %.
        dampings : bool
            Compare the dampings too.
        max_complexity : float
            Share of a shape that may be out of phase.
        **options
            Others of :class:`MeasuredModes`: ``modes``, ``above``, ``weight``.

        Raises
        ------
        InvalidInput
            With every point that was not measured, and every shape that is too complex.
        """
        if points is None:
            pairs = []
        elif isinstance(points, Mapping):
            pairs = [(str(point), str(name)) for point, name in points.items()]
        elif len(points) == len(self.points):
            pairs = list(zip(points, self.points))
        else:
            raise InvalidInput(
                [Issue(f"{len(points)} points are given", f"the shapes have {len(self.points)}", "name one for each, or give a dictionary")]
            )
        taken = {
            "deviation": std,
            "shape_deviation": shape_std,
            "dampings": dampings,
            "damping_deviation": damping_std,
            "max_complexity": max_complexity,
        }
        return MeasuredModes(**core.measured_modes(vars(self), substructure, pairs, taken), **options)


def read_modes(file: str | Path | os.PathLike) -> ModeSet:
    """Modes of ``modes.json`` of ``kalfem modal``, of a universal file (datasets 55 and 2414), or of a MATLAB file.

    A MATLAB file has ``frequencies`` [Hz] and ``shapes`` (points x modes), and, where they are known, ``points`` (a cell
    of names), ``frequency_std``, ``dampings``, ``damping_std`` and ``shape_std``. A point of a universal file is a node with a direction, ``"12:+Z"``; a direction of a node that is zero in every mode
    is no point.

    Raises
    ------
    InvalidInput
        Where the file cannot be read or holds no modes.
    """
    return ModeSet(**core.read_modes(str(file)))
