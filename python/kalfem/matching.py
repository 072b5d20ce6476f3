# SPDX-License-Identifier: Apache-2.0
"""The nodes of a model at which the sensors of a test sit."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .compiled import core

if TYPE_CHECKING:
    from ._core import FiniteElements


@dataclass(frozen=True)
class PlaceFit:
    """How the test's places lie in the model: scale * rotation @ place + shift."""

    rotation: NDArray[np.float64]
    shift: NDArray[np.float64]  #: [m]
    scale: float
    rms: float  #: distance of the points from their nodes [m]


@dataclass(frozen=True)
class MatchedPoint:
    """The node of one point."""

    name: str
    node: int
    distance: float  #: of the fitted place from it [m]
    next_node: int | None
    next_distance: float  #: [m]
    probability: float  #: of the node, against the next one and against other fits
    sure: bool  #: the probability is at least 0.99
    axes: NDArray[np.float64]  #: columns: the sensor's x, y, z in the model's axes


@dataclass(frozen=True)
class PointMatch:
    """Points of a test at the nodes of a model."""

    points: list[MatchedPoint]
    fit: PlaceFit
    other_fits: list[PlaceFit] = field(default_factory=list)  #: that explain the places as well
    noise: float = 0.0  #: standard deviation of a coordinate that the probabilities rest on [m]

    @property
    def nodes(self) -> dict[str, int]:
        """Numbers of the nodes of the points that are sure, as ``read_deck(..., nodes=)`` takes them."""
        return {point.name: point.node for point in self.points if point.sure}

    @property
    def sure(self) -> bool:
        """Whether every point is."""
        return all(point.sure for point in self.points)


def match_points(
    elements: FiniteElements,
    points: Mapping[str, ArrayLike] | str | os.PathLike[str],
    *,
    axes: Mapping[str, ArrayLike] | None = None,
    unit: float = 1.0,
    scale: bool = False,
    noise: float = 0.0,
) -> PointMatch:
    """Find the nodes of a model at which the points of a test sit, whatever the test's origin and axes are.

    Parameters
    ----------
    elements : FiniteElements
        As of :func:`read_deck`.
    points : dict of str to (x, y, z), or path
        Places in the test's axes [m]; or a file with them: a universal file (datasets 15 and 2411), or a table of
        name, x, y, z and where sensors are turned the nine numbers of their axes.
    axes : dict of str to array, shape (3, 3), optional
        Columns: the sensor's x, y and z in the test's axes.
    unit : float
        Length of the coordinates of a file [m], 1e-3 for millimetres.
    scale : bool
        Fit a factor of the test's lengths too, within 10 %.
    noise : float
        Standard deviation of a coordinate [m]; 0: from the fit.

    Returns
    -------
    PointMatch

    Raises
    ------
    InvalidInput
        With fewer than four points, points on one line, or units of length that differ.

    Examples
    --------
    >>> import kalfem as kf, tempfile, os
    >>> file = os.path.join(tempfile.mkdtemp(), "frame.inp")
    >>> with open(file, "w") as deck:
    ...     _ = deck.write("*NODE\\n1, 0, 0, 0\\n2, 2, 0, 0\\n3, 2, 1, 0\\n4, 0, 1, 3\\n*ELEMENT, TYPE=T3D2, ELSET=rod\\n1, 1, 2\\n"
    ...                    "2, 2, 3\\n3, 3, 4\\n4, 4, 1\\n*MATERIAL, NAME=steel\\n*ELASTIC\\n2.1e11, 0.3\\n*DENSITY\\n7850\\n"
    ...                    "*SOLID SECTION, ELSET=rod, MATERIAL=steel\\n1e-4\\n")
    >>> found = kf.match_points(kf.read_deck(file), {"a": (5, 5, 5), "b": (5, 7, 5), "c": (4, 7, 5), "d": (4, 5, 8)})
    >>> found.nodes
    {'a': 1, 'b': 2, 'c': 3, 'd': 4}
    """
    places: Mapping[str, Any]
    if isinstance(points, Mapping):
        places = points
    else:
        places, own = core.read_test_points(os.fspath(points), unit)
        axes = axes or own
    found = core.match_points(elements, dict(places), dict(axes or {}), scale, noise)
    return PointMatch(
        points=[MatchedPoint(**each) for each in found["points"]],
        fit=PlaceFit(**found["fit"]),
        other_fits=[PlaceFit(**each) for each in found["other_fits"]],
        noise=found["noise"],
    )
