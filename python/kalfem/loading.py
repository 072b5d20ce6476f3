# SPDX-License-Identifier: Apache-2.0
"""Finite elements under static loads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .compiled import core
from .errors import unknown_name

if TYPE_CHECKING:
    from ._core import FiniteElements


class Resultant(NamedTuple):
    """Sum of forces and of their moments."""

    force: np.ndarray  #: [N], shape (3,)
    moment: np.ndarray  #: about `about` [N m], shape (3,)
    about: np.ndarray  #: [m], shape (3,)


class NodeStatics(NamedTuple):
    """Motion of a named node, and the stress of the solids and shells that meet there."""

    displacement: np.ndarray  #: x, y, z, rx, ry, rz [m, rad]
    stress: np.ndarray | None  #: xx, yy, zz, xy, yz, xz in global axes [Pa]: the largest mean
    von_mises: float | None  #: of it [Pa]
    layer: str  #: of a shell: ``top``, ``middle`` or ``bottom``


class StressPeak(NamedTuple):
    """The most stressed place of a region."""

    region: str
    stress: float  #: von Mises stress of nodal means; of beams the axial stress with its sign [Pa]
    element: int  #: by the mesh's numbers
    node: int
    layer: str  #: of a shell
    of_beam: bool


@dataclass(frozen=True)
class StaticCase:
    """Equilibrium under one load case."""

    displacements: np.ndarray  #: of every node of the mesh: x, y, z, rx, ry, rz [m, rad], shape (nodes, 6)
    nodes: dict[str, NodeStatics]  #: named nodes
    peaks: list[StressPeak]  #: of each region that has stresses, the largest first
    reactions: dict[str, Resultant]  #: of every support, about the middle of its nodes
    applied: Resultant  #: of all loads, about the middle of the model
    reaction_sum: Resultant  #: of all supports, about the same
    imbalance: float  #: of loads and reactions, relative to the largest force

    def __repr__(self) -> str:
        largest = np.linalg.norm(self.displacements[:, :3], axis=1).max(initial=0.0)
        stress = f", stress {self.peaks[0].stress:.4g} Pa in '{self.peaks[0].region}'" if self.peaks else ""
        return f"StaticCase: largest displacement {largest:.4g} m{stress}"


class Statics(Mapping[str, StaticCase]):
    """Load cases by their names: ``solved["pull"].nodes["tip"].displacement``.

    Attributes
    ----------
    warnings : list of str
        Load cases that are not in equilibrium with their reactions.
    """

    def __init__(self, cases: Mapping[str, StaticCase], warnings: list[str]):
        self._cases, self.warnings = dict(cases), warnings

    def __getitem__(self, name: str) -> StaticCase:
        if name not in self._cases:
            raise unknown_name("load case", name, self._cases)
        return self._cases[name]

    def __iter__(self):
        return iter(self._cases)

    def __len__(self) -> int:
        return len(self._cases)

    def __repr__(self) -> str:
        return "\n".join(f"{name}: {case}" for name, case in self.items())


def _case_of(found: dict[str, Any]) -> StaticCase:
    return StaticCase(
        displacements=found["displacements"],
        nodes={name: NodeStatics(**node) for name, node in found["nodes"].items()},
        peaks=[StressPeak(**peak) for peak in found["peaks"]],
        reactions={name: Resultant(**sum) for name, sum in found["reactions"].items()},
        applied=Resultant(**found["applied"]),
        reaction_sum=Resultant(**found["reaction_sum"]),
        imbalance=found["imbalance"],
    )


def statics(elements: FiniteElements, cases: Mapping[str, Mapping[str, Any]]) -> Statics:
    """Displacements, stresses and reactions of finite elements at full order under static loads.

    Parameters
    ----------
    elements : FiniteElements
        With their supports, see ``fix()``.
    cases : dict of str to dict
        ``{"pull": {"forces": {"tip": (0, 0, "1 kN")}}}``. A load case has some of

        * ``forces`` [N], ``moments`` [N m]: by named node, node number, region or set of nodes, over which the load is
          spread: evenly over lines and surfaces, in equal parts over nodes;
        * ``pressures`` [Pa]: by region of shells, or set of nodes that covers faces;
        * ``gravity`` [m/s^2]: (x, y, z);
        * ``rotation``: ``axis``, ``about`` [m] and ``speed`` [rad/s] of a steady rotation;
        * ``displacements``: imposed, ``{"tip.z": "2 mm"}`` [m], ``"tip.rx"`` [rad].

    Returns
    -------
    Statics
        ``solved["pull"].nodes["tip"].displacement``, ``.displacements``, ``.peaks``, ``.reactions``.

    Raises
    ------
    InvalidInput
        With every argument that is wrong, and where the supports leave a motion free.

    Examples
    --------
    >>> import os, tempfile, kalfem as kf
    >>> file = os.path.join(tempfile.mkdtemp(), "rod.inp")
    >>> with open(file, "w") as deck:
    ...     _ = deck.write("*NODE\\n1, 0, 0, 0\\n2, 1, 0, 0\\n*ELEMENT, TYPE=T3D2, ELSET=rod\\n1, 1, 2\\n"
    ...                    "*MATERIAL, NAME=steel\\n*ELASTIC\\n2e11, 0.3\\n*DENSITY\\n8000\\n"
    ...                    "*SOLID SECTION, ELSET=rod, MATERIAL=steel\\n1e-4\\n"
    ...                    "*BOUNDARY\\n1, 1, 3\\n2, 2, 3\\n")
    >>> rod = kf.read_deck(file, nodes={"tip": 2})
    >>> solved = kf.statics(rod, {"pull": {"forces": {"tip": (1000, 0, 0)}}})
    >>> solved
    pull: StaticCase: largest displacement 5e-05 m
    """
    given = {str(name): dict(case) if isinstance(case, Mapping) else case for name, case in cases.items()}
    solved, warnings = core.statics(elements, given)
    return Statics({name: _case_of(found) for name, found in solved.items()}, list(warnings))
