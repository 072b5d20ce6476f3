# SPDX-License-Identifier: Apache-2.0
"""Measured modes beside those of a model."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from .comparing import MeasuredModes, MeasuredResponses, described
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
class ShapeExpansion:
    """Measured shapes at all degrees of freedom, with what the model's error and noise leave open.

    The truth is taken as the model's mode, mixed with the others as an error of its stiffness mixes them.
    """

    method: str  #: model, serep or dynamic
    stiffness_error: float  #: relative error of the stiffness that the shapes ask for
    noise: float  #: of the measured entries, in the deviations that are stated of them
    dofs: list[str]  #: of the model, one a row
    pairs: list[int]  #: position in ``Correlation.pairs``, one a column
    bands: list[float]  #: size of the deviations against that of the shape, one a column
    shapes: np.ndarray = field(repr=False)  #: shape (dofs, columns), in the scale of the measured ones
    std: np.ndarray = field(repr=False)  #: standard deviations
    model: np.ndarray = field(repr=False)  #: the paired modes of the model in the same scale


@dataclass(frozen=True)
class ResponseAgreement:
    """A measured frequency response beside the model's, over all lines."""

    name: str
    frac: float  #: frequency response assurance criterion, in [0, 1], of any scale
    size: float  #: of the model's against the measured one
    phase: float | None  #: of the model's against the measured one [rad]
    is_turned: bool  #: they agree but for their sign


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
    expansion: ShapeExpansion | None = field(repr=False, default=None)  #: None where no shape has a pair

    def __repr__(self):
        rows = [
            f"{pair.measured:.5g} Hz: no mode agrees (MAC {pair.mac:.3f})"
            if pair.mode is None
            else f"{pair.measured:.5g} Hz: mode {pair.mode} at {pair.model:.5g} Hz ({100 * pair.error:+.2f} %), MAC {pair.mac:.3f}"
            for pair in self.pairs
        ]
        return "\n".join(rows + [mistake.text for mistake in self.mistakes])


def correlate(structure: Structure, modes: MeasuredModes, expansion: str = "model") -> Correlation:
    """Pair measured modes with those of a substructure, and say how they agree, sensor by sensor.

    Parameters
    ----------
    structure : Structure
        After an updating: ``structure.at(...)``.
    modes : MeasuredModes
        With shapes, as of :meth:`ModeSet.measured`. Of errors it counts how those of entries compare with one another.
    expansion : str
        How shapes are carried on to points without a sensor: ``model``, the model's mode mixed with others as the shape
        asks for; ``serep``, the paired modes that fit best; ``dynamic``, the motion at the measured frequency with
        forces at the sensors alone.

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
    found = core.correlate(structure, described({"modes": modes})["modes"], expansion)
    found["pairs"] = [CorrelatedMode(**each) for each in found["pairs"]]
    found["mistakes"] = [SetupMistake(**each) for each in found["mistakes"]]
    if found["expansion"] is not None:
        found["expansion"] = ShapeExpansion(**found["expansion"])
    return Correlation(**found)


def correlate_responses(structure: Structure, responses: MeasuredResponses) -> list[ResponseAgreement]:
    """Compare measured frequency responses with those of a substructure, output by output.

    Parameters
    ----------
    structure : Structure
        After an updating: ``structure.at(...)``.
    responses : MeasuredResponses
        What they state of errors plays no part.

    Returns
    -------
    list of ResponseAgreement

    Raises
    ------
    InvalidInput
        With what does not fit.

    Examples
    --------
    >>> import numpy as np, kalfem as kf
    >>> s = kf.Structure()
    >>> _ = s.add(kf.lumped("m").mass("1", 2.0).spring("k", "ground", "1", 2e3, 4.0))
    >>> sensors = {"a": kf.acceleration("m.1")}
    >>> f = np.linspace(1.0, 10.0, 181)
    >>> turned = {"a": -kf.frf(s, f, "m.1", sensors)["a"]}
    >>> found = kf.correlate_responses(s, kf.MeasuredResponses("m.1", f, sensors, turned))
    >>> round(found[0].frac, 6), found[0].is_turned
    (1.0, True)
    """
    given = described({"responses": responses})["responses"]
    return [ResponseAgreement(**each) for each in core.correlate_responses(structure, given)]
