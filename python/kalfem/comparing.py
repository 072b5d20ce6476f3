# SPDX-License-Identifier: Apache-2.0
"""Measurements that an updating compares a structure with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from .errors import InvalidInput, Issue

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ._core import Sensor


@dataclass(frozen=True)
class MeasuredModes:
    """Natural frequencies of a substructure without connectors, and mode shapes and dampings where they were measured."""

    substructure: str
    frequencies: ArrayLike  #: [Hz], shape (n,)
    std: float | ArrayLike  #: their standard deviations [Hz]
    modes: Sequence[int | None] | None = None  #: number of the model's mode for each, from 1; by order if None
    above: float = 0.0  #: modes up to this frequency are not elastic ones [Hz]
    points: Sequence[str] = ()  #: of the shapes: ``"frame.tip.z"``
    sensors: Sequence[str] = ()  #: their names, one a point; default: those of the points
    shapes: ArrayLike | None = None  #: shape (points, n), each column in any scale and sign; nan: not measured
    shape_std: float | ArrayLike = 0.05  #: of entries, relative to a shape's largest, or (points, n) in the shapes' unit
    shape_covariances: Sequence[ArrayLike] | None = None  #: one a frequency, shape (points, points), instead
    dampings: ArrayLike | None = None  #: ratios to critical, shape (n,); None: not compared
    damping_std: ArrayLike | None = None  #: their standard deviations, shape (n,)
    weight: float = 1.0  #: factor of its sum of squares


@dataclass(frozen=True)
class MeasuredResponses:
    """Frequency responses of a substructure without connectors to a force at a point, motions exp(+i 2 pi f t)."""

    input: str  #: point of the force: ``"frame.tip.z"``
    frequencies: ArrayLike  #: ascending [Hz], shape (n,)
    outputs: Mapping[str, Sensor]  #: motions of points of the same substructure, all of one quantity
    values: Mapping[str, ArrayLike]  #: per newton, complex, shape (n,), by the names of the outputs, as of ``kf.frf``
    std: Mapping[str, ArrayLike] | None = None  #: of real and of imaginary part, shape (n,); None: `relative_std` alone
    relative_std: float = 0.05  #: of abs(H), for calibration and for what the model cannot do
    smoothing: float = 0.0  #: largest half width to which resonances are widened at first, for a start far off [Hz]
    weight: float = 1.0  #: factor of its sum of squares


@dataclass(frozen=True)
class MeasuredDeflections:
    """Displacements of a substructure without connectors under static forces."""

    forces: Mapping[str, float | str]  #: ``{"frame.tip.z": 100}`` [N]
    displacements: Mapping[str, float | str]  #: ``{"frame.tip.z": "1.2 mm"}`` [m]
    std: float | str  #: of each displacement [m]
    weight: float = 1.0  #: factor of its sum of squares


@dataclass(frozen=True)
class MeasuredRecord:
    """A record of some sensors, to compare with the simulation of the whole structure from rest."""

    t: ArrayLike  #: even times [s], shape (n,)
    y: Any  #: dictionary or DataFrame of name to samples, or array of shape (n, sensors), as in ``kf.estimate``
    sensors: Mapping[str, Sensor]  #: with their noise
    inputs: Mapping[str, ArrayLike] = field(default_factory=dict)  #: samples of inputs that have none yet
    settle: float = 0.0  #: time at the start that does not count [s]
    substeps: int = 4  #: of a sample interval, for the connectors' forces
    weight: float = 1.0  #: factor of its sum of squares


_KINDS = {
    MeasuredModes: "modes",
    MeasuredResponses: "responses",
    MeasuredDeflections: "deflections",
    MeasuredRecord: "record",
}


def described(comparisons: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Comparisons by name, as the compiled module takes them."""
    found, issues = {}, []
    for name, each in comparisons.items():
        if type(each) in _KINDS:
            found[name] = {"kind": _KINDS[type(each)], **vars(each)}
        else:
            kinds = ", ".join(kind.__name__ for kind in _KINDS)
            issues.append(Issue(f"compare['{name}']: {each!r} is given", "a measurement is needed", f"give one of {kinds}"))
    if issues:
        raise InvalidInput(issues)
    return found
