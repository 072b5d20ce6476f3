# SPDX-License-Identifier: Apache-2.0
"""Where to put sensors, before anything is measured."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .compiled import core
from .progress import reporter

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ._core import Sensor, Structure
    from .analysis import Progress


@dataclass(frozen=True)
class SensorSet:
    """A set of sensors with what it is expected to tell."""

    sensors: list[str]
    rank: int | None  #: among all sets that were tried, from 1; None: it is not among the ranked ones
    criterion: float  #: larger is better
    std: dict[str, float]  #: of each parameter, by the information and its prior
    std_by_filter: dict[str, float]  #: after a run of the filter over the expected record; empty where none was made


@dataclass(frozen=True)
class Placement:
    """Sets of sensors, the best first."""

    best: list[SensorSet]  #: up to 20
    checked: list[SensorSet]  #: sets of all ranks that a filter was run over
    candidates: list[dict[str, Any]]  #: ``name``, ``rank`` alone, ``std_left`` of the priors, ``moves``, ``kept``
    remarks: list[str]  #: what the best set does not determine, in words
    exact: bool  #: every set was tried

    def __repr__(self) -> str:
        return f"Placement({', '.join(self.best[0].sensors)})"


def place(
    structure: Structure,
    t: ArrayLike,
    *,
    sensors: Mapping[str, Sensor],
    unknown: Mapping[str, Any] | Iterable[str],
    count: int,
    keep: Sequence[str] = (),
    parameters: Sequence[str] = (),
    inputs: Mapping[str, ArrayLike] | None = None,
    known_to: Mapping[str, float | str] | None = None,
    process_noise: float | str = 0.0,
    criterion: str = "d_optimality",
    draws: int = 1,
    seed: int = 1,
    threads: int = 0,
    progress: Progress = True,
) -> Placement:
    """Choose the sensors that tell most of the unknowns.

    Parameters
    ----------
    structure : Structure
    t : array, shape (n,)
        Even times of the record that is to come [s].
    sensors : dict of str to Sensor
        All candidates, with their noise.
    unknown : dict of str to prior, or list of str
        As in :func:`estimate`.
    count : int
        Sensors to place, beside those of `keep`.
    keep : list of str
        Candidates that every set holds.
    parameters : list of str
        Unknowns that shall be known well; all if none is given. The others are unknown beside them.
    inputs : dict of str to array of shape (n,)
        Samples of the structure's inputs that have none yet.
    known_to : dict of str to float or str
        Standard deviations of numbers of the structure that are held fixed, as in :func:`estimate`: they are unknown
        beside the others. Gains and delays are taken as exact.
    process_noise : float or str
        Of the filter that checks sets [m/s^2/sqrt(Hz)].
    criterion : str
        ``d_optimality``, ``a_optimality``, ``e_optimality``, ``expected_deviation``, ``mutual_information``.
    draws : int
        Values of the unknowns, from their priors, that the choice is averaged over; 1: the initial values.

    Returns
    -------
    Placement
        ``placement.best[0].sensors``, ``placement.best[0].std``, ``placement.candidates``.

    Examples
    --------
    >>> import numpy as np, kalfem as kf
    >>> s = kf.Structure()
    >>> _ = s.add(kf.chain("c", 3, mass=1.0, stiffness=1e4, damping=2.0))
    >>> _ = s.connect("mount", "c.1", "ground", law="linear", parameters=dict(k=1e4, c=2.0))
    >>> _ = s.force("hammer", "c.3")
    >>> t = np.arange(400) / 200
    >>> f = 10 * np.sin(2 * np.pi * (1 + 5 * t) * t)
    >>> all = {f"a{i}": kf.acceleration(f"c.{i}", noise=0.1) for i in (1, 2, 3)}
    >>> kf.place(s, t, sensors=all, unknown={"mount.k": (1e4, "20 %")}, count=1, inputs={"hammer": f}, progress=False)
    Placement(a3)
    """
    arguments = {
        "sensors": dict(sensors),
        "unknown": dict(unknown) if isinstance(unknown, Mapping) else list(unknown),
        "outputs": {},
        "filter": "auto",
        "initial_state": {},
        "process_noise": process_noise,
        "known_to": dict(known_to or {}),
        "threads": threads,
    }
    choice = {
        "count": count,
        "keep": list(keep),
        "parameters": list(parameters),
        "criterion": criterion,
        "draws": draws,
        "seed": seed,
    }
    with reporter(progress) as bar:
        found = core.place(structure, t, dict(inputs or {}), arguments, choice, bar)
    return Placement(
        best=[SensorSet(**each) for each in found["best"]],
        checked=[SensorSet(**each) for each in found["checked"]],
        candidates=list(found["candidates"]),
        remarks=list(found["remarks"]),
        exact=found["exact"],
    )
