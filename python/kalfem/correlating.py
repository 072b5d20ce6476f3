# SPDX-License-Identifier: Apache-2.0
"""Measured modes beside those of a model."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from .comparing import MeasuredModes, described
from .compiled import core

if TYPE_CHECKING:
    from ._core import Structure


@dataclass(frozen=True)
class CorrelatedMode:
    """A measured mode and the mode of the model that it is paired with."""

    measured: float  #: [Hz]
    mode: int | None  #: number of the model's mode, from 1; None where none agrees
    model: float | None  #: [Hz]
    error: float | None  #: model / measured - 1
    mac: float  #: of the pair; where there is none, the best there is


@dataclass(frozen=True)
class SetupMistake:
    """What is wrong with a sensor of the test."""

    kind: str  #: turned, swapped, direction (another axis), rotated (those of a node together) or node (elsewhere)
    sensors: list[str]  #: the sensor; of swapped ones both, of rotated ones all of the node
    place: str  #: where the model has what it measured; of rotated ones the rotation
    text: str  #: in words
    mac_before: float  #: mean over the pairs
    mac_after: float  #: once it is mended
    evidence: float = field(repr=False)  #: gain in log-likelihood, less that of the best of as many by chance


@dataclass(frozen=True)
class Correlation:
    """Modes by pairs, sensors by name; what is wrong with the set-up, the most certain mistake first."""

    pairs: list[CorrelatedMode]
    comac: dict[str, float]  #: by sensor; nan without two pairs
    mistakes: list[SetupMistake]
    frequencies: np.ndarray = field(repr=False)  #: of the model's elastic modes [Hz]
    mac: np.ndarray = field(repr=False)  #: shape (measured, model)
    auto_mac: np.ndarray = field(repr=False)  #: shape (measured, measured)
    orthogonality: np.ndarray | None = field(repr=False)  #: of the pairs, with the mass reduced to the sensors (SEREP)

    def __repr__(self):
        rows = [
            f"{pair.measured:.5g} Hz: no mode agrees (MAC {pair.mac:.3f})"
            if pair.mode is None
            else f"{pair.measured:.5g} Hz: mode {pair.mode} at {pair.model:.5g} Hz ({100 * pair.error:+.2f} %), MAC {pair.mac:.3f}"
            for pair in self.pairs
        ]
        return "\n".join(rows + [mistake.text for mistake in self.mistakes])


def correlate(structure: Structure, modes: MeasuredModes) -> Correlation:
    """Pair measured modes with those of a substructure, and say how they agree, sensor by sensor.

    Parameters
    ----------
    structure : Structure
        After an updating: ``structure.at(...)``.
    modes : MeasuredModes
        With shapes, as of :meth:`ModeSet.measured`; what they state of errors plays no part.

    Returns
    -------
    Correlation

    Raises
    ------
    InvalidInput
        With what does not fit.

    Examples
    --------
    >>> import kalfem as kf
    >>> frame = kf.chain("frame", 4, mass=1.0, stiffness=5e3).spring("foot", "ground", "1", 5e3)
    >>> s = kf.Structure().add(frame)
    >>> exact = kf.modes(s, substructure="frame")
    >>> shapes = exact.shapes[:, :3].copy()
    >>> shapes[2] *= -1
    >>> points = [f"frame.{i}" for i in range(1, 5)]
    >>> found = kf.correlate(s, kf.MeasuredModes("frame", exact.frequencies[:3], 0.01, points=points, shapes=shapes))
    >>> found.mistakes[0].text
    'frame.3 is turned: it measures against its direction'
    """
    found = core.correlate(structure, described({"modes": modes})["modes"])
    found["pairs"] = [CorrelatedMode(**each) for each in found["pairs"]]
    found["mistakes"] = [SetupMistake(**each) for each in found["mistakes"]]
    return Correlation(**found)
