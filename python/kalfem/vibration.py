# SPDX-License-Identifier: Apache-2.0
"""Modes and frequency responses of a structure about rest, and the comparison of shapes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .compiled import core
from .errors import unknown_name
from .progress import reporter

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ._core import Sensor, Structure
    from .analysis import Progress


@dataclass(frozen=True)
class Modes:
    """Free vibration of a structure about rest. ``modes["body.1"]`` is the row of a degree of freedom."""

    dofs: tuple  #: names of the rows of the shapes
    frequencies: np.ndarray  #: undamped [Hz], ascending, shape (modes,); rigid-body modes are 0
    damping: np.ndarray  #: ratio to critical, shape (modes,)
    shapes: np.ndarray  #: shape (degrees of freedom, modes), mass-normalised

    def __getitem__(self, dof):
        if dof not in self.dofs:
            raise unknown_name("degree of freedom", dof, self.dofs)
        return self.shapes[self.dofs.index(dof)]

    def __len__(self):
        return len(self.frequencies)

    def __repr__(self):
        return "Modes at " + ", ".join(f"{f:.4g}" for f in self.frequencies[:10]) + (" ... Hz" if len(self) > 10 else " Hz")


def modes(structure: Structure, count: int = 0, *, substructure: str | None = None) -> Modes:
    """Lowest modes of a structure, its connectors linear about rest and its grounds held.

    Parameters
    ----------
    structure : Structure
    count : int
        How many; 0: all, of at most 1000 degrees of freedom.
    substructure : str, optional
        Of this substructure alone, without connectors.

    Examples
    --------
    >>> import kalfem as kf
    >>> s = kf.Structure()
    >>> _ = s.add(kf.lumped("m").mass("1", 2.0).spring("k", "ground", "1", 2e3, 4.0))
    >>> found = kf.modes(s)
    >>> found.frequencies.round(3), found.damping.round(4)
    (array([5.033]), array([0.0316]))
    """
    dofs, frequencies, damping, shapes = core.modes(structure, count, substructure)
    return Modes(tuple(dofs), frequencies, damping, shapes)


def frf(structure: Structure, frequencies: ArrayLike, input: str, outputs: Mapping[str, Sensor]) -> dict[str, np.ndarray]:
    """Frequency responses of a structure, linear about rest, with motions exp(+i 2 pi f t).

    Parameters
    ----------
    structure : Structure
    frequencies : array, shape (n,)
        [Hz].
    input : str
        A force or a moved ground of the structure by its name, or a point at which a unit force acts.
    outputs : dict of str to Sensor
        ``{"a3": kf.acceleration("body.3")}``.

    Returns
    -------
    dict of str to complex array of shape (n,)
        Motion per newton, or per metre of the ground [SI].

    Examples
    --------
    >>> import kalfem as kf
    >>> s = kf.Structure()
    >>> _ = s.add(kf.lumped("m").mass("1", 2.0).spring("k", "ground", "1", 2e3))
    >>> abs(kf.frf(s, [0.0], "m.1", {"x": kf.displacement("m.1")})["x"] * 2e3).round(6)
    array([1.])
    """
    values = core.frf(structure, frequencies, input, dict(outputs))
    return {name: values[:, i] for i, name in enumerate(outputs)}


class Peak(NamedTuple):
    """A resonance in the magnitude of a frequency response."""

    frequency: float  #: natural frequency [Hz], of one pole fitted to the lines around it
    damping: float | None  #: ratio to critical; None where the lines around it do not show it
    magnitude: float  #: of its highest line


class Difference(NamedTuple):
    """How far the reduced model's H_r is from the full model's H."""

    at_resonances: float | None  #: largest abs(H_r - H) / abs(H at the peak); None without peaks
    between: float | None  #: largest abs(H_r - H) / abs(H) on all other lines
    between_at: float  #: where that is [Hz]


@dataclass(frozen=True)
class FrequencyResponse:
    """One response: a motion or strain per newton, or per metre of the ground."""

    unit: str
    full: np.ndarray | None  #: H of the full model, complex, shape (lines,); None if it was not asked for
    reduced: np.ndarray | None  #: the same of the reduced model
    peaks: list[Peak]  #: of the full model where it was asked for, ascending
    difference: Difference | None  #: if both models were asked for

    @property
    def values(self) -> np.ndarray:
        """H of the full model, or of the reduced one where that alone was asked for."""
        return self.reduced if self.full is None else self.full

    def __repr__(self):
        peaks = ", ".join(f"{peak.frequency:.4g}" for peak in self.peaks)
        return f"FrequencyResponse [{self.unit}], " + (f"peaks at {peaks} Hz" if peaks else "no peak")


class FrequencyResponses(Mapping[tuple[str, str], FrequencyResponse]):
    """Responses by input and output: ``responses["hammer", "a3"]``.

    Attributes
    ----------
    frequencies : array, shape (lines,)
        [Hz].
    warnings : list of str
        Reduced models that hold no modes at the highest lines.
    """

    def __init__(self, frequencies, responses, warnings):
        self.frequencies, self._responses, self.warnings = frequencies, dict(responses), list(warnings)

    def __getitem__(self, key: tuple[str, str]) -> FrequencyResponse:
        if key not in self._responses:
            raise unknown_name("response", key, map(str, self._responses))
        return self._responses[key]

    def __iter__(self):
        return iter(self._responses)

    def __len__(self):
        return len(self._responses)

    def __repr__(self):
        lines = [f"{output} per {input}: {each}" for (input, output), each in self.items()]
        return "\n".join(lines)


def frequency_responses(
    structure: Structure,
    frequencies: ArrayLike,
    inputs: Sequence[str],
    outputs: Mapping[str, Sensor],
    *,
    model: str = "full",
    method: str = "modal",
    progress: Progress = True,
) -> FrequencyResponses:
    """Frequency responses with their peaks, of finite elements at full order, reduced, or both.

    Parameters
    ----------
    structure : Structure
    frequencies : array, shape (n,)
        Ascending [Hz].
    inputs : list of str
        Forces or moved grounds of the structure by their names, or points at which unit forces act.
    outputs : dict of str to Sensor
        ``{"a3": kf.acceleration("body.3")}``.
    model : str
        Of the finite elements: ``full``, ``reduced`` as their ``reduce()`` says, or ``both`` and how far they are apart.
    method : str
        ``modal``: a basis of modes and residual vectors for all lines; ``direct``: one factorisation a line.

    Returns
    -------
    FrequencyResponses
        ``responses["hammer", "a3"].values``, ``.peaks``, ``.difference``.

    Raises
    ------
    InvalidInput
        With every argument that is wrong, and at lines where an undamped mode resonates.

    Examples
    --------
    >>> import numpy as np, kalfem as kf
    >>> s = kf.Structure()
    >>> _ = s.add(kf.lumped("m").mass("1", 2.0).spring("k", "ground", "1", 2e3, 4.0))
    >>> found = kf.frequency_responses(s, np.linspace(1, 10, 181), ["m.1"], {"x": kf.displacement("m.1")}, progress=False)
    >>> found
    x per m.1: FrequencyResponse [m/N], peaks at 5.028 Hz
    >>> round(found["m.1", "x"].peaks[0].damping, 4)
    0.0317
    """
    with reporter(progress) as bar:
        found = core.frequency_responses(structure, frequencies, list(inputs), dict(outputs), model, method, bar)
    names = [(input, output) for input in inputs for output in outputs]
    responses = [
        FrequencyResponse(
            unit=each["unit"],
            full=each["full"],
            reduced=each["reduced"],
            peaks=[Peak(*peak) for peak in each["peaks"]],
            difference=None if each["difference"] is None else Difference(*each["difference"]),
        )
        for each in found["responses"]
    ]
    return FrequencyResponses(found["frequencies"], zip(names, responses), found["warnings"])


def mac(a: ArrayLike, b: ArrayLike) -> np.ndarray:
    """Modal assurance criterion |a_i^H b_j|^2 / (a_i^H a_i  b_j^H b_j) between all columns of two sets of shapes.

    Parameters
    ----------
    a, b : array, shape (points, modes), real or complex
        Or of shape (points,): one mode.

    Returns
    -------
    array, shape (modes of a, modes of b)
        In [0, 1].

    Examples
    --------
    >>> import kalfem as kf
    >>> kf.mac([[1.0, 1.0], [1.0, -1.0]], [2.0, 2.0])
    array([[1.],
           [0.]])
    """
    return core.mac(a, b)
