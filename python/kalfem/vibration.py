# SPDX-License-Identifier: Apache-2.0
"""Modes and frequency responses of a structure about rest, and the comparison of shapes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .compiled import core
from .errors import unknown_name

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ._core import Sensor, Structure


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
